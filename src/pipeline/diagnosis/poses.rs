//! Whether the poses of a calibration are those of the pictures, before a body is sought: in another form, or not at all.
//!
//! Cameras that are all put elsewhere by one formula see nothing in common, or something that no body is. By how much silhouettes
//! [miss each other](super::coherence) needs no body: the poses are tried in each [`PoseForm`], and one with which all agree is told.

use super::cameras::CameraFaults;
use super::coherence::{MOST_M, Scene};
use crate::camera::{Camera, PoseForm, Rig, UpAxis};
use crate::math::stats::mean;
use crate::silhouette::FrameObservations;

/// Silhouettes that miss each other by more are not those of a person, or the cameras are elsewhere, metres.
const APART_M: f64 = 0.05;
/// From here on nobody needs to be sought: ten right rigs have .2 to 7 mm, poses that are wrong by a formula 60 to 270 mm.
const HOPELESS_M: f64 = 0.1;
/// The other form leaves at most this share of it.
const LEFT: f64 = 0.2;

/// The form in which the calibration must be written, if it is surely not that of our own poses; `up` is the axis of its world.
pub fn other_pose_form(rig: &Rig, up: UpAxis, frames: &[FrameObservations]) -> Option<PoseForm> {
    let miss_m = |form: PoseForm| miss_m(&read_as(rig, up, form), frames);
    let found = miss_m(PoseForm::default());
    if found < APART_M {
        return None;
    }
    let others = PoseForm::ALL.into_iter().filter(|form| *form != PoseForm::default());
    let all = others.map(|form| (miss_m(form), form)).filter(|(miss, _)| *miss < LEFT * found);
    all.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, form)| form)
}

impl CameraFaults {
    /// By how much the silhouettes still miss each other, where that leaves no hope for any body.
    pub(in crate::pipeline) fn hopeless_m(&self) -> Option<f64> {
        (self.left_m > HOPELESS_M).then_some(self.left_m)
    }
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
    use crate::pipeline::diagnosis::figures::walker;

    /// What a program would write that means a form, read as our own.
    fn misread(rig: &Rig, up: UpAxis, form: PoseForm) -> Rig {
        // each form is its own inverse but that of Blender, and t with the camera's place
        let written = |camera: &Camera| {
            let ours = camera.camera_from_world * up.world_from_file();
            let written = match form {
                PoseForm::BlenderToWorld => PoseForm::CameraToWorld
                    .camera_from_file(&PoseForm::WorldToOpengl.camera_from_file(&ours)),
                PoseForm::RotationAndCentre => {
                    nalgebra::Isometry3::from_parts(ours.inverse().translation, ours.rotation)
                }
                _ => form.camera_from_file(&ours),
            };
            Camera { camera_from_world: written * up.file_from_world(), ..camera.clone() }
        };
        Rig { cameras: rig.cameras.iter().map(written).collect() }
    }

    #[test]
    fn poses_that_are_written_in_another_form_are_told_by_it_and_right_ones_are_not() {
        let (rig, frames) = walker();
        for up in [UpAxis::Z, UpAxis::Y] {
            assert_eq!(other_pose_form(&rig, up, &frames), None);
            for form in PoseForm::ALL.into_iter().skip(1) {
                let misread = misread(&rig, up, form);
                assert_eq!(other_pose_form(&misread, up, &frames), Some(form), "{form}");
            }
        }
    }

    #[test]
    fn one_camera_that_was_moved_is_no_form() {
        let (mut rig, frames) = walker();
        rig.cameras[0].camera_from_world.translation.vector.x += 0.5;
        assert_eq!(other_pose_form(&rig, UpAxis::Z, &frames), None);
    }
}
