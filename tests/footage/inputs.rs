//! What a fit of pictures reads, as fingerprints.

use crate::tiny::{folder, image, write};
use maquette::io::recording::InputChecksum;
use maquette::{FitOptions, Recording};
use tempfile::TempDir;

/// Two cameras with two pictures each.
fn filmed() -> TempDir {
    let folder = folder();
    write(&folder, "sequence.toml", "fps = 25\n");
    for name in ["a/0", "a/1", "b/0", "b/1"] {
        image(&folder, &format!("images/{name}.png"), 50);
    }
    folder
}

fn inputs(folder: &TempDir) -> Vec<InputChecksum> {
    let recording = Recording::open(folder.path()).expect("a recording");
    recording.inputs(&FitOptions::default()).expect("inputs")
}

#[test]
fn without_masks_the_pictures_are_inputs_of_a_fit() {
    let names: Vec<String> = inputs(&filmed()).into_iter().map(|input| input.input).collect();
    let expected = ["sequence.toml", "calibration.toml", "pictures of a", "pictures of b"];
    assert_eq!(names[..4], expected);
    // the body, and the one that it is made from
    assert_eq!(names[4..], ["body human-metaballs", "body human-ellipsoids"]);
}

#[test]
fn inputs_are_the_same_elsewhere() {
    assert_eq!(inputs(&filmed()), inputs(&filmed()));
}

#[test]
fn a_picture_that_changes_changes_its_camera_alone() {
    let folder = filmed();
    let before = inputs(&folder);
    image(&folder, "images/b/1.png", 51);
    let changed = before.iter().zip(inputs(&folder)).filter(|(was, is)| *was != is);
    let changed: Vec<String> = changed.map(|(_, is)| is.input).collect();
    assert_eq!(changed, ["pictures of b"]);
}

#[test]
fn beside_masks_pictures_do_not_count() {
    let folder = filmed();
    for name in ["a/0", "a/1", "b/0", "b/1"] {
        image(&folder, &format!("masks/{name}.png"), 255);
    }
    let before = inputs(&folder);
    image(&folder, "images/b/1.png", 51);
    assert_eq!(before, inputs(&folder));
    image(&folder, "masks/b/1.png", 0);
    assert_ne!(before, inputs(&folder));
}
