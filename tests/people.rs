//! Two people in one room: from masks that hold both, and from masks with a value for each, a result for each.

use std::fs;
use std::path::Path;

use image::{GrayImage, Luma};
use maquette::io::calibration::write_toml;
use maquette::io::folder::Existing;
use maquette::io::model;
use maquette::pipeline::{NoProgress, PeopleOptions};
use maquette::silhouette::FrameIndex;
use maquette::synth::{Recipe, Ring, Synthetic};
use maquette::workflow::FitFolder;
use maquette::{FitOptions, FittedRecording, Recording};
use nalgebra::{Point3, Vector3};
use tempfile::TempDir;

const FRAMES: usize = 8;
const FPS: f64 = 25.0;

/// Two who walk side by side; the second is somewhat behind.
fn walkers() -> [Synthetic; 2] {
    let person = model::load("walker-metaballs", Path::new("")).expect("a shipped model");
    let ring =
        Ring { cameras: 5, width_px: 400, height_px: 300, focal_px: 330.0, ..Ring::default() };
    let walker = |seed| {
        let recipe = Recipe {
            seed,
            frames: Some(FRAMES),
            fps: FPS,
            ring: ring.clone(),
            errors: None,
            ..Recipe::default()
        };
        recipe.walker(&person).expect("a walker")
    };
    let [first, mut second] = [1, 2].map(walker);
    second.rig = first.rig.clone();
    for motion in &mut second.motions {
        motion.position_world += Vector3::new(-0.2, 0.7, 0.0);
    }
    [first, second]
}

/// A recording of both, in which a pixel of the first has the first value, and of the second alone the second.
fn recording(people: &[Synthetic; 2], values: [u8; 2]) -> TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    fs::write(folder.path().join("calibration.toml"), write_toml(&people[0].rig)).expect("a file");
    for (id, camera) in people[0].rig.iter() {
        let masks = folder.path().join("masks").join(&camera.name);
        fs::create_dir_all(&masks).expect("a folder");
        for frame in 0..FRAMES {
            let masks_of = |person: &Synthetic| person.true_mask(FrameIndex(frame), id);
            let [first, second] = [0, 1].map(|k| masks_of(&people[k]).expect("a mask"));
            let value = |x: u32, y: u32| {
                let is_shown = |m: &maquette::image::Mask| m.is_foreground(x as usize, y as usize);
                let shown = [is_shown(&first), is_shown(&second)];
                shown.iter().zip(values).find(|(shown, _)| **shown).map_or(0, |(_, value)| value)
            };
            let image =
                GrayImage::from_fn(camera.width_px, camera.height_px, |x, y| Luma([value(x, y)]));
            image.save(masks.join(format!("{frame:06}.png"))).expect("a file");
        }
    }
    folder
}

fn options(person: usize) -> FitOptions {
    let mut options = FitOptions { body: Some("human-ellipsoids".into()), ..FitOptions::default() };
    options.observations.people = PeopleOptions { person, ..PeopleOptions::default() };
    options
}

/// The mean distance of a fit's joints from a person's, m.
fn off_m(fit: &FittedRecording, person: &Synthetic) -> f64 {
    let mut all = Vec::new();
    for frame in &fit.result.motion.frames {
        let truth = person.points(FrameIndex(frame.frame)).expect("a frame");
        for name in ["RHip", "LKnee", "RAnkle", "LShoulder", "RElbow", "LWrist"] {
            let index = fit.result.motion.points.iter().position(|point| point == name);
            let place = Point3::from(frame.points_m[index.expect("a joint")]);
            all.push((place - truth[person.model.point(name).expect("a joint")]).norm());
        }
    }
    all.iter().sum::<f64>() / all.len() as f64
}

#[test]
fn masks_that_hold_two_people_give_a_result_for_each() {
    let people = walkers();
    let (folder, out) = (recording(&people, [255, 255]), tempfile::tempdir().expect("a folder"));
    let path = out.path().join("fit");
    let recording = Recording::open(folder.path()).expect("a recording").with_fps(FPS);
    let into = FitFolder { path: &path, existing: Existing::Refuse, overlays: false };
    let first = recording.fit_into(into, &options(1), &NoProgress).expect("a fit");
    let second = FittedRecording::read(path.join("people/2"), None).expect("the other's fit");

    let told = |fit: &FittedRecording, line: &str| {
        fit.result.warnings.iter().any(|warning| warning.contains(line))
    };
    assert!(told(&first, "2 people are seen: person 1 is measured here"));
    let off = |fit: &FittedRecording| people.each_ref().map(|person| off_m(fit, person));
    let (a, b) = (off(&first), off(&second));
    assert!(first.result.verdict.is_usable() && second.result.verdict.is_usable());
    let (near, far) =
        if a[0] < a[1] { ([a[0], b[1]], [a[1], b[0]]) } else { ([a[1], b[0]], [a[0], b[1]]) };
    assert!(near.iter().all(|off| *off < 0.03), "{near:?}");
    assert!(far.iter().all(|off| *off > 0.3), "{far:?}");
}

#[test]
fn masks_with_a_value_for_each_person_name_them_and_one_who_is_not_there_is_named() {
    let people = walkers();
    let folder = recording(&people, [3, 1]);
    // in one picture nobody was told apart, and in none was anybody detected
    let of_camera =
        |of: &str| folder.path().join(of.replace("CAMERA", &people[0].rig.cameras[0].name));
    let white = of_camera("masks/CAMERA/000000.png");
    let mut image = image::open(&white).expect("a mask").into_luma8();
    image.iter_mut().filter(|value| **value > 0).for_each(|value| *value = 255);
    image.save(&white).expect("a file");
    fs::create_dir_all(of_camera("pose/CAMERA_json")).expect("a folder");
    fs::write(of_camera("pose/CAMERA_json/000000.json"), "{\"people\": []}").expect("a file");

    let recording = Recording::open(folder.path()).expect("a recording").with_fps(FPS);
    // the lowest value is the second walker's
    let fit = recording.fit(&options(1)).expect("a fit");
    let off = off_m(&fit, &people[1]);
    assert!(off < 0.03, "{off} m");
    let nobody = "detections: none is of the person whom the masks show: not used";
    assert!(fit.result.warnings.iter().any(|warning| warning == nobody));
    let fault = recording.fit(&options(3)).expect_err("there are two");
    assert_eq!(fault.to_string(), "person 3 was asked for, and 2 people are seen: --person 1 to 2");
}
