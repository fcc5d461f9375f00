//! Whether the poses of a calibration are written in another form than they are read in, before a body is sought.
//!
//! Cameras that are all put elsewhere by one formula see nothing in common, or something that no body is. By how much silhouettes
//! [miss each other](super::coherence) needs no body: the poses are tried in each [`PoseForm`], and one with which all agree is told.
//!
//! Read from the world to the camera, the cameras of an even ring that were written the other way all stand in one place. Just before it lines of
//! sight meet, whatever they show. So a form that puts cameras much farther apart and with which all agree is told, too, and none that puts them into
//! one place.

use super::coherence::{MOST_M, Scene};
use crate::camera::{Camera, PoseForm, Rig, UpAxis};
use crate::math::stats::mean;
use crate::silhouette::FrameObservations;

/// Silhouettes that miss each other by more are not those of a person, or the cameras are elsewhere, metres.
const APART_M: f64 = 0.05;
/// The other form leaves at most this share of it, or of the limit.
const LEFT: f64 = 0.2;
/// Cameras that another form puts so many times as far apart stand in one place.
const FARTHER: f64 = 4.0;

/// The form in which the calibration must be written, if it is surely not that of our own poses; `up` is the axis of its world.
pub fn other_pose_form(rig: &Rig, up: UpAxis, frames: &[FrameObservations]) -> Option<PoseForm> {
    let (found, span) = (miss_m(rig, frames), span_m(rig));
    let other = |form: PoseForm| {
        let other = read_as(rig, up, form);
        let other_span = span_m(&other);
        let is_doubted = found > APART_M || other_span > FARTHER * span;
        let is_one_place = other_span < span / FARTHER;
        (is_doubted && !is_one_place).then(|| (miss_m(&other, frames), form))
    };
    let others = PoseForm::ALL.into_iter().filter(|form| *form != PoseForm::default());
    let agreeing = others.filter_map(other).filter(|(miss, _)| *miss < LEFT * found.max(APART_M));
    agreeing.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, form)| form)
}

/// How far apart the two cameras stand that are farthest from each other, metres.
fn span_m(rig: &Rig) -> f64 {
    let places: Vec<_> = rig.cameras.iter().map(Camera::centre_world).collect();
    let pairs = places.iter().flat_map(|a| places.iter().map(move |b| (a - b).norm()));
    pairs.fold(0.0, f64::max)
}

/// The mean over the cameras of what they miss the others by; one that sees nothing of what others see misses all of it.
fn miss_m(rig: &Rig, frames: &[FrameObservations]) -> f64 {
    let scene = Scene::new(rig, frames);
    let misses = scene.few_misses(&scene.plain());
    mean(misses.cameras.iter().map(|miss| miss.unwrap_or(MOST_M))).unwrap_or(0.0)
}

/// A rig whose poses were read as our own, read in another form.
fn read_as(rig: &Rig, up: UpAxis, form: PoseForm) -> Rig {
    let read = |camera: &Camera| {
        let written = camera.camera_from_world * up.world_from_file();
        let camera_from_world = form.camera_from_file(&written) * up.file_from_world();
        Camera { camera_from_world, ..camera.clone() }
    };
    Rig { cameras: rig.cameras.iter().map(read).collect() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Rigid3;
    use crate::pipeline::diagnosis::figures::walker;

    /// The rig with every pose in another way.
    fn written(rig: &Rig, pose: impl Fn(&Rigid3) -> Rigid3) -> Rig {
        let written = |camera: &Camera| Camera {
            camera_from_world: pose(&camera.camera_from_world),
            ..camera.clone()
        };
        Rig { cameras: rig.cameras.iter().map(written).collect() }
    }

    #[test]
    fn poses_that_are_written_in_another_form_are_told_by_it_and_right_ones_are_not() {
        let (rig, frames) = walker();
        assert_eq!(other_pose_form(&rig, UpAxis::Z, &frames), None);
        let inverse = written(&rig, Rigid3::inverse);
        let told = other_pose_form(&inverse, UpAxis::Z, &frames);
        assert_eq!(told, Some(PoseForm::CameraToWorld));
        let with_places =
            written(&rig, |p| Rigid3::from_parts(p.inverse().translation, p.rotation));
        let told = other_pose_form(&with_places, UpAxis::Z, &frames);
        assert_eq!(told, Some(PoseForm::RotationAndCentre));
    }

    #[test]
    fn one_camera_that_was_moved_is_no_form() {
        let (mut rig, frames) = walker();
        rig.cameras[0].camera_from_world.translation.vector.x += 0.5;
        assert_eq!(other_pose_form(&rig, UpAxis::Z, &frames), None);
    }
}
