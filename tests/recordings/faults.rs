//! Each way for a recording to be bad, and what is said of it.

use std::fs;
use std::path::Path;

use image::{GrayImage, ImageFormat, Luma};
use maquette::io::recording::{Recording, RecordingError};
use maquette::silhouette::SilhouetteOptions;

use crate::tiny::{
    SIZE, assert_complains, calibration, is_person, load, mask, open, recording, save,
    with_manifest, write,
};

#[test]
fn a_missing_recording_is_named() {
    assert_complains(open(Path::new("no/where")), &["no/where: no such folder or file"]);
    let empty = tempfile::tempdir().expect("a folder");
    assert_complains(
        Recording::open(empty.path()).and_then(|found| found.observations()),
        &["no masks and no pictures: expected masks/<camera>/"],
    );
    let folder = recording(&["a", "b"]);
    fs::remove_file(folder.path().join("calibration.toml")).expect("removed");
    assert!(matches!(open(folder.path()), Err(RecordingError::Calibration(_))));
}

#[test]
fn a_frame_rate_must_be_known_and_positive() {
    let folder = recording(&["a", "b"]);
    assert_complains(
        Recording::open(folder.path()).and_then(|found| found.observations()),
        &["frame rate is not known", "--fps"],
    );
    for fps in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert_complains(
            Recording::open(folder.path()).and_then(|found| found.with_fps(fps).observations()),
            &["expected a frame rate"],
        );
    }
    let folder = with_manifest(&["a", "b"], "fps = 0\n");
    assert_complains(
        Recording::open(folder.path()).and_then(|found| found.observations()),
        &["sequence.toml:1: fps = 0"],
    );
}

#[test]
fn video_alone_has_no_masks() {
    let folder = with_manifest(&["a", "b"], "[[camera]]\nname = \"a\"\nvideo = \"a.avi\"\n");
    assert_complains(open(folder.path()), &["no masks and no pictures", "videos/<camera>.*"]);
}

#[test]
fn cameras_must_be_calibrated_distinct_and_more_than_one() {
    let two = |a: &str, b: &str| {
        let camera = |name| format!("[[camera]]\nname = \"{name}\"\nmasks = \"masks/a\"\n");
        with_manifest(&["a", "b"], &(camera(a) + &camera(b)))
    };
    let folder = two("a", "z");
    assert_complains(open(folder.path()), &["no camera \"z\"", "it has a, b"]);
    let folder = two("a", "a");
    assert_complains(open(folder.path()), &["camera \"a\" is listed 2 times"]);
    let folder = recording(&["a"]);
    assert_complains(open(folder.path()), &["only one camera (a) has masks", "cannot tell size"]);
    let folder = recording(&["a", "b"]);
    write(folder.path().join("calibration.toml"), calibration(&["c", "d"]));
    assert_complains(open(folder.path()), &["no calibrated camera is called a, b", "has c, d"]);
}

#[test]
fn masks_that_are_not_there_are_named() {
    let folder = with_manifest(
        &["a", "b"],
        "[[camera]]\nname = \"a\"\nmasks = \"masks/a/%04d.jpg\"\n[[camera]]\nname = \"b\"\nmasks = \"masks/b\"\n",
    );
    assert_complains(open(folder.path()), &["camera a: no mask at", "masks/a/%04d.jpg"]);
    let manifest = folder.path().join("sequence.toml");
    for (pattern, part) in [
        ("nowhere/%06d.png", "nowhere: the folder cannot be read"),
        ("nowhere", "no mask at"),
        ("masks/a/%06x.png", "expected one %d or %06d"),
        ("masks/**a/*.png", "expected a glob"),
    ] {
        write(manifest.clone(), format!("[[camera]]\nname = \"a\"\nmasks = \"{pattern}\"\n"));
        assert_complains(open(folder.path()), &[part]);
    }
    let folder = recording(&["a", "b"]);
    save(folder.path().join("masks/a/1.jpg"), &mask());
    assert_complains(
        open(folder.path()),
        &["camera a: ", "000001.png", "1.jpg", "are both number 1"],
    );
}

#[test]
fn a_mask_that_cannot_be_used_is_named_with_camera_and_frame() {
    let folder = recording(&["a", "b"]);
    let path = folder.path().join("masks/b/000001.png");
    let whole = fs::read(&path).expect("a mask");
    let labels = GrayImage::from_fn(SIZE.0, SIZE.1, |x, y| Luma([9 * u8::from(is_person(x, y))]));
    let labels_as = |format: ImageFormat| {
        let mut bytes = std::io::Cursor::new(Vec::new());
        labels.write_to(&mut bytes, format).expect("an image");
        bytes.into_inner()
    };
    // a value for each person is a mask, where the file keeps it
    write(path.clone(), labels_as(ImageFormat::Png));
    assert_eq!(load(folder.path(), 1).expect("labels").views.len(), 2);
    for (bytes, part) in [
        (whole[..whole.len() / 2].to_vec(), "cannot be decoded"),
        (Vec::new(), "cannot be decoded"),
        (b"not an image".to_vec(), "cannot be decoded"),
        (with_size(&whole, 100_000, 100_000), "larger than 32768 × 32768 px"),
        (with_size(&whole, 640, 480), "the mask is 640 × 480 px, expected 64 × 48 px"),
        (with_size(&whole, 0, 48), "cannot be decoded"),
        (labels_as(ImageFormat::Jpeg), "a value for each person needs a file without loss (PNG)"),
    ] {
        write(path.clone(), bytes);
        assert_complains(
            load(folder.path(), 1),
            &["masks/b/000001.png: camera b, frame 1: ", part],
        );
        assert_eq!(load(folder.path(), 0).expect("another frame").views.len(), 2);
    }
    let recording = open(folder.path()).expect("a recording");
    fs::remove_file(&path).expect("removed");
    let options = SilhouetteOptions::default();
    assert_complains(
        recording.load_frame(1, &options),
        &["camera b, frame 1: the mask cannot be read"],
    );
    assert_complains(recording.load_frame(3, &options), &["position 3 of a recording of 3"]);
}

/// A PNG with another size in its header.
fn with_size(png: &[u8], width: u32, height: u32) -> Vec<u8> {
    let mut png = png.to_vec();
    png[16..20].copy_from_slice(&width.to_be_bytes());
    png[20..24].copy_from_slice(&height.to_be_bytes());
    let sum = png[12..29].iter().fold(u32::MAX, |sum, byte| {
        (0..8).fold(sum ^ u32::from(*byte), |sum, _| {
            (sum >> 1) ^ (0xEDB8_8320 & (sum & 1).wrapping_neg())
        })
    });
    png[29..33].copy_from_slice(&(!sum).to_be_bytes());
    png
}
