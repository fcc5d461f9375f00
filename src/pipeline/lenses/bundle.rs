//! All cameras and all joints at once: the bundle adjustment.
//!
//! Camera c has the pose X_c = R_c X + t_c, joint j of all frames the place X_j, and u_cj is where the camera sees it, a normalised image point:
//!
//! E = Σ ½ ρ(‖e_cj‖²/σ_cj²),  e_cj = u_cj − (X_c/Z_c, Y_c/Z_c).
//!
//! With X_c ← exp(ω)X_c + δ, ω and δ of the camera's own frame, ∂X_c = −\[X_c\]ω + δ + R_c ∂X_j. A joint behind a camera costs a constant.
//! Each joint is a link of a [`BorderedChain`] that is coupled to no other, and the cameras are its border.
//!
//! # What the motion determines
//! World and scale are free, seven numbers. The cameras' reduced matrix S = C − Σ_j B_j A_j⁻¹ B_jᵀ loses just those; its pseudoinverse is the
//! covariance relative to the rig itself (the free network of geodesy: mean square of all standard deviations least).
//! Displacements count over the rig's size there.
//!
//! # Source
//! Triggs et al. 2000, *Bundle adjustment: a modern synthesis*, § 6 and § 9 (inner constraints).

use nalgebra::{
    DMatrix, DVector, Matrix2x3, Matrix3, Point3, SymmetricEigen, Translation3, UnitQuaternion,
    Vector2, Vector3,
};

use super::sights::{Sight, Sights};
use crate::camera::{Ray, closest_point};
use crate::math::Rigid3;
use crate::math::stats::median;
use crate::solver::{BorderedChain, Loss, Options, Problem, Solution, levenberg_marquardt};

/// ω and δ of a camera.
pub(super) const POSE: usize = 6;
/// World and scale.
const FREE: usize = 7;
/// What a joint behind a camera is off by, standard deviations.
const BEHIND: f64 = 100.0;
/// Joints nearer than this to a camera's plane, over the distance unit, are behind it.
const NEAREST: f64 = 1e-6;
/// As of the keypoint likelihood.
const LOSS: Loss = Loss::Cauchy(3.0);

/// Cameras that are placed, and the joints that at least two of them see.
#[derive(Debug, Clone)]
pub(super) struct Placed {
    /// `camera_from_world` by camera; `None` where it is not known yet.
    pub(super) poses: Vec<Option<Rigid3>>,
    /// The place of each joint of [`Sights`]; `None` where no two cameras see it.
    pub(super) joints: Vec<Option<Point3<f64>>>,
}

impl Placed {
    /// Cameras, and joints where their lines of sight meet.
    pub(super) fn new(sights: &Sights, poses: Vec<Option<Rigid3>>) -> Self {
        let meeting = |joint: usize| meeting(sights, &poses, joint);
        let joints = (0..sights.count()).map(meeting).collect();
        Self { poses, joints }
    }
}

/// Where the lines of sight to a joint meet, before all of the cameras.
fn meeting(sights: &Sights, poses: &[Option<Rigid3>], joint: usize) -> Option<Point3<f64>> {
    let seeing = || {
        let all = poses.iter().zip(&sights.cameras);
        all.filter_map(move |(pose, seen)| Some((pose.as_ref()?, seen[joint].as_ref()?)))
    };
    let rays: Vec<Ray> = seeing().map(|(pose, sight)| ray(pose, sight)).collect();
    let place = closest_point(&rays)?;
    seeing().all(|(pose, _)| (pose * place).z > NEAREST).then_some(place)
}

/// The line of sight to what a camera sees.
pub(super) fn ray(pose: &Rigid3, sight: &Sight) -> Ray {
    let world_from_camera = pose.inverse();
    Ray {
        origin_world: Point3::from(world_from_camera.translation.vector),
        direction_world: nalgebra::Unit::new_normalize(
            world_from_camera.rotation * sight.at.to_homogeneous(),
        ),
    }
}

/// e of a sight; `None` behind the camera.
pub(super) fn off(pose: &Rigid3, sight: &Sight, place: &Point3<f64>) -> Option<Vector2<f64>> {
    let own = pose * place;
    (own.z > NEAREST).then(|| sight.at.coords - own.coords.xy() / own.z)
}

/// The problem: which cameras see which joints.
pub(super) struct Bundle {
    cameras: usize,
    /// By joint: the position of each camera that sees it, and what it sees.
    joints: Vec<Vec<(usize, Sight)>>,
}

/// Poses and places of a [`Bundle`].
#[derive(Debug, Clone)]
pub(super) struct BundleState {
    poses: Vec<Rigid3>,
    places: Vec<Point3<f64>>,
}

impl Bundle {
    /// Of the cameras that are placed and the joints whose places are known; with them, in which order they are taken.
    fn new(sights: &Sights, placed: &Placed) -> (Self, BundleState, [Vec<usize>; 2]) {
        let known = |all: Vec<bool>| -> Vec<usize> { (0..all.len()).filter(|i| all[*i]).collect() };
        let cameras = known(placed.poses.iter().map(Option::is_some).collect());
        let joints = known(placed.joints.iter().map(Option::is_some).collect());
        let sight = |joint: usize| {
            let seen = |(k, camera): (usize, &usize)| Some((k, sights.cameras[*camera][joint]?));
            cameras.iter().enumerate().filter_map(seen).collect()
        };
        let bundle = Self {
            cameras: cameras.len(),
            joints: joints.iter().map(|joint| sight(*joint)).collect(),
        };
        let state = BundleState {
            poses: placed.poses.iter().flatten().copied().collect(),
            places: placed.joints.iter().flatten().copied().collect(),
        };
        (bundle, state, [cameras, joints])
    }

    /// Where cameras and joints fit best to all that is seen; the cost and, of all cameras, the covariance.
    pub(super) fn adjusted(sights: &Sights, placed: &Placed, iterations: usize) -> Adjusted {
        let (bundle, state, [cameras, joints]) = Self::new(sights, placed);
        let options =
            Options { max_iterations: iterations, relative_decrease: 1e-7, ..Options::default() };
        let Solution { state, cost, model, .. } = levenberg_marquardt(&bundle, state, &options);
        let mut placed = placed.clone();
        cameras.iter().zip(&state.poses).for_each(|(i, pose)| placed.poses[*i] = Some(*pose));
        joints.iter().zip(&state.places).for_each(|(i, at)| placed.joints[*i] = Some(*at));
        let seen = bundle.joints.iter().map(Vec::len).sum();
        Adjusted { cost, seen, size: state.size(), model, placed }
    }
}

/// What a bundle adjustment gives.
pub(super) struct Adjusted {
    /// E.
    cost: f64,
    /// Sights.
    seen: usize,
    /// The cameras' median distance from their middle.
    size: f64,
    model: BorderedChain,
    /// Cameras and joints.
    pub(super) placed: Placed,
}

impl Adjusted {
    /// E for each sight.
    pub(super) fn mean_cost(&self) -> f64 {
        self.cost / self.seen.max(1) as f64
    }

    /// Sights.
    pub(super) fn seen(&self) -> usize {
        self.seen
    }

    /// The covariance of ω and δ of all cameras that are placed, relative to the rig, of sights that err independently.
    pub(super) fn covariance(&self) -> DMatrix<f64> {
        let mut reduced = self.model.corner.clone();
        reduced.fill_upper_triangle_with_lower_triangle();
        for link in &self.model.links {
            let mut own: Matrix3<f64> = link.diagonal.fixed_view::<3, 3>(0, 0).into_owned();
            own.fill_upper_triangle_with_lower_triangle();
            if let Some(factor) = own.cholesky() {
                reduced -= &link.border * factor.solve(&link.border.transpose());
            }
        }
        let unit = |k: usize| if k % POSE < 3 { 1.0 } else { self.size };
        let n = reduced.nrows();
        let scaled = DMatrix::from_fn(n, n, |i, j| unit(i) * unit(j) * reduced[(i, j)]);
        let eigen = SymmetricEigen::new(scaled);
        let mut order: Vec<usize> = (0..n).collect();
        order.sort_by(|a, b| eigen.eigenvalues[*a].total_cmp(&eigen.eigenvalues[*b]));

        let mut covariance = DMatrix::zeros(n, n);
        for k in order.into_iter().skip(FREE) {
            let v = eigen.eigenvectors.column(k);
            covariance += v * v.transpose() / eigen.eigenvalues[k].max(f64::MIN_POSITIVE);
        }
        DMatrix::from_fn(n, n, |i, j| unit(i) * unit(j) * covariance[(i, j)])
    }
}

impl BundleState {
    fn size(&self) -> f64 {
        let centre = |pose: &Rigid3| pose.inverse().translation.vector;
        let centres: Vec<Vector3<f64>> = self.poses.iter().map(centre).collect();
        let middle = centres.iter().sum::<Vector3<f64>>() / centres.len().max(1) as f64;
        median(&mut centres.iter().map(|c| (c - middle).norm()).collect()).unwrap_or(1.0)
    }
}

impl Problem for Bundle {
    type State = BundleState;
    type Model = BorderedChain;

    fn empty_model(&self) -> BorderedChain {
        BorderedChain::zeros(self.joints.len(), 3, POSE * self.cameras, 0)
    }

    fn cost(&self, x: &BundleState) -> f64 {
        let of_sight = |place: &Point3<f64>, (camera, sight): &(usize, Sight)| {
            let off = off(&x.poses[*camera], sight, place);
            0.5 * LOSS.evaluate(off.map_or(BEHIND, |e| e.norm() / sight.sigma)).0
        };
        let all = self.joints.iter().zip(&x.places);
        all.flat_map(|(seen, place)| seen.iter().map(move |sight| of_sight(place, sight))).sum()
    }

    fn linearize(&self, x: &BundleState, model: &mut BorderedChain) -> f64 {
        let mut cost = 0.0;
        for ((seen, place), link) in self.joints.iter().zip(&x.places).zip(&mut model.links) {
            for (camera, sight) in seen {
                let pose = &x.poses[*camera];
                let Some(e) = off(pose, sight, place) else {
                    cost += 0.5 * LOSS.evaluate(BEHIND).0;
                    continue;
                };
                let (loss, weight) = LOSS.evaluate(e.norm() / sight.sigma);
                cost += 0.5 * loss;
                let weight = weight / (sight.sigma * sight.sigma);

                // ∂e by X_c, and by everything else through it
                let own = pose * place;
                let (x, y, z) = (own.x / own.z, own.y / own.z, own.z);
                let by_own = -Matrix2x3::new(1.0, 0.0, -x, 0.0, 1.0, -y) / z;
                let by_place = by_own * pose.rotation.to_rotation_matrix().matrix();
                let by_turn = -by_own * own.coords.cross_matrix();

                let at = POSE * camera;
                let diagonal = weight * by_place.transpose() * by_place;
                link.diagonal += diagonal;
                link.gradient += weight * by_place.transpose() * e;
                for (first, by) in [(at, by_turn), (at + 3, by_own)] {
                    let mut border = link.border.fixed_view_mut::<3, 3>(first, 0);
                    border += weight * by.transpose() * by_place;
                    let mut gradient = model.corner_gradient.fixed_rows_mut::<3>(first);
                    gradient += weight * by.transpose() * e;
                    let mut corner = model.corner.fixed_view_mut::<3, 3>(first, first);
                    corner += weight * by.transpose() * by;
                }
                let mut corner = model.corner.fixed_view_mut::<3, 3>(at + 3, at);
                corner += weight * by_own.transpose() * by_turn;
            }
        }
        cost
    }

    fn retract(&self, x: &BundleState, delta: &DVector<f64>) -> BundleState {
        let three = |first: usize| delta.fixed_rows::<3>(first).into_owned();
        let border = 3 * x.places.len();
        let places = x.places.iter().enumerate().map(|(j, place)| place + three(3 * j));
        let moved = |(c, pose): (usize, &Rigid3)| {
            let (turn, way) = (three(border + POSE * c), three(border + POSE * c + 3));
            let turn = UnitQuaternion::from_scaled_axis(turn);
            Translation3::from(way) * turn * pose
        };
        BundleState {
            poses: x.poses.iter().enumerate().map(moved).collect(),
            places: places.collect(),
        }
    }
}

/// Hands a bundle and its state to a test.
#[cfg(test)]
pub(super) fn check(sights: &Sights, placed: &Placed, with: impl Fn(&Bundle, &BundleState)) {
    let (bundle, state, _) = Bundle::new(sights, placed);
    with(&bundle, &state);
}
