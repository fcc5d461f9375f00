//! A bag in a hand moves with the person, and all masks hold it.

use maquette::body::Posed;
use maquette::body::metaball::Field;
use maquette::image::Mask;
use maquette::inference::search::NoJournal;
use maquette::pipeline::{Cause, EstimateOptions, Fit, fit};
use maquette::render::silhouette;
use maquette::silhouette::{FrameIndex, FrameObservations, SilhouetteOptions, extract};
use maquette::synth::{Recipe, Ring};
use nalgebra::{Point2, Point3, Vector3};

const FRAMES: usize = 12;
const FPS: f64 = 12.5;

/// The fit of a walker with bags of a shape: balls below the right wrist, each so far from it and so large.
fn fitted(bag: &[(Vector3<f64>, f64)]) -> Fit {
    let model = maquette::io::model::load("human-metaballs", std::path::Path::new(""));
    let model = model.expect("a shipped model");
    let ring = Ring { width_px: 320, height_px: 240, focal_px: 250.0, ..Ring::default() };
    let recipe = Recipe { frames: Some(FRAMES), fps: FPS, ring, ..Recipe::default() };
    let walker = recipe.walker(&model).expect("a walk");
    let wrist = model.points.iter().position(|point| point.name == "RWrist").expect("a wrist");
    let shown = |number: usize| {
        let body = Posed::new(&model, &walker.shape, &walker.motions[number]);
        let (field, wrist) = (Field::from_body(&body), body.points()[wrist]);
        let views = walker.rig.iter().map(|(id, camera)| {
            let disk = |(from_wrist, radius_m): &(Vector3<f64>, f64)| {
                let middle: Point3<f64> = wrist + from_wrist;
                let depth_m = (camera.camera_from_world * middle).z;
                let radius_px = radius_m * camera.intrinsics.focal_px() / depth_m;
                (camera.project(&middle).expect("before it"), radius_px)
            };
            let disks: Vec<(Point2<f64>, f64)> = bag.iter().map(disk).collect();
            let person = silhouette(camera, &field);
            let mask = Mask::from_fn(person.width(), person.height(), |x, y| {
                let pixel = Point2::new(x as f64, y as f64);
                let is_in = |(middle, radius): &(Point2<f64>, f64)| {
                    nalgebra::distance(middle, &pixel) < *radius
                };
                person.is_foreground(x, y) || disks.iter().any(is_in)
            });
            (id, extract(&mask, camera, &SilhouetteOptions::default()).expect("it is seen"))
        });
        FrameObservations {
            views: views.collect(),
            ..FrameObservations::nothing(FrameIndex(number))
        }
    };
    let frames: Vec<FrameObservations> = (0..FRAMES).map(shown).collect();
    let sequence = maquette::inference::Sequence { frames: &frames, fps: FPS };
    fit(&model, &walker.rig, sequence, &EstimateOptions::default(), &NoJournal).expect("a fit")
}

#[test]
fn a_bag_is_named_and_the_body_stays_within_the_masks() {
    let bag = [-0.15, 0.0, 0.15].map(|ahead| (Vector3::new(ahead, 0.0, -0.3), 0.1));
    let with_bag = fitted(&bag);
    let causes = &with_bag.verdict.causes;
    let [Cause::Worn { share: before }] = causes[..] else { panic!("{causes:?}") };
    let views = with_bag.frames.iter().flat_map(|frame| &frame.views);
    let (count, astray) = views.fold((0, 0.0), |(n, sum), view| (n + 1, sum + view.astray));
    let after = astray / f64::from(count);
    assert!(after < 0.5 * before, "{before} {after}");

    let without = fitted(&[]);
    assert_eq!(without.verdict.causes, []);
}
