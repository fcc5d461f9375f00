//! Whether the poses of a calibration are written in another form than they are read in, before a body is sought.
//!
//! Cameras that are all put elsewhere by one formula see nothing in common, or something that no body is. By how much silhouettes
//! [miss each other](super::coherence) needs no body: the poses are tried in each [`PoseForm`], and one with which all agree is told.
//!
//! Cameras that all stand in one place, as those of an even ring do that is read the wrong way, agree just before it about whatever they show.
//! So each two of them must also [see somebody at one place](crate::pipeline::scene).

use nalgebra::center;

use super::coherence::{MOST_M, Scene};
use crate::camera::{Camera, CameraId, PoseForm, Rig, UpAxis};
use crate::math::stats::mean;
use crate::pipeline::scene::{Place, agree};
use crate::silhouette::{Detection, FrameObservations};

/// Poses are doubted where silhouettes miss each other by more, and another form is told with which they do by less: those of right poses
/// do by .2 to 7 mm in nine recordings, metres.
const DOUBTED_M: f64 = 0.02;
const AGREEING_M: f64 = 0.01;
/// Of right poses more pairs of pictures show somebody at one place; where fewer than half do, poses are doubted.
const MEETING: f64 = 0.9;
const FEW_MEETING: f64 = 0.5;

/// The form in which the calibration must be written, if it is surely not that of our own poses; `up` is the axis of its world.
pub fn other_pose_form(rig: &Rig, up: UpAxis, frames: &[FrameObservations]) -> Option<PoseForm> {
    let found = Agreement::new(rig, frames);
    if found.miss_m < DOUBTED_M && found.meeting > FEW_MEETING {
        return None;
    }
    let others = PoseForm::ALL.into_iter().filter(|form| *form != PoseForm::default());
    let read = others.map(|form| (Agreement::new(&read_as(rig, up, form), frames), form));
    let agreeing = read.filter(|(a, _)| a.miss_m < AGREEING_M && a.meeting > MEETING);
    let best = agreeing.min_by(|a, b| a.0.miss_m.total_cmp(&b.0.miss_m));
    best.map(|(_, form)| form)
}

/// How well cameras agree about what they show.
#[derive(Debug, Clone, Copy)]
struct Agreement {
    /// The mean over the cameras of what they miss the others by; one that sees nothing of what others see misses all of it.
    miss_m: f64,
    /// The share of the pairs of pictures that show somebody at one place.
    meeting: f64,
}

impl Agreement {
    fn new(rig: &Rig, frames: &[FrameObservations]) -> Self {
        let scene = Scene::new(rig, frames);
        let misses = scene.few_misses(&scene.plain());
        let misses = misses.cameras.iter().map(|miss| miss.unwrap_or(MOST_M));
        let pairs = frames.iter().flat_map(|frame| meetings(rig, frame));
        Self {
            miss_m: mean(misses).unwrap_or(0.0),
            meeting: mean(pairs.map(|meets| f64::from(u8::from(meets)))).unwrap_or(1.0),
        }
    }
}

/// Of each two pictures of a frame, whether they show somebody at one place.
fn meetings(rig: &Rig, frame: &FrameObservations) -> Vec<bool> {
    let of_detection = |(id, seen): &(CameraId, Detection)| {
        let bounds = seen.bounds()?;
        Some((*id, Place { middle: center(&bounds.0, &bounds.1), bounds }))
    };
    let shown: Vec<(CameraId, Place)> = match frame.views.is_empty() {
        false => frame.views.iter().map(|(id, seen)| (*id, Place::of(seen))).collect(),
        true => frame.detections.iter().filter_map(of_detection).collect(),
    };
    let pairs = shown.iter().enumerate().flat_map(|(i, a)| shown[..i].iter().map(move |b| (a, b)));
    let seen_by = |(id, place): &(CameraId, Place)| (&rig.cameras[id.0], *place);
    pairs.map(|(a, b)| agree(seen_by(a), seen_by(b))).collect()
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

    /// What a program would write that means a form, read as our own.
    fn misread(rig: &Rig, up: UpAxis, form: PoseForm) -> Rig {
        // each form is its own inverse but for these two
        let written = |ours: Rigid3| match form {
            PoseForm::BlenderToWorld => PoseForm::WorldToOpengl.camera_from_file(&ours).inverse(),
            PoseForm::RotationAndCentre => {
                Rigid3::from_parts(ours.inverse().translation, ours.rotation)
            }
            _ => form.camera_from_file(&ours),
        };
        let read = |camera: &Camera| {
            let written = written(camera.camera_from_world * up.world_from_file());
            Camera { camera_from_world: written * up.file_from_world(), ..camera.clone() }
        };
        Rig { cameras: rig.cameras.iter().map(read).collect() }
    }

    #[test]
    fn poses_that_are_written_in_another_form_are_told_by_it_and_right_ones_are_not() {
        let (rig, frames) = walker();
        for up in [UpAxis::Z, UpAxis::Y] {
            assert_eq!(other_pose_form(&rig, up, &frames), None);
            for form in PoseForm::ALL.into_iter().skip(1) {
                let misread = misread(&rig, up, form);
                assert_eq!(
                    other_pose_form(&misread, up, &frames),
                    Some(form),
                    "{form}, {up}: {:?}",
                    Agreement::new(&misread, &frames)
                );
            }
        }
    }

    #[test]
    fn one_of_three_cameras_that_is_elsewhere_is_no_form() {
        let (mut rig, mut frames) = walker();
        rig.cameras.truncate(3);
        for frame in &mut frames {
            frame.views.retain(|(id, _)| id.0 < 3);
        }
        rig.cameras[0].camera_from_world.translation.vector.x += 0.5;
        assert!(Agreement::new(&rig, &frames).miss_m > DOUBTED_M);
        for up in [UpAxis::Z, UpAxis::Y] {
            assert_eq!(other_pose_form(&rig, up, &frames), None);
        }
    }
}
