//! Recordings of which no search makes sense: pictures are flipped, or no cameras see one scene.
//!
//! Silhouettes tell it without a body, and a search would take minutes to fit one to nothing. Even the silhouettes of two
//! cameras [miss each other](super::coherence) where calibration and pictures are not of one room: of 21 pairs of cameras whose rotations
//! were written in degrees the best misses by 7 cm, of right ones the worst by 6 mm.

use std::iter::once;

use super::cameras::CameraFaults;
use super::cause::camera_causes;
use super::coherence::{MOST_M, Scene};
use super::fault::CameraFault;
use super::hypotheses::{ENOUGH, present};
use crate::camera::Rig;
use crate::pipeline::FitError;
use crate::silhouette::FrameObservations;

/// All cameras together miss each other by more where none sees what another does, metres: half of what is missed altogether. What masks
/// hold besides a person is missed, too, so the person's own borders must be.
const APART_M: f64 = 0.5 * MOST_M;
/// Flipped pictures of right cameras miss each other by less once they are read so, metres.
const AGREEING_M: f64 = 0.01;
/// Cameras that miss each other by less, two by two, may see one scene, metres; …
const TOGETHER_M: f64 = 0.05;
/// … of so many cameras two may do so by chance, and one must agree with most.
const MANY: usize = 5;

impl CameraFaults {
    /// Whether a search can make sense of the recording.
    ///
    /// # Errors
    /// [`FitError::Cameras`] where pictures are flipped; [`FitError::NoneAgree`].
    pub(in crate::pipeline) fn check(
        &self,
        rig: &Rig,
        frames: &[FrameObservations],
    ) -> Result<(), FitError> {
        let is_plainly_flipped = |fault: &CameraFault| match fault {
            CameraFault::AllFlipped(_) => true,
            CameraFault::Flipped(..) => rig.cameras.len() >= ENOUGH,
            _ => false,
        };
        let explains = self.explain_nearly_all() && self.left_m < AGREEING_M;
        if explains && self.faults.iter().any(is_plainly_flipped) {
            return Err(FitError::Cameras(camera_causes(rig, self)));
        }

        if self.left_m < APART_M {
            return Ok(());
        }
        match self.best_company(&Scene::new(rig, frames)) {
            Some((cameras, miss_m)) if miss_m > TOGETHER_M => {
                let cameras = cameras.into_iter().map(|i| rig.cameras[i].name.clone()).collect();
                Err(FitError::NoneAgree { cameras, miss_m })
            }
            _ => Ok(()),
        }
    }

    /// The cameras that agree best, and by how much they miss each other at most: one camera, and beside it the other that it agrees with
    /// best, or half of many others. Detections of two cameras are not compared.
    fn best_company(&self, scene: &Scene<'_>) -> Option<(Vec<usize>, f64)> {
        if !scene.shows_outlines() {
            return None;
        }
        let there: Vec<usize> = present(&self.readings).collect();
        let others = if there.len() < MANY { 1 } else { there.len() / 2 };
        let company = |i: &usize| {
            let pairs = there.iter().filter(|j| *j != i);
            let mut missed: Vec<(usize, f64)> =
                pairs.map(|j| (*j, self.pair_miss_m(scene, [*i, *j]))).collect();
            missed.sort_by(|a, b| a.1.total_cmp(&b.1));
            missed.truncate(others);
            let most_m = missed.last()?.1;
            Some((once(*i).chain(missed.iter().map(|(j, _)| *j)).collect(), most_m))
        };
        there.iter().filter_map(company).min_by(|a, b| a.1.total_cmp(&b.1))
    }

    /// By how much two cameras miss each other: the one that misses more; one that sees nothing of the other's misses all.
    fn pair_miss_m(&self, scene: &Scene<'_>, pair: [usize; 2]) -> f64 {
        let mut readings = vec![None; self.readings.len()];
        pair.iter().for_each(|i| readings[*i] = self.readings[*i]);
        let misses = scene.few_misses(&readings).cameras;
        pair.iter().map(|i| misses[*i].unwrap_or(MOST_M)).fold(0.0, f64::max)
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use nalgebra::Vector3;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::*;
    use crate::camera::Camera;
    use crate::math::Rigid3;
    use crate::pipeline::diagnosis::figures::{hang, walker};

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
    fn a_calibration_of_another_room_is_refused_and_a_right_one_is_not() {
        for count in [2, 3, usize::MAX] {
            assert_eq!(checked(count, |_| {}), Ok(()));
        }
        for seed in 0..2 {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            let turns: Vec<[f64; 3]> =
                (0..8).map(|_| std::array::from_fn(|_| rng.random_range(-PI..PI))).collect();
            let found = checked(usize::MAX, |(i, camera)| {
                let pose = &mut camera.camera_from_world;
                *pose = Rigid3::new(pose.translation.vector, Vector3::from(turns[i]));
            });
            assert!(matches!(found, Err(FitError::NoneAgree { .. })), "{seed}: {found:?}");
        }
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
        let told = |found: Result<(), FitError>| found.expect_err("refused").to_string();
        let found = told(checked(usize::MAX, |(_, camera)| hang(camera)));
        assert!(found.contains("all pictures are upside down"), "{found}");
        let one = |(i, camera): (usize, &mut Camera)| {
            if i == 1 {
                hang(camera)
            }
        };
        let found = told(checked(usize::MAX, one));
        assert!(found.matches("is upside down").count() == 1, "{found}");
    }
}
