//! Silhouettes by the joint pipeline, of a body whose pictures are known.

use maquette::body::metaball::Field;
use maquette::body::{BodyModel, Motion, Posed, Shape};
use maquette::camera::{Camera, Distortion, Intrinsics, Rig};
use maquette::image::{Mask, Picture, Plane};
use maquette::inference::SequenceState;
use maquette::inference::joint::{JointOptions, joint_optimum};
use maquette::inference::{Evidence, Sequence};
use maquette::io::model;
use maquette::likelihood::{LikelihoodOptions, Measure, SkinScale};
use maquette::math::Rigid3;
use maquette::pipeline::silhouettes::{
    ContourFault, ContourOptions, FoundPoint, FrameSighting, Scene, SilhouettePipeline,
    SilhouetteSearch, StartingFit, StillScenes, UndistortedFrame, ViewSighting,
};
use maquette::pipeline::{MemoryPictures, NoProgress};
use maquette::render;
use maquette::silhouette::{FrameIndex, FrameObservations};
use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3};

const SIZE: (u32, u32) = (150, 200);

/// Looks at the origin from 4 m away, turned about the vertical.
fn camera(name: &str, turn_deg: f64) -> Camera {
    let from_front = Matrix3::new(0.0, 1.0, 0.0, 0.0, 0.0, -1.0, -1.0, 0.0, 0.0);
    let turn = Rotation3::from_axis_angle(&Vector3::z_axis(), turn_deg.to_radians());
    let rotation = Rotation3::from_matrix_unchecked(from_front) * turn;
    Camera {
        name: name.into(),
        width_px: SIZE.0,
        height_px: SIZE.1,
        intrinsics: Intrinsics {
            fx_px: 300.0,
            fy_px: 300.0,
            cx_px: 75.0,
            cy_px: 100.0,
            skew_px: 0.0,
        },
        distortion: Distortion::None,
        camera_from_world: Rigid3::from_parts(
            Vector3::new(0.0, 0.0, 4.0).into(),
            UnitQuaternion::from_rotation_matrix(&rotation),
        ),
    }
}

struct Set {
    model: BodyModel,
    shape: Shape,
    rig: Rig,
    truth: Motion,
}

impl Set {
    /// Two cameras that see the body from the front and from the side, too far apart for stereo.
    fn new() -> Self {
        let model = model::load("human-metaballs", "".as_ref()).expect("a shipped model");
        Self {
            shape: Shape(model.statistics.mean.clone()),
            truth: Motion::rest(&model),
            rig: Rig { cameras: vec![camera("front", 0.0), camera("side", 80.0)] },
            model,
        }
    }

    fn mask(&self, camera: usize) -> Mask {
        let body = Posed::new(&self.model, &self.shape, &self.truth);
        render::silhouette(&self.rig.cameras[camera], &Field::from_body(&body))
    }

    /// The body bright before a dark ground; what is not `shown` is a flat picture.
    fn pictures(&self, shown: [bool; 2]) -> Vec<Option<Picture>> {
        (0..2)
            .map(|i| {
                let (mask, is_shown) = (self.mask(i), shown[i]);
                let value = |k: usize| {
                    let (x, y) = (k % SIZE.0 as usize, k / SIZE.0 as usize);
                    [if is_shown && mask.is_foreground(x, y) { 190 } else { 50 }; 3]
                };
                let count = (SIZE.0 * SIZE.1) as usize;
                let values = (0..count).map(value).collect();
                Plane::from_values(SIZE.0 as usize, SIZE.1 as usize, values)
            })
            .collect()
    }

    fn frame(&self, shown: [bool; 2]) -> UndistortedFrame {
        let pictures = self.pictures(shown);
        UndistortedFrame::new(&self.rig, &pictures).expect("pictures of the cameras' sizes")
    }

    fn evidence(&self) -> Evidence<'_> {
        let likelihood = LikelihoodOptions::default();
        Evidence::new(&self.model, &self.rig, likelihood, Measure::Metaballs)
    }

    /// Overlap of a body's own outline with the person, of either camera.
    fn overlaps(&self, shape: &Shape, motion: &Motion) -> [f64; 2] {
        let field = Field::from_body(&Posed::new(&self.model, shape, motion));
        [0, 1].map(|i| overlap(&render::silhouette(&self.rig.cameras[i], &field), &self.mask(i)))
    }

    /// A turn of the joint pipeline from a body that stands so far off.
    fn followed(&self, frame: &UndistortedFrame, off_m: Vector3<f64>) -> Followed {
        let mut start = self.truth.clone();
        start.position_world += off_m;
        let first = self.sighting(frame, &self.shape, &start);
        let (_, motion) = self.fitted(first.observed, &self.shape, start);
        let seen = self.sighting(frame, &self.shape, &motion).views;
        Followed { motion, seen }
    }

    /// What is seen of a body.
    fn sighting(&self, frame: &UndistortedFrame, shape: &Shape, motion: &Motion) -> FrameSighting {
        let body = Posed::new(&self.model, shape, motion);
        let still = StillScenes::default();
        let options = ContourOptions::default();
        let scene = Scene::new(&self.rig, frame, &still, &body, options);
        scene.sighting(FrameIndex(0), &body, &SkinScale::new(&self.model))
    }

    /// The joint optimum of one frame.
    fn fitted(&self, seen: FrameObservations, shape: &Shape, motion: Motion) -> (Shape, Motion) {
        let sequence = Sequence { frames: &[seen], fps: 25.0 };
        let start = SequenceState::new(shape.clone(), vec![motion]);
        let options = JointOptions::default();
        let joint = joint_optimum(&self.evidence(), sequence, start, &options);
        (joint.shape, joint.frames[0].motion.clone())
    }
}

/// A body that was fitted to its contours, and its contours then.
struct Followed {
    motion: Motion,
    seen: Vec<Option<ViewSighting>>,
}

fn overlap(one: &Mask, other: &Mask) -> f64 {
    let rows = (0..one.height()).flat_map(|y| one.row(y).iter().zip(other.row(y)));
    let (both, either) = rows.fold((0u32, 0u32), |(both, either), (a, b)| {
        (both + u32::from(a & b), either + u32::from(a | b))
    });
    f64::from(both) / f64::from(either)
}

fn points(followed: &Followed, camera: usize) -> Vec<FoundPoint> {
    let seen = followed.seen[camera].as_ref().expect("a picture");
    seen.contours.outer.concat()
}

const OFF: Vector3<f64> = Vector3::new(0.0, 0.03, 0.02);

#[test]
fn a_body_that_stands_off_by_36_mm_is_drawn_to_its_pictures_by_any_number_of_threads() {
    let set = Set::new();
    let frame = set.frame([true, true]);
    let of = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        let pool = pool.build().expect("a few threads");
        pool.install(|| set.followed(&frame, OFF))
    };
    let (one, two) = (of(1), of(2));
    assert_eq!(one.motion, two.motion);
    for camera in 0..2 {
        assert_eq!(points(&one, camera), points(&two, camera));
        let found = one.seen[camera].as_ref().expect("a picture");
        let found = found.contours.mask(&set.rig.cameras[camera]);
        let overlap = overlap(&found, &set.mask(camera));
        assert!(overlap > 0.85, "{overlap}");
    }
}

#[test]
fn a_flat_picture_is_told_for_its_view_and_does_not_count_there() {
    let set = Set::new();
    let followed = set.followed(&set.frame([true, false]), OFF);
    let faults = |camera: usize| {
        let seen = followed.seen[camera].as_ref().expect("a picture");
        seen.contours.faults.clone()
    };
    assert!(!faults(0).contains(&ContourFault::Flat));
    assert!(faults(1).contains(&ContourFault::Flat));
    assert!(points(&followed, 1).iter().all(|p| p.reliability <= 0.0));
}

#[test]
fn a_body_that_nobody_sees_is_told_and_stays_where_it_is() {
    let set = Set::new();
    let far = Vector3::new(0.0, 0.0, 30.0);
    let followed = set.followed(&set.frame([true, true]), far);
    for seen in followed.seen.iter().flatten() {
        assert!(seen.contours.faults.contains(&ContourFault::NoOutline));
        assert!(seen.contours.silhouette.is_none());
    }
    assert!(followed.motion.position_world.iter().all(|x| x.is_finite()));
}

#[test]
fn a_body_too_large_is_mended_by_a_fit_to_the_contours_that_it_finds() {
    let set = Set::new();
    let frame = set.frame([true, true]);
    let wrong = Shape(set.shape.0.add_scalar(0.01));
    let seen = set.sighting(&frame, &wrong, &set.truth);
    let (shape, motion) = set.fitted(seen.observed, &wrong, set.truth.clone());
    let before = set.overlaps(&wrong, &set.truth);
    let after = set.overlaps(&shape, &motion);
    for (before, after) in before.into_iter().zip(after) {
        assert!(1.0 - after < 0.55 * (1.0 - before), "{before} {after}");
    }
}

/// Overlap of what a pipeline finds in the last of four frames with the person, who goes 3 cm aside from frame to frame; the start
/// stands where the first frame has them.
fn overlaps_of_who_goes_aside(pipeline: SilhouettePipeline) -> [f64; 2] {
    let moved = |frame: usize| {
        let mut set = Set::new();
        set.truth.position_world.y += 0.03 * frame as f64;
        set
    };
    let sets: Vec<Set> = (0..4).map(moved).collect();
    let first = &sets[0];
    let seen = |(i, set): (usize, &Set)| (FrameIndex(i), set.pictures([true, true]));
    let pictures = MemoryPictures {
        rig: first.rig.clone(),
        fps: 25.0,
        frames: sets.iter().enumerate().map(seen).collect(),
        ..MemoryPictures::default()
    };
    let frames: Vec<FrameIndex> = (0..4).map(FrameIndex).collect();
    let motions = frames.iter().map(|frame| (*frame, first.truth.clone())).collect();
    let start =
        StartingFit::from_motions(first.shape.clone(), motions, &pictures, &frames, &NoProgress);
    let search = SilhouetteSearch {
        pictures: &pictures,
        frames: &frames,
        model: &first.model,
        start: &start,
        pipeline,
    };

    let mut last = [0.0; 2];
    let taken = search.run(&NoProgress, |found| {
        last = [0, 1].map(|i| {
            let seen = found.sighting.views[i].as_ref().expect("a picture");
            overlap(&seen.contours.mask(&first.rig.cameras[i]), &sets[found.frame.0].mask(i))
        });
        Ok::<(), std::convert::Infallible>(())
    });
    assert_eq!(taken.map(|found| found.observations.len()), Ok(4));
    last
}

#[test]
fn frame_after_frame_follows_who_leaves_the_first_fit_and_the_simple_pipeline_does_not() {
    let [followed, left] = [SilhouettePipeline::FrameAfterFrame, SilhouettePipeline::Simple]
        .map(overlaps_of_who_goes_aside);
    assert!(followed.iter().all(|overlap| *overlap > 0.85), "{followed:?}");
    assert!(left[0] < 0.8, "{left:?}");
}
