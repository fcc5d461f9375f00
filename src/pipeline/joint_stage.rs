//! The joint optimum, and where and when the cameras are.
//!
//! Cameras that nothing crosses are held at their calibration and clock: freed, they would leave open how far away the person is, and of right
//! calibrations joints would be found the worse. But they are not believed blindly. First the optimum before thinned borders is sought with all of them unknown. If that says
//! that some pose is surely off, poses are unknown; if some clock is, clocks are.

use std::collections::BTreeSet;

use nalgebra::{Point2, Point3, UnitQuaternion, Vector3};

use super::camera_covariance::CameraCovariances;
use super::camera_found::{CameraFound, PoseFound};
use super::diagnosis::CameraFaults;
use super::{EstimateOptions, Progress};
use crate::body::{BodyModel, Root};
use crate::camera::{Camera, CameraId, Rig};
use crate::inference::camera_offset::CameraOffset;
use crate::inference::camera_prior::{CameraPrior, Free};
use crate::inference::joint::{JointOptimum, JointOptions, Rounds, joint_optimum_from_terms};
use crate::inference::lens_prior::ZOOM_SD;
use crate::inference::{Evidence, Sequence, SequenceState};
use crate::likelihood::Measure;

/// Rounds at most in which lenses are put into the rig as they were found.
const LENS_ROUNDS: usize = 3;

/// What the last stage of a fit is given.
pub(super) struct JointStage<'a> {
    pub(super) model: &'a BodyModel,
    /// The cameras as they were calibrated.
    pub(super) calibrated: &'a Rig,
    pub(super) measure: Measure,
    pub(super) sequence: Sequence<'a>,
    pub(super) options: &'a EstimateOptions,
    pub(super) joint: &'a JointOptions,
    /// What of the cameras may be an unknown.
    pub(super) free: Free,
    /// What silhouettes alone say of the cameras.
    pub(super) faults: &'a CameraFaults,
    pub(super) progress: &'a dyn Progress,
}

/// What the last stage found.
pub(super) struct Joined {
    pub(super) optimum: JointOptimum,
    /// What of the cameras was unknown.
    pub(super) prior: CameraPrior,
    /// How sure the cameras are together.
    pub(super) covariances: CameraCovariances,
}

impl JointStage<'_> {
    /// The optimum, and where and when the cameras are, and with which lenses.
    pub(super) fn run(&self, start: SequenceState) -> Joined {
        let allowed = if self.has_unknown_cameras() { self.free } else { Free::default() };
        let crossed = Free::crossed(self.calibrated, start.motions.iter(), allowed);
        let off = self.held_and_off(&crossed, allowed, &start);
        let free: Vec<Free> = crossed.iter().map(|free| free.or(off)).collect();
        self.with_lenses(&self.prior(&free), start)
    }

    /// What is surely off of cameras that nothing crosses: whether poses are, and whether clocks are.
    fn held_and_off(&self, crossed: &[Free], allowed: Free, start: &SequenceState) -> Free {
        let shows = |id: CameraId| self.sequence.frames.iter().any(|f| f.is_shown_by(id));
        let cameras = self.calibrated.iter().filter(|(id, _)| shows(*id)).count();
        let asked = Free::shown(cameras, allowed);
        let free: Vec<Free> = crossed.iter().map(|free| free.or(asked)).collect();
        if free == crossed {
            return Free::default();
        }

        let thinned = JointOptions { rounds: Rounds::Thinned, ..*self.joint };
        let stage = JointStage { joint: &thinned, ..*self };
        let Joined { optimum, .. } = stage.with_lenses(&self.prior(&free), start.clone());
        let off = |(i, (crossed, free)): (usize, (&Free, &Free))| {
            let sd = optimum.uncertainty.as_ref().and_then(|u| u.camera_sd(i));
            let found = CameraFound::new(&optimum.cameras[i], *free, sd.as_ref());
            let is_off = |pose: PoseFound| pose.was_touched() || pose.is_zoomed();
            Free {
                pose: !crossed.pose && found.pose.is_some_and(is_off),
                clock: !crossed.clock && found.clock.is_some_and(|c| c.is_off(self.sequence.fps)),
            }
        };
        let off = crossed.iter().zip(&free).enumerate().map(off);
        off.fold(Free::default(), Free::or)
    }

    /// The optimum before lenses as they are found.
    fn with_lenses(&self, prior: &CameraPrior, start: SequenceState) -> Joined {
        let mut zooms = self.first_zooms(prior);
        let cameras = self.first_offsets(prior, &start);
        let start = SequenceState { cameras, ..start };
        let mut joined = self.before(prior, &zooms, start.clone());

        // again, before lenses as they were found
        for _ in 1..LENS_ROUNDS {
            let found: Vec<f64> = joined.optimum.cameras.iter().map(|c| c.log_zoom).collect();
            if found.iter().zip(&zooms).all(|(found, zoom)| (found - zoom).abs() <= ZOOM_SD) {
                break;
            }
            joined = self.before(prior, &found, start.clone());
            zooms = found;
        }
        joined
    }

    /// The optimum before cameras with other focal lengths, by ζ; the ζ that are found are against the calibrated ones.
    ///
    /// Where there are detections, what their detector means by each joint is an unknown too; it is left out of what is returned.
    fn before(&self, prior: &CameraPrior, zooms: &[f64], start: SequenceState) -> Joined {
        let Self { model, calibrated, measure, sequence, options, joint, .. } = *self;
        let (rig, prior) = (zoomed(calibrated, zooms), prior.clone().with_zooms(zooms));
        let detected = model.with_keypoints(&detected_names(sequence));
        let evidence = Evidence::new(&detected, &rig, options.likelihood, measure);
        let terms = evidence.sequence_terms(sequence, prior.clone());

        self.progress.begin("joint optimum", joint.most_steps());
        let step = || self.progress.step();
        let seconds = sequence.intervals_s();
        let mut optimum =
            joint_optimum_from_terms(&evidence, &terms, &seconds, start, joint, &step);
        self.progress.end();
        count_from_calibrated(&mut optimum, zooms);
        let covariances = CameraCovariances::new(&prior, &optimum);
        let optimum = optimum.of_first(model.coefficients.len());
        Joined { optimum, prior, covariances }
    }

    /// Where the estimate of each camera's place and clock starts.
    fn first_offsets(&self, prior: &CameraPrior, start: &SequenceState) -> Vec<CameraOffset> {
        let from = |(camera, ahead): (usize, isize)| CameraOffset {
            turn: self.first_turn(prior, CameraId(camera), start),
            ahead_s: self.first_ahead_frames(prior, camera, ahead) / self.sequence.fps,
            ..CameraOffset::none()
        };
        self.faults.ahead_frames().into_iter().enumerate().map(from).collect()
    }

    /// ζ of each camera as the silhouettes tell it, where it is unknown.
    fn first_zooms(&self, prior: &CameraPrior) -> Vec<f64> {
        let of_camera =
            |(camera, zoom): (usize, f64)| if prior.free(camera).pose { zoom } else { 0.0 };
        self.faults.log_zooms().into_iter().enumerate().map(of_camera).collect()
    }

    /// Where the estimate of a clock starts: whole frames, if the silhouettes tell them, or else what is known before.
    fn first_ahead_frames(&self, prior: &CameraPrior, camera: usize, seen: isize) -> f64 {
        let name = &self.calibrated.cameras[camera].name;
        let known = self.options.ahead_frames.get(name).copied().unwrap_or(0.0);
        if seen != 0 && prior.free(camera).clock { seen as f64 } else { known }
    }

    /// Where the estimate of a turn starts: of a camera that shows the person elsewhere, where it sees the pelvis that the others found.
    /// From its calibration, a person's width off, the optimum would rather move the others.
    fn first_turn(
        &self,
        prior: &CameraPrior,
        id: CameraId,
        start: &SequenceState,
    ) -> UnitQuaternion<f64> {
        if !prior.free(id.0).pose || !self.faults.is_elsewhere(id) {
            return UnitQuaternion::identity();
        }
        let frames = self.sequence.frames.iter().zip(&start.motions);
        let shown = frames.filter_map(|(frame, motion)| {
            let (_, silhouette) = frame.views.iter().find(|(camera, _)| *camera == id)?;
            Some((silhouette.centroid, Point3::from(motion.position_world)))
        });
        turn_towards(&self.calibrated.cameras[id.0], shown)
    }

    /// Whether anything of the cameras can be estimated: nothing where points were measured with them.
    fn has_unknown_cameras(&self) -> bool {
        let has_points = self.sequence.frames.iter().any(|frame| !frame.points.is_empty());
        !has_points && self.model.root != Root::Fixed
    }

    /// p(c) of cameras of which so much is free.
    fn prior(&self, free: &[Free]) -> CameraPrior {
        camera_prior(free, self.calibrated, self.sequence, self.options)
    }
}

/// p(c) of cameras of which so much is free.
pub(super) fn camera_prior(
    free: &[Free],
    calibrated: &Rig,
    sequence: Sequence<'_>,
    options: &EstimateOptions,
) -> CameraPrior {
    let prior = CameraPrior::freeing(free, 1.0 / sequence.fps);
    prior.with_errors(options.calibration_errors, calibrated)
}

/// The cameras with other focal lengths, by ζ.
pub(super) fn zoomed(rig: &Rig, zooms: &[f64]) -> Rig {
    CameraOffset::applied(rig, zooms.iter().map(|zoom| CameraOffset::zoomed(*zoom)))
}

/// Counts ζ from the calibrated lenses, of an optimum before cameras with these ζ.
pub(super) fn count_from_calibrated(optimum: &mut JointOptimum, zooms: &[f64]) {
    for (camera, zoom) in optimum.cameras.iter_mut().zip(zooms) {
        camera.log_zoom += zoom;
    }
}

/// The shortest turn of a camera about its centre that brings what it shows, at pixels, to places in the world, on the mean.
pub(super) fn turn_towards(
    camera: &Camera,
    shown: impl Iterator<Item = (Point2<f64>, Point3<f64>)>,
) -> UnitQuaternion<f64> {
    let centre = camera.centre_world();
    let (mut from, mut to) = (Vector3::zeros(), Vector3::zeros());
    for (pixel, place) in shown {
        from += *camera.ray(&pixel).direction_world;
        to += (place - centre).try_normalize(0.0).unwrap_or_default();
    }
    UnitQuaternion::rotation_between(&from, &to).unwrap_or_default()
}

/// The names of all keypoints of a sequence.
pub(super) fn detected_names(sequence: Sequence<'_>) -> Vec<&'static str> {
    let detections = sequence.frames.iter().flat_map(|frame| &frame.detections);
    let names = detections.flat_map(|(_, detection)| detection.keypoints.iter().map(|k| k.name));
    names.collect::<BTreeSet<_>>().into_iter().collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::UnitVector3;

    use crate::synth::Ring;

    #[test]
    fn a_camera_that_was_turned_is_turned_back_to_what_it_shows() {
        let calibrated = &Ring::default().regular().cameras[0];
        let places = [0.0, 0.1, 0.2].map(|x| Point3::new(x, 0.0, 1.0));
        let sight = places[1] - calibrated.centre_world();
        let across = UnitVector3::new_normalize(sight.cross(&Vector3::z()));
        let touched = CameraOffset {
            turn: UnitQuaternion::from_axis_angle(&across, 0.05),
            ..CameraOffset::none()
        };
        let rig = Rig { cameras: vec![calibrated.clone()] };
        let camera = &CameraOffset::applied(&rig, [touched]).cameras[0];

        let shown = places.map(|place| (camera.project(&place).unwrap(), place));
        let found = turn_towards(calibrated, shown.into_iter());
        assert!(found.angle_to(&touched.turn) < 0.002, "{found} for {}", touched.turn);
        assert_eq!(turn_towards(calibrated, std::iter::empty()), UnitQuaternion::identity());
    }
}
