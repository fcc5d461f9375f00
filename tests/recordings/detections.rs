//! Detections of a recording: where they are looked for, whose they are, and each way for them to be bad.

use maquette::silhouette::FrameObservations;
use tempfile::TempDir;

use crate::tiny::{assert_complains, load, open, recording, with_manifest, write};

/// A person of COCO's 17 points with the nose here, the others around it; nothing of the left ankle.
fn person(x: f64, y: f64) -> String {
    let point = |i: usize| match i {
        15 => "0, 0, 0".to_owned(),
        _ => format!("{}, {}, 0.8", x + (i % 3) as f64, y + i as f64),
    };
    let points: Vec<String> = (0..17).map(point).collect();
    format!("{{\"pose_keypoints_2d\": [{}]}}", points.join(", "))
}

fn people(all: &[String]) -> String {
    format!("{{\"version\": 1.3, \"people\": [{}]}}", all.join(", "))
}

/// Two cameras, of which the first has detections in two of three frames: somebody else, then the person.
fn with_detections() -> TempDir {
    let folder = recording(&["cam_a", "cam_b"]);
    let pose = folder.path().join("pose");
    let two = people(&[person(50.0, 12.0), person(28.0, 14.0)]);
    write(pose.join("cama_json/cama_000000000000_keypoints.json"), &two);
    write(pose.join("cama_json/cama_000000000002_keypoints.json"), people(&[]));
    write(pose.join("elsewhere_json/000000.json"), &two);
    folder
}

fn noses(frame: &FrameObservations) -> Vec<(usize, f64, usize)> {
    let nose = |(id, d): &(maquette::camera::CameraId, maquette::silhouette::Detection)| {
        let nose = d.keypoint("Nose").expect("a nose");
        (id.0, nose.pixel.x, d.keypoints.len())
    };
    frame.detections.iter().map(nose).collect()
}

#[test]
fn detections_beside_masks_are_found_and_the_person_in_the_mask_is_taken() {
    let folder = with_detections();
    // the left ankle was not seen
    assert_eq!(noses(&load(folder.path(), 0).unwrap()), [(0, 28.0, 16)]);
    for frame in [1, 2] {
        assert!(load(folder.path(), frame).unwrap().detections.is_empty(), "{frame}");
    }
    let inputs = open(folder.path()).unwrap().checksums().unwrap();
    let own = inputs.iter().find(|input| input.input == "detections of cam_a").unwrap();
    assert_eq!(own.files, 2);
}

#[test]
fn a_manifest_says_where_they_are_and_how_the_clocks_differ() {
    let folder = with_manifest(
        &["a", "b"],
        "keypoints = \"COCO_17\"\n[[camera]]\nname = \"a\"\nmasks = \"masks/a\"\n\
         detections = \"found/*.json\"\noffset_frames = 1\n[[camera]]\nname = \"b\"\nmasks = \"masks/b\"\n",
    );
    write(folder.path().join("found/7_0.json"), people(&[person(28.0, 14.0)]));
    let frames: Vec<_> = (0..4).map(|i| load(folder.path(), i).unwrap()).collect();
    let with: Vec<usize> =
        frames.iter().filter(|f| !f.detections.is_empty()).map(|f| f.frame.0).collect();
    assert_eq!(with, [1], "file 0, one frame late");
}

#[test]
fn what_is_wrong_with_them_is_said_in_one_line() {
    let spoiled = |text: &str| {
        let folder = with_detections();
        write(folder.path().join("pose/cama_json/cama_000000000000_keypoints.json"), text);
        folder
    };
    let whole = people(&[person(28.0, 14.0)]);
    let cut = &whole[..whole.len() / 2];
    assert_complains(open(spoiled(cut).path()), &["000000000000_keypoints.json", "OpenPose"]);
    let large = people(&[person(1200.0, 700.0)]);
    assert_complains(open(spoiled(&large).path()), &["cam_a", "1202", "64 × 48", "another size"]);
    let strange = "{\"people\": [{\"pose_keypoints_2d\": [1, 2, 0.5, 3, 4, 0.5]}]}";
    assert_complains(open(spoiled(strange).path()), &["people of 2 points", "halpe26"]);

    let manifest = "[[camera]]\nname = \"a\"\nmasks = \"masks/a\"\ndetections = \"none\"\n\
                    [[camera]]\nname = \"b\"\nmasks = \"masks/b\"\n";
    let folder = with_manifest(&["a", "b"], manifest);
    assert_complains(open(folder.path()), &["camera a", "no detections", "none"]);
}
