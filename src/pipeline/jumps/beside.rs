//! By how far what a camera shows lies beside the body, and by how much it is ahead.
//!
//! What one view shows of the body alone moves it by a Gauss–Newton step. With g and H its part of the equations, all residuals squared, the step
//! along the camera's rows and columns A and the one along the body's own velocity v are
//!
//! d = −(Aᵀ H A)⁻¹ Aᵀ g,  τ = −vᵀg/(vᵀ H v + 1/σ_τ²):
//!
//! d metres at the person, τ the seconds by which the view is ahead. Of somebody who stands still σ_τ, a frame, says that τ is not known.

use nalgebra::{Matrix3x2, Point2, Point3, Vector2};
use rayon::prelude::*;

use crate::body::{Layout, Motion, Posed};
use crate::camera::{Camera, CameraId, Rig};
use crate::inference::instant::{Instant, times_s};
use crate::inference::{Detail, Evidence, Look, Sequence};
use crate::pipeline::estimate::Estimate;
use crate::silhouette::{FrameIndex, FrameObservations};
use crate::solver::NormalEquations;

/// What a camera shows in one frame.
#[derive(Debug, Clone, Copy)]
pub(super) struct Beside {
    pub(super) frame: FrameIndex,
    /// d before the camera as it is calibrated, metres.
    pub(super) offset_m: Vector2<f64>,
    /// τ over the interval of frames.
    pub(super) ahead_frames: f64,
    /// How far the person is from the camera, metres.
    pub(super) depth_m: f64,
}

/// An estimate, of which each camera shows its own moment.
pub(super) struct Moments<'a> {
    /// Before the cameras where they were found to be.
    pub(super) evidence: &'a Evidence<'a>,
    estimate: &'a Estimate,
    sequence: Sequence<'a>,
    motions: Vec<Motion>,
    times_s: Vec<f64>,
}

impl<'a> Moments<'a> {
    /// Of the frames that are looked at, with the numbers of those of the estimate.
    pub(super) fn new(
        evidence: &'a Evidence<'a>,
        estimate: &'a Estimate,
        sequence: Sequence<'a>,
    ) -> Self {
        let motions = estimate.frames.iter().map(|fit| fit.motion.clone()).collect();
        let times_s = times_s(&sequence.intervals_s());
        Self { evidence, estimate, sequence, motions, times_s }
    }

    /// The body that a camera shows so many frames after a position; `None` before or after the recording.
    pub(super) fn later(&self, id: CameraId, position: usize, frames: isize) -> Option<Instant> {
        let time_s = self.times_s[position] + frames as f64 / self.sequence.fps;
        let half_s = 0.5 / self.sequence.fps;
        let is_recorded = -half_s < time_s && time_s < self.times_s.last()? + half_s;
        let ahead_s = self.estimate.cameras[id.0].offset().ahead_s;
        let layout = Layout::new(self.evidence.model);
        is_recorded.then(|| Instant::at(layout, &self.motions, &self.times_s, time_s + ahead_s))
    }

    /// Each frame in which a camera shows something, its position, and what it shows.
    pub(super) fn looks(&self, id: CameraId) -> Vec<(FrameIndex, usize, Vec<Look<'a>>)> {
        let of_frame = |(i, frame): (usize, &'a FrameObservations)| {
            let mut looks = self.evidence.looks(frame, Detail::Thinned);
            looks.retain(|look| look.camera == Some(id.0));
            (!looks.is_empty()).then_some((frame.frame, i, looks))
        };
        let frames: &'a [FrameObservations] = self.sequence.frames;
        frames.par_iter().enumerate().filter_map(of_frame).collect()
    }

    fn posed<'m>(&'m self, motion: &'m Motion) -> Posed<'m> {
        Posed::new(self.evidence.model, &self.estimate.shape, motion)
    }

    /// What each camera shows, frame by frame.
    pub(super) fn beside(&self, calibrated: &Rig) -> Vec<Vec<Beside>> {
        let of_frame = |(i, frame): (usize, &FrameObservations)| {
            let looks = self.evidence.looks(frame, Detail::Thinned);
            let of_camera = |camera: (CameraId, &Camera)| {
                let own = looks.iter().filter(|look| look.camera == Some(camera.0.0));
                Some((camera.0, self.of_camera(camera, (i, frame.frame), own)?))
            };
            calibrated.iter().filter_map(of_camera).collect::<Vec<_>>()
        };
        let shown: Vec<_> = self.sequence.frames.par_iter().enumerate().map(of_frame).collect();

        let mut of_cameras = vec![Vec::new(); calibrated.cameras.len()];
        for (id, beside) in shown.into_iter().flatten() {
            of_cameras[id.0].push(beside);
        }
        of_cameras
    }

    /// What some looks cost before a motion.
    pub(super) fn cost<'l>(
        &self,
        looks: impl IntoIterator<Item = &'l Look<'l>>,
        motion: &Motion,
    ) -> f64 {
        let body = self.posed(motion);
        looks.into_iter().flat_map(|look| &look.terms).map(|term| term.cost(&body)).sum()
    }

    /// What each view of some cameras costs, frame by frame.
    pub(super) fn costs(&self, is_asked: impl Fn(CameraId) -> bool + Sync) -> Vec<f64> {
        let of_frame = |(i, frame): (usize, &FrameObservations)| {
            let looks = self.evidence.looks(frame, Detail::Thinned);
            let of_camera = |id: CameraId| {
                let mut own = looks.iter().filter(|look| look.camera == Some(id.0)).peekable();
                own.peek()?;
                Some(self.cost(own, &self.later(id, i, 0)?.motion))
            };
            let asked = self.evidence.rig.iter().map(|(id, _)| id).filter(|id| is_asked(*id));
            asked.filter_map(of_camera).collect::<Vec<f64>>()
        };
        self.sequence.frames.par_iter().enumerate().flat_map_iter(of_frame).collect()
    }

    /// What one shows; `None` where it shows nothing.
    fn of_camera<'l>(
        &self,
        (id, calibrated): (CameraId, &Camera),
        (position, frame): (usize, FrameIndex),
        looks: impl Iterator<Item = &'l Look<'l>>,
    ) -> Option<Beside> {
        let instant = self.later(id, position, 0)?;
        let equations = self.equations(looks, &instant.motion);
        let found = &self.evidence.rig.cameras[id.0];
        let offset_m = offset_m(&equations, found)?;

        // and what the camera was found to be off by
        let root: Point3<f64> = instant.motion.position_world.into();
        let (there, here) =
            (found.project_undistorted(&root)?, calibrated.project_undistorted(&root)?);
        let depth_m = (calibrated.camera_from_world * root).z;
        let metres = depth_m / calibrated.intrinsics.focal_px();
        Some(Beside {
            frame,
            offset_m: offset_m + (there - here) * metres,
            ahead_frames: self.ahead_frames(&equations, &instant),
            depth_m,
        })
    }

    /// g and H of a motion by what some looks show.
    fn equations<'l>(
        &self,
        looks: impl Iterator<Item = &'l Look<'l>>,
        motion: &Motion,
    ) -> NormalEquations {
        let body = self.posed(motion);
        let mut equations = NormalEquations::zeros(Layout::new(self.evidence.model).motion());
        for term in looks.flat_map(|look| &look.terms) {
            term.linearize(&body, &mut equations);
        }
        equations.hessian.fill_upper_triangle_with_lower_triangle();
        equations
    }

    /// τ over the interval of frames.
    fn ahead_frames(&self, equations: &NormalEquations, instant: &Instant) -> f64 {
        let per_frame = &instant.velocity / self.sequence.fps;
        let known = per_frame.dot(&(&equations.hessian * &per_frame));
        -per_frame.dot(&equations.gradient) / (known + 1.0)
    }

    /// Where a camera shows a motion's root by some looks, px.
    pub(super) fn shown_px(
        &self,
        id: CameraId,
        looks: &[Look<'_>],
        motion: &Motion,
    ) -> Option<Point2<f64>> {
        let camera = &self.evidence.rig.cameras[id.0];
        let offset_m = offset_m(&self.equations(looks.iter(), motion), camera)?;
        let root = camera.camera_from_world * Point3::from(motion.position_world);
        let there = camera.camera_from_world.inverse() * (root + offset_m.push(0.0));
        camera.project_undistorted(&there)
    }
}

/// d; `None` where there are no borders, or they run one way only.
fn offset_m(equations: &NormalEquations, camera: &Camera) -> Option<Vector2<f64>> {
    let axes = camera.camera_from_world.rotation.to_rotation_matrix().into_inner().transpose();
    let axes: Matrix3x2<f64> = axes.fixed_columns::<2>(0).into();
    let known = axes.transpose() * equations.hessian.fixed_view::<3, 3>(0, 0) * axes;
    let pull = axes.transpose() * equations.gradient.fixed_rows::<3>(0);
    Some(-known.cholesky()?.solve(&pull))
}
