use std::path::Path;

use nalgebra::Point3;

use super::*;
use crate::image::Mask;
#[cfg(test)]
use crate::io::model;
use crate::pipeline::NoProgress;
use crate::pipeline::diagnosis::figures::{Figures, joined};
use crate::silhouette::{FrameIndex, SilhouetteOptions, extract};
use crate::synth::Ring;

/// What is left of somebody where a ball of this radius hangs in the middle of the room.
fn ball(rig: &Rig, radius_m: f64) -> Vec<FrameObservations> {
    let middle = Point3::new(0.0, 0.0, 1.0);
    let seen = |index| {
        let views = rig.iter().map(|(id, camera)| {
            let at = camera.project_undistorted(&middle).expect("before the camera");
            let depth_m = (camera.camera_from_world * middle).z;
            let radius_px = radius_m * camera.intrinsics.focal_px() / depth_m;
            let mask =
                Mask::from_fn(camera.width_px as usize, camera.height_px as usize, |x, y| {
                    (x as f64 - at.x).hypot(y as f64 - at.y) < radius_px
                });
            (id, extract(&mask, camera, &SilhouetteOptions::default()).expect("a silhouette"))
        });
        FrameObservations { views: views.collect(), ..FrameObservations::nothing(index) }
    };
    (0..2).map(FrameIndex).map(seen).collect()
}

/// `balance`, segmented without detections, has such a rest of the picture behind the man.
#[test]
fn to_what_is_much_smaller_than_a_person_no_body_is_fitted_and_it_is_told_which_that_is() {
    let body = model::load("human-ellipsoids", Path::new("")).expect("a shipped model");
    let rig = Ring { cameras: 4, ..Ring::default() }.regular();
    let shares = [ball(&rig, 0.13)];
    let options = EstimateOptions::default();
    let nobody = Bodies::fitted(&body, &rig, 25.0, &options, &shares, &NoProgress);
    assert_eq!(nobody.err(), Some(0));
}

/// Whether the bodies of who is taken for several people explain the masks better than one: two who stand at these places.
fn are_several(places: [[f64; 2]; 2]) -> bool {
    let figures = Figures::new();
    let [first, second] = places.map(|[x, y]| figures.masks(&figures.standing(x, y)));
    let masks = joined(&first, &second);
    let frames = |masks: &[Mask]| (0..3).map(|i| figures.frame(i, masks)).collect::<Vec<_>>();
    let (all, shares) = (frames(&masks), [frames(&first), frames(&second)]);
    let track = || {
        let standing = |i| (i, Standing { place: Point3::origin(), height_m: 1.7, voxels: vec![] });
        Track { frames: (0..3).map(standing).collect() }
    };

    let (rig, options) = (&figures.rig, EstimateOptions::default());
    let bodies = Bodies::fitted(&figures.model, rig, 25.0, &options, &shares, &NoProgress);
    let Ok(bodies) = bodies else { panic!("a body of each") };
    let sequence = Sequence { frames: &all, fps: 25.0 };
    let several =
        bodies.explain_more_than_one(rig, sequence, &[track(), track()], &options, &NoProgress);
    several.expect("bodies that can be compared")
}

#[test]
fn two_people_are_several_and_two_bodies_of_one_person_are_not() {
    assert!(are_several([[0.0, -0.4], [0.1, 0.4]]));
    assert!(!are_several([[0.0, 0.1], [0.0, 0.1]]));
}
