//! What of the cameras is unknown, and how far they may be off.
//!
//! Most cameras are where their calibration says, within a usual one's errors; some were touched, by more than those errors tell.
//! That is Student's t of one degree of freedom, for the turn and displacement of a camera together, and for its clock,
//!
//! −log p = ½(1 + d) ln(1 + z²),  z² = Σ (x/σ)² over d components,
//!
//! whose weight (1 + d)/(1 + z²) leaves a touched camera free. So the cameras that are well hold the world and its time; what is
//! common to all of them is left to this prior. σ (E): 0.1° and 3 mm along each axis; of a clock, which was set to the nearest frame,
//! the interval of frames over √12. Focal lengths have a prior of their own ([`lens_prior`]).
//!
//! Of cameras that were placed by detections σ is so wide that it says next to nothing. Then nothing would hold the world itself, and a smaller one has
//! smaller residuals: so what all cameras have in common ([`RigMotion`]) is normal, with a usual calibration's σ.
//!
//! # Which cameras
//! A camera that nothing crosses is held: the depth at which cameras side by side see a person is as uncertain as their turns, so their
//! calibration must be trusted. The pose of a camera is free if two others look across its line of sight, its clock if one does
//! ([`Free::crossed`]). What is surely off shows without that, if enough cameras see the person ([`Free::shown`]): pictures of two moments of a
//! walk fit a body at no depth.
//!
//! # Source
//! Lange, Little, Taylor 1989, *Robust statistical modeling using the t distribution*.

use std::ops::Range;

use nalgebra::{DVectorView, Matrix3, SVector, Vector3};
use serde::{Deserialize, Serialize};

use super::camera_offset::{AHEAD, COMPONENTS, CameraOffset, ZOOM};
use super::lens_prior;
use super::rig_motion::{HeldWorld, RigMotion};
use crate::body::Motion;
use crate::camera::{Camera, Rig};
use crate::math::rotation::right_jacobian_inverse;
use crate::solver::NormalEquations;

/// What of a camera is unknown.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Free {
    /// Turn, displacement and focal length.
    pub pose: bool,
    /// How far it is ahead.
    pub clock: bool,
}

impl Free {
    /// Of what is `allowed`, what the rig can tell of each camera about a body with this motion.
    pub fn crossed<'m>(
        rig: &Rig,
        motions: impl ExactSizeIterator<Item = &'m Motion>,
        allowed: Self,
    ) -> Vec<Self> {
        let count = motions.len().max(1) as f64;
        let places = motions.map(|motion| motion.position_world);
        let subject = places.sum::<Vector3<f64>>() / count;
        let sights: Vec<Vector3<f64>> =
            rig.cameras.iter().map(|camera| subject - camera.centre_world().coords).collect();
        let crosses = |a: &Vector3<f64>, b: &Vector3<f64>| {
            let angle = a.angle(b);
            angle.min(std::f64::consts::PI - angle) > ACROSS_RAD
        };
        let of_camera = |sight: &Vector3<f64>| {
            let across = sights.iter().filter(|other| crosses(sight, other)).count();
            Self { pose: allowed.pose && across >= 2, clock: allowed.clock && across >= 1 }
        };
        sights.iter().map(of_camera).collect()
    }

    /// Of what is `allowed`, what so many cameras can contradict each other about, whether they cross or not.
    pub fn shown(cameras: usize, allowed: Self) -> Self {
        Self { pose: allowed.pose && cameras >= 3, clock: allowed.clock && cameras >= 2 }
    }

    /// What is free in either.
    #[must_use]
    pub fn or(self, other: Self) -> Self {
        Self { pose: self.pose || other.pose, clock: self.clock || other.clock }
    }
}

/// σ of a turn about one axis.
pub const TURN_SD: f64 = 0.1 * std::f64::consts::PI / 180.0;
/// σ of a displacement along one axis, metres.
pub const DISPLACEMENT_SD_M: f64 = 0.003;
/// Lines of sight at a larger angle than this cross, so that one says where along the other a body stands.
const ACROSS_RAD: f64 = 0.35;

/// What a calibration errs by: σ about and along each axis.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PoseErrors {
    /// Of a turn, degrees.
    pub turn_deg: f64,
    /// Of a displacement, metres.
    pub displacement_m: f64,
}

impl Default for PoseErrors {
    /// Those of a usual calibration.
    fn default() -> Self {
        Self { turn_deg: TURN_SD.to_degrees(), displacement_m: DISPLACEMENT_SD_M }
    }
}

/// p(c): what of each camera is unknown, and how far it may be off.
#[derive(Debug, Clone, PartialEq)]
pub struct CameraPrior {
    /// In the order of the rig; empty where all are trusted.
    cameras: Vec<Unknown>,
    /// Components of all of them.
    components: usize,
    /// What holds the world, where σ does not.
    held: Option<HeldWorld>,
}

/// What of a camera is unknown, and where it stands among the components.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Unknown {
    free: Free,
    /// σ of its clock, seconds.
    ahead_sd_s: f64,
    /// σ of its turn and displacement.
    errors: PoseErrors,
    rows: CameraRows,
    /// ζ of the lens that its looks have, over the calibrated one.
    zoomed: f64,
    /// Whether its pose is that of a camera before it.
    has_pose_of_another: bool,
}

/// Where the components of a camera stand among those of all.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CameraRows {
    /// The first of ω, δt, δζ.
    pose: usize,
    /// δτ.
    clock: usize,
}

impl CameraRows {
    /// In the order of the components.
    pub(super) fn all(self) -> [usize; COMPONENTS] {
        std::array::from_fn(|k| if k == AHEAD { self.clock } else { self.pose + k })
    }

    /// Its own of the components of all cameras.
    pub(super) fn of(self, shared: &DVectorView<'_, f64>) -> SVector<f64, COMPONENTS> {
        self.all().map(|row| shared[row]).into()
    }
}

impl CameraPrior {
    /// Every camera is where and when its calibration says.
    pub fn trusting() -> Self {
        Self { cameras: Vec::new(), components: 0, held: None }
    }

    /// Of what is free of each camera; frames are `interval_s` apart.
    pub fn freeing(free: &[Free], interval_s: f64) -> Self {
        if free.iter().all(|free| *free == Free::default()) {
            return Self::trusting();
        }
        let ahead_sd_s = interval_s / 12.0_f64.sqrt();
        Self::of(free.iter().map(|free| (*free, ahead_sd_s, None)))
    }

    /// Of several trials, each with the number of its cameras, one after the other. `same(i)` is the camera of an earlier trial that
    /// camera i is, counted through all of them: it has not moved since, so both have one pose, which is free if it is in any of
    /// the trials. Its clock was started anew and is its own.
    pub fn of_trials(trials: &[(Self, usize)], same: impl Fn(usize) -> Option<usize>) -> Self {
        if trials.iter().all(|(prior, _)| prior.is_trusting()) {
            return Self::trusting();
        }
        let known = |prior: &Self, camera: usize| {
            let unknown = prior.cameras.get(camera);
            unknown.map_or((Free::default(), 1.0), |unknown| (unknown.free, unknown.ahead_sd_s))
        };
        let cameras = trials.iter().flat_map(|(prior, cameras)| {
            (0..*cameras).map(|camera| known(prior, camera)).collect::<Vec<_>>()
        });
        let mut cameras: Vec<(Free, f64)> = cameras.collect();

        // the last first: what is told of a camera is told of the first that it is
        for i in (0..cameras.len()).rev() {
            if let Some(first) = same(i) {
                cameras[first].0.pose |= cameras[i].0.pose;
            }
        }
        for i in 0..cameras.len() {
            if let Some(first) = same(i) {
                cameras[i].0.pose = cameras[first].0.pose;
            }
        }
        let each = cameras.into_iter().enumerate();
        Self::of(each.map(|(i, (free, ahead_sd_s))| (free, ahead_sd_s, same(i))))
    }

    /// What is free of each camera, σ of its clock, and the camera before it whose pose it has.
    fn of(each: impl Iterator<Item = (Free, f64, Option<usize>)>) -> Self {
        let (mut cameras, mut components) = (Vec::<Unknown>::new(), 0);
        for (free, ahead_sd_s, same) in each {
            let pose = same.map(|camera| cameras[camera].rows.pose);
            let own = if pose.is_some() { 0 } else { AHEAD };
            let rows = CameraRows { pose: pose.unwrap_or(components), clock: components + own };
            let (errors, has_pose_of_another) = (PoseErrors::default(), pose.is_some());
            cameras.push(Unknown {
                free,
                ahead_sd_s,
                errors,
                rows,
                zoomed: 0.0,
                has_pose_of_another,
            });
            components += own + 1;
        }
        Self { cameras, components, held: None }
    }

    /// Of some of the cameras, each with a pose of its own.
    #[must_use]
    pub fn of_some(&self, cameras: Range<usize>) -> Self {
        let some = self.cameras.get(cameras).unwrap_or(&[]);
        Self::of(some.iter().map(|unknown| (unknown.free, unknown.ahead_sd_s, None)))
    }

    /// The same of a calibration of these cameras that errs so. If all of them are unknown and it is no usual one, the world is held.
    #[must_use]
    pub fn with_errors(mut self, errors: PoseErrors, rig: &Rig) -> Self {
        let is_loose = errors != PoseErrors::default()
            && !self.is_trusting()
            && self.cameras.iter().all(|unknown| unknown.free.pose);
        let centres: Vec<_> = rig.cameras.iter().map(Camera::centre_world).collect();
        let motion = is_loose.then(|| RigMotion::new(&centres)).flatten();
        let held = motion.map(|motion| HeldWorld::new(motion, TURN_SD, DISPLACEMENT_SD_M));
        self.cameras.iter_mut().for_each(|unknown| unknown.errors = errors);
        Self { held, ..self }
    }

    /// The same of looks by cameras whose focal lengths are already e^ζ times the calibrated ones.
    #[must_use]
    pub fn with_zooms(mut self, zooms: &[f64]) -> Self {
        for (unknown, zoom) in self.cameras.iter_mut().zip(zooms) {
            unknown.zoomed = *zoom;
        }
        self
    }

    /// Whether nothing is unknown.
    pub fn is_trusting(&self) -> bool {
        self.cameras.is_empty()
    }

    /// Number of the cameras that have components.
    pub(super) fn cameras(&self) -> usize {
        self.cameras.len()
    }

    /// Number of the components of all cameras.
    pub(super) fn components(&self) -> usize {
        self.components
    }

    /// Where those of a camera stand.
    pub(super) fn rows(&self, camera: usize) -> CameraRows {
        self.cameras[camera].rows
    }

    /// What of a camera is unknown.
    pub fn free(&self, camera: usize) -> Free {
        self.cameras.get(camera).map(|unknown| unknown.free).unwrap_or_default()
    }

    /// Whether any clock is unknown.
    pub(super) fn has_clocks(&self) -> bool {
        self.cameras.iter().any(|unknown| unknown.free.clock)
    }

    /// −log p, 0 where nothing is off.
    pub(super) fn cost(&self, cameras: &[CameraOffset]) -> f64 {
        let each = cameras.iter().zip(&self.cameras);
        let each: f64 = each.map(|(offset, unknown)| unknown.cost(offset)).sum();
        each + self.held.as_ref().map_or(0.0, |held| held.cost(&poses(cameras)))
    }

    /// The same, with gradient and Gauss–Newton matrix added to the components from `first` on. Those that are not free stay where
    /// they are.
    pub(super) fn linearize(
        &self,
        cameras: &[CameraOffset],
        first: usize,
        equations: &mut NormalEquations,
    ) -> f64 {
        for (offset, unknown) in cameras.iter().zip(&self.cameras) {
            unknown.linearize(offset, first, equations);
        }
        if let Some(held) = &self.held {
            held.linearize(&poses(cameras), (first, COMPONENTS), equations);
        }
        self.cost(cameras)
    }
}

impl Unknown {
    /// 1/σ² of turns and displacements.
    fn weights(&self) -> (f64, f64) {
        (self.errors.turn_deg.to_radians().powi(-2), self.errors.displacement_m.powi(-2))
    }

    fn cost(&self, offset: &CameraOffset) -> f64 {
        let (pose, ahead) = self.squares(offset);
        let student = |is_free: bool, d: f64, square: f64| match is_free {
            true => 0.5 * (1.0 + d) * square.ln_1p(),
            false => 0.0,
        };
        let is_own = self.free.pose && !self.has_pose_of_another;
        let of_lens = if is_own { lens_prior::cost(self.log_zoom(offset)) } else { 0.0 };
        student(is_own, 6.0, pose) + of_lens + student(self.free.clock, 1.0, ahead)
    }

    fn linearize(&self, offset: &CameraOffset, first: usize, equations: &mut NormalEquations) {
        let (pose, ahead) = self.squares(offset);
        let held = |is_free: bool| if is_free { 0.0 } else { 1.0 };

        let clock = first + self.rows.clock;
        let weight = if self.free.clock { 2.0 / (1.0 + ahead) } else { 0.0 };
        let of_clock = weight / self.ahead_sd_s.powi(2);
        equations.gradient[clock] += of_clock * offset.ahead_s;
        equations.hessian[(clock, clock)] += of_clock + held(self.free.clock);
        if self.has_pose_of_another {
            return;
        }

        let zoom_row = first + self.rows.pose + ZOOM;
        let zoom = self.log_zoom(offset);
        let of_zoom = if self.free.pose { lens_prior::weight(zoom) } else { 0.0 };
        equations.gradient[zoom_row] += of_zoom * zoom;
        equations.hessian[(zoom_row, zoom_row)] += of_zoom + held(self.free.pose);

        let turn = offset.turn.scaled_axis();
        // log(exp(ω)R) = φ + J_r⁻¹(−φ) ω
        let by_turn = right_jacobian_inverse(&-turn);
        let weight = if self.free.pose { 7.0 / (1.0 + pose) } else { 0.0 };
        let (of_turn, of_place) = self.weights();
        let (of_turn, of_place) = (weight * of_turn, weight * of_place);
        let first = first + self.rows.pose;
        let mut gradient = equations.gradient.rows_mut(first, ZOOM);
        gradient.rows_mut(0, 3).gemv_tr(of_turn, &by_turn, &turn, 1.0);
        gradient.rows_mut(3, 3).axpy(of_place, &offset.displacement_m, 1.0);

        let mut hessian = equations.hessian.view_mut((first, first), (ZOOM, ZOOM));
        let one = Matrix3::identity();
        let mut turns = hessian.fixed_view_mut::<3, 3>(0, 0);
        turns += by_turn.transpose() * by_turn * of_turn + one * held(self.free.pose);
        let mut places = hessian.fixed_view_mut::<3, 3>(3, 3);
        places += one * (of_place + held(self.free.pose));
    }

    /// ζ against the calibrated lens.
    fn log_zoom(&self, offset: &CameraOffset) -> f64 {
        self.zoomed + offset.log_zoom
    }

    /// z² of turn and displacement, and of the clock.
    fn squares(&self, offset: &CameraOffset) -> (f64, f64) {
        let (of_turn, of_place) = self.weights();
        let turn = offset.turn.scaled_axis().norm_squared() * of_turn;
        let place = offset.displacement_m.norm_squared() * of_place;
        (turn + place, (offset.ahead_s / self.ahead_sd_s).powi(2))
    }
}

/// Turns and displacements.
fn poses(cameras: &[CameraOffset]) -> Vec<[Vector3<f64>; 2]> {
    cameras.iter().map(|offset| [offset.turn.scaled_axis(), offset.displacement_m]).collect()
}
