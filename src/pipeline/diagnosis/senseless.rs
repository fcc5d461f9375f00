//! Recordings of which no search makes sense: pictures are flipped, or no two cameras see one scene.
//!
//! Silhouettes tell it without a body, and a search would take minutes to fit one to nothing. Even the silhouettes of two
//! cameras [miss each other](super::coherence) where calibration and pictures are not of one room: of 21 pairs of cameras whose rotations
//! were written in degrees the best misses by 7 cm, of right ones the worst by 2 mm.

use super::cameras::{CameraFault, CameraFaults};
use super::cause::camera_causes;
use super::coherence::{MOST_M, Scene};
use crate::camera::{CameraId, Rig};
use crate::pipeline::FitError;
use crate::silhouette::FrameObservations;

/// All cameras together miss each other by more where none sees what another does, metres: half of what is missed altogether. What masks
/// hold besides a person is missed, too, so the person's own borders must be.
const APART_M: f64 = 0.5 * MOST_M;
/// Two cameras that miss each other by less, both ways, may see one scene, metres.
const TOGETHER_M: f64 = 0.05;

impl CameraFaults {
    /// Whether a search can make sense of the recording.
    ///
    /// # Errors
    /// [`FitError::Cameras`] where pictures are flipped; [`FitError::NoTwoAgree`].
    pub(in crate::pipeline) fn check(
        &self,
        rig: &Rig,
        frames: &[FrameObservations],
    ) -> Result<(), FitError> {
        let is_flipped = |fault: &CameraFault| {
            matches!(fault, CameraFault::AllFlipped(_) | CameraFault::Flipped(..))
        };
        if self.faults.iter().any(is_flipped) && self.explain_nearly_all() {
            return Err(FitError::Cameras(camera_causes(rig, self)));
        }

        if self.left_m < APART_M {
            return Ok(());
        }
        match self.best_pair(&Scene::new(rig, frames)) {
            Some((pair, miss_m)) if miss_m > TOGETHER_M => {
                let cameras = pair.map(|id| rig.cameras[id.0].name.clone());
                Err(FitError::NoTwoAgree { cameras, miss_m })
            }
            _ => Ok(()),
        }
    }

    /// The two cameras whose outlines miss each other least, and by how much; detections of two cameras are not compared.
    fn best_pair(&self, scene: &Scene<'_>) -> Option<([CameraId; 2], f64)> {
        if !scene.shows_outlines() {
            return None;
        }
        let there: Vec<usize> =
            (0..self.readings.len()).filter(|i| self.readings[*i].is_some()).collect();
        let pairs = there
            .iter()
            .flat_map(|i| there.iter().take_while(move |j| *j < i).map(move |j| [*j, *i]));
        let missed = pairs.map(|pair| {
            let mut readings = vec![None; self.readings.len()];
            pair.iter().for_each(|i| readings[*i] = self.readings[*i]);
            let misses = scene.few_misses(&readings).cameras;
            let miss_m = pair.map(|i| misses[i].unwrap_or(MOST_M));
            (pair.map(CameraId), miss_m[0].max(miss_m[1]))
        });
        missed.min_by(|a, b| a.1.total_cmp(&b.1))
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use nalgebra::Vector3;

    use super::*;
    use crate::camera::Camera;
    use crate::math::Rigid3;
    use crate::pipeline::diagnosis::figures::walker;

    /// What is said of the walker before cameras that a change was made to.
    fn checked(count: usize, change: impl Fn((usize, &mut Camera))) -> Result<(), FitError> {
        let (mut rig, mut frames) = walker();
        rig.cameras.truncate(count);
        rig.cameras.iter_mut().enumerate().for_each(change);
        for frame in &mut frames {
            frame.views.retain(|(id, _)| id.0 < count);
        }
        CameraFaults::of(&rig, &frames).check(&rig, &frames)
    }

    #[test]
    fn a_calibration_in_degrees_is_refused_and_a_right_one_is_not() {
        let in_degrees = |(_, camera): (usize, &mut Camera)| {
            let pose = camera.camera_from_world;
            let turn = pose.rotation.scaled_axis().map(f64::to_degrees);
            camera.camera_from_world = Rigid3::new(pose.translation.vector, turn);
        };
        for count in [2, 3, usize::MAX] {
            assert_eq!(checked(count, |_| {}), Ok(()));
        }
        let found = checked(usize::MAX, in_degrees);
        assert!(matches!(found, Err(FitError::NoTwoAgree { .. })), "{found:?}");
    }

    #[test]
    fn cameras_of_which_two_agree_are_not_refused() {
        let elsewhere = |i: usize, camera: &mut Camera| {
            camera.camera_from_world.translation.vector.x += i as f64 * 0.7;
        };
        for count in [3, 4] {
            let found = checked(count, |(i, camera)| elsewhere(i.saturating_sub(1), camera));
            assert_eq!(found, Ok(()), "{count}");
        }
    }

    #[test]
    fn pictures_that_are_upside_down_are_refused() {
        let hangs = |camera: &mut Camera| {
            let turn = Rigid3::rotation(Vector3::z() * PI);
            camera.camera_from_world = turn * camera.camera_from_world;
        };
        let told = |found: Result<(), FitError>| found.expect_err("refused").to_string();
        let found = told(checked(usize::MAX, |(_, camera)| hangs(camera)));
        assert!(found.contains("all pictures are upside down"), "{found}");
        let one = |(i, camera): (usize, &mut Camera)| {
            if i == 1 {
                hangs(camera)
            }
        };
        let found = told(checked(usize::MAX, one));
        assert!(found.matches("is upside down").count() == 1, "{found}");
    }
}
