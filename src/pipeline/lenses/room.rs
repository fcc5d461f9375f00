//! The world of cameras that were placed by a person: z up, the floor at z = 0, x along the walk, metres.
//!
//! *Up.* On the mean over all frames a person is upright: u leads from the middle of the ankles to the neck, with a standard deviation of 3° (people
//! lean forward as they walk). The floor is where the feet are: of each ankle, in each second, the mean p of the lowest third of its places. With σ = 2 cm
//!
//! n = argmin Σ (n·(p − p̄))²/σ² + ‖n − u‖²/σ_u².
//!
//! *Floor.* An ankle's centre stands .039 of the stature above the ground.
//!
//! *x* is the direction in which the middle of the trunk has its largest spread, from where it was first to where it was last; the origin
//! lies below its mean.
//!
//! # Source
//! .039: Winter 2009, *Biomechanics and motor control of human movement*, fig. 4.1 (after Drillis & Contini 1966). σ and σ_u: E.

use nalgebra::{Matrix3, Point3, Rotation3, SymmetricEigen, Translation3, UnitQuaternion, Vector3};

use super::bundle::Placed;
use super::sights::Sights;
use crate::inference::joints::Joints;
use crate::math::Rigid3;

/// σ_u.
const LEAN_SD: f64 = 3.0 * std::f64::consts::PI / 180.0;
/// σ, metres.
const FLOOR_SD_M: f64 = 0.02;
/// The height of an ankle over the stature.
const ANKLE: f64 = 0.039;
/// Of the places of an ankle in a second, so many are on the floor.
const ON_FLOOR: usize = 3;

/// The joints of one person in each frame, as far as they are known.
pub(super) fn joints_of_frames(sights: &Sights, placed: &Placed) -> Vec<Joints> {
    let joints = sights.joints.len();
    let of_frame = |frame: usize| {
        let all = sights.joints.iter().enumerate();
        let place =
            |(k, name): (usize, &&'static str)| Some((*name, placed.joints[frame * joints + k]?));
        Joints { places: all.filter_map(place).collect() }
    };
    (0..sights.frames).map(of_frame).collect()
}

/// A person's walk in the frame of the cameras, in metres, of so many frames a second.
pub(super) struct Walk<'a> {
    pub(super) frames: &'a [Joints],
    pub(super) fps: f64,
    pub(super) stature_m: f64,
}

impl Walk<'_> {
    /// The pose of the world's frame: `world_from_cameras`; `None` where the person's ankles and neck are never seen.
    pub(super) fn world_from_cameras(&self) -> Option<Rigid3> {
        let leaning = self.frames.iter().filter_map(upright);
        let up = leaning.sum::<Vector3<f64>>().try_normalize(f64::EPSILON)?;
        let feet = self.on_floor(&up);
        let middle = feet.iter().sum::<Vector3<f64>>() / feet.len().max(1) as f64;
        let spread: Matrix3<f64> =
            feet.iter().map(|p| (p - middle) * (p - middle).transpose()).sum();
        let lean = Matrix3::identity() / LEAN_SD.powi(2);
        let normal = spread / FLOOR_SD_M.powi(2) + lean;
        let up = normal.cholesky()?.solve(&(up / LEAN_SD.powi(2))).try_normalize(f64::EPSILON)?;

        // along the walk
        let walked = self.frames.iter().filter(|joints| !joints.places.is_empty());
        let trunk: Vec<Vector3<f64>> = walked.map(|joints| joints.middle().coords).collect();
        let mean = trunk.iter().sum::<Vector3<f64>>() / trunk.len().max(1) as f64;
        let across = |v: Vector3<f64>| v - up * up.dot(&v);
        let spread: Matrix3<f64> =
            trunk.iter().map(|p| across(p - mean)).map(|p| p * p.transpose()).sum();
        let eigen = SymmetricEigen::new(spread);
        let along = eigen.eigenvectors.column(eigen.eigenvalues.imax()).into_owned();
        let walked = trunk.last()? - trunk.first()?;
        let x = across(along * walked.dot(&along).signum()).try_normalize(f64::EPSILON)?;

        let floor = up.dot(&middle) - ANKLE * self.stature_m;
        let origin = mean - up * (up.dot(&mean) - floor);
        let axes = Rotation3::from_matrix_unchecked(
            Matrix3::from_columns(&[x, up.cross(&x), up]).transpose(),
        );
        let turn = UnitQuaternion::from_rotation_matrix(&axes);
        Some(turn * Translation3::from(-origin))
    }

    /// p of each ankle in each second.
    fn on_floor(&self, up: &Vector3<f64>) -> Vec<Vector3<f64>> {
        let second = (self.fps.round() as usize).max(1);
        let of_second = |frames: &[Joints]| {
            let of_ankle = |name: &str| {
                let mut all: Vec<Point3<f64>> =
                    frames.iter().filter_map(|joints| joints.place(name)).collect();
                all.sort_by(|a, b| up.dot(&a.coords).total_cmp(&up.dot(&b.coords)));
                let count = all.len() / ON_FLOOR;
                let sum = all.iter().take(count).map(|p| p.coords).sum::<Vector3<f64>>();
                (count > 0).then(|| sum / count as f64)
            };
            ["RAnkle", "LAnkle"].map(of_ankle)
        };
        self.frames.chunks(second).flat_map(of_second).flatten().collect()
    }
}

/// From the middle of the ankles to the neck, or to the middle of the shoulders.
fn upright(joints: &Joints) -> Option<Vector3<f64>> {
    let middle = |a: &str, b: &str| Some((joints.place(a)?.coords + joints.place(b)?.coords) / 2.0);
    let neck = joints.place("Neck").map(|place| place.coords);
    let up = neck.or_else(|| middle("RShoulder", "LShoulder"))? - middle("RAnkle", "LAnkle")?;
    up.try_normalize(f64::EPSILON)
}
