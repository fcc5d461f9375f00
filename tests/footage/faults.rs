//! Bad footage: one line each, and what is good is kept.

use std::fs;

use crate::tiny::{are_in_place, calibration, folder, image, read, video, write};
use maquette::Recording;
use maquette::io::recording::footage::FootageNote;

fn complaint(folder: &tempfile::TempDir) -> String {
    let message = Recording::open(folder.path())
        .and_then(|found| found.footage())
        .expect_err("a fault")
        .to_string();
    assert!(!message.contains('\n'), "{message}");
    message
}

const VIDEO: &str = "fps = 25\n[[camera]]\nname = \"a\"\nvideo = \"v.avi\"\n";

#[test]
fn a_video_that_ends_early_gives_what_it_has() {
    let folder = folder();
    if !video(&folder, "v.avi", 20, &["-c:v", "mjpeg"]) {
        return;
    }
    let path = folder.path().join("v.avi");
    let bytes = fs::read(&path).unwrap();
    fs::write(&path, &bytes[..bytes.len() * 6 / 10]).unwrap();
    write(&folder, "sequence.toml", VIDEO);
    let (greys, _) = read(folder.path(), None);
    assert!((8..20).contains(&greys.len()), "{greys:?}");
    assert!(are_in_place(&greys[..greys.len() - 1]), "{greys:?}");
}

#[test]
fn pictures_after_damage_keep_their_numbers() {
    let folder = folder();
    let intra = ["-c:v", "libx264", "-g", "1", "-bf", "0"];
    if !video(&folder, "v.mp4", 20, &intra) {
        return;
    }
    let path = folder.path().join("v.mp4");
    let mut bytes = fs::read(&path).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle - 400..middle + 400].fill(0xA5);
    fs::write(&path, &bytes).unwrap();
    write(&folder, "sequence.toml", VIDEO.replace("avi", "mp4"));
    let (greys, notes) = read(folder.path(), None);
    assert!((5..20).contains(&greys.len()), "{greys:?}");
    assert_eq!(greys.last().map(|(k, _)| *k), Some(19));
    assert!(are_in_place(&greys[greys.len() - 3..]), "{greys:?}");
    assert!(are_in_place(&greys[..3]), "{greys:?}");
    let [FootageNote::Undecodable { frames, of: 20, .. }] = notes.as_slice() else {
        panic!("{notes:?}");
    };
    assert_eq!(frames.0.len() + greys.len(), 20);
    let line = notes[0].to_string();
    assert!(
        line.starts_with("camera a: ") && line.contains("of 20 pictures cannot be decoded"),
        "{line}"
    );
}

#[test]
fn a_file_that_is_no_video_is_named() {
    for (text, part) in
        [("", "no video in this file"), ("not a video at all", "no video in this file")]
    {
        let folder = folder();
        write(&folder, "v.avi", text);
        write(&folder, "sequence.toml", VIDEO);
        let message = complaint(&folder);
        assert!(
            message.contains("v.avi") && (message.contains(part) || message.contains("ffmpeg")),
            "{message}"
        );
    }
}

#[test]
fn a_file_that_is_no_video_costs_its_camera_alone() {
    let folder = folder();
    if !video(&folder, "videos/a.avi", 3, &["-c:v", "mjpeg"]) {
        return;
    }
    write(&folder, "videos/b.avi", "not a video at all");
    let footage = Recording::open(folder.path()).and_then(|found| found.footage()).unwrap();
    assert_eq!(footage.rig.names().collect::<Vec<_>>(), ["a"]);
    assert_eq!(footage.frames().len(), 3);
    let line = footage.notes[0].to_string();
    let parts = ["camera b: ", "no video in this file", ": not used"];
    assert!(parts.iter().all(|part| line.contains(part)), "{line}");
}

#[test]
fn a_video_with_sound_alone_is_named() {
    let folder = folder();
    // a WAV of one silent sample, under a video's name
    let mut wav =
        b"RIFF\x26\0\0\0WAVEfmt \x10\0\0\0\x01\0\x01\0\x40\x1f\0\0\x80\x3e\0\0\x02\0\x10\0data\x02\0\0\0".to_vec();
    wav.extend([0, 0]);
    if !video(&folder, "other.avi", 1, &[]) {
        return;
    }
    write(&folder, "v.avi", wav);
    write(&folder, "sequence.toml", VIDEO);
    let message = complaint(&folder);
    assert!(message.ends_with("no video in this file: it has no video stream"), "{message}");
}

#[test]
fn a_video_that_its_metadata_turn_is_turned() {
    let folder = folder();
    if !video(&folder, "flat.mp4", 5, &[]) {
        return;
    }
    let (flat, turned) = (folder.path().join("flat.mp4"), folder.path().join("v.mp4"));
    let done = std::process::Command::new("ffmpeg")
        .args(["-nostdin", "-v", "error", "-i"])
        .arg(&flat)
        .args(["-c", "copy", "-metadata:s:v:0", "rotate=90"])
        .arg(&turned)
        .status();
    assert!(done.unwrap().success());
    write(&folder, "sequence.toml", VIDEO.replace("avi", "mp4"));
    let message = complaint(&folder);
    assert!(message.contains("48 × 64 px, expected 64 × 48 px as calibrated"), "{message}");
    write(&folder, "calibration.toml", calibration(&["a"], (48, 64)));
    let (greys, notes) = read(folder.path(), None);
    assert_eq!((greys.len(), notes), (5, vec![]));
}

#[test]
fn an_image_that_cannot_be_read_is_left_out() {
    let folder = folder();
    for k in 0..4 {
        image(&folder, &format!("images/a/{k}.png"), 50);
    }
    write(&folder, "images/a/2.png", "nonsense");
    let (greys, notes) = read(folder.path(), Some(25.0));
    assert_eq!(greys.iter().map(|(k, _)| *k).collect::<Vec<_>>(), [0, 1, 3]);
    let line = notes[0].to_string();
    assert!(
        line.starts_with("camera a: 1 of 4 pictures cannot be decoded (2): ")
            && line.contains("2.png"),
        "{line}"
    );
}

#[test]
fn an_image_of_another_size_is_left_out() {
    let folder = folder();
    image(&folder, "images/a/0.png", 50);
    let odd = image::RgbImage::new(10, 10);
    odd.save(folder.path().join("images/a/1.png")).unwrap();
    let (greys, notes) = read(folder.path(), Some(25.0));
    assert_eq!(greys.len(), 1);
    assert_eq!(
        notes[0].to_string(),
        "camera a: 1 picture of another size (10 × 10 px, expected 64 × 48 px): not used"
    );
}

#[test]
fn what_is_promised_and_not_there_is_named() {
    for (keys, part) in [
        ("video = \"gone.mp4\"", "camera a: no video at "),
        ("images = \"gone\"", "camera a: no images at "),
        ("images = \"gone\"\nbackground = \"empty.png\"", "camera a: no background at "),
        ("images = \"i\"\nvideo = \"v\"", "camera a: both images and video"),
        ("masks = \"masks\"", "no pictures: expected videos/<camera>.*"),
    ] {
        let folder = folder();
        write(&folder, "sequence.toml", format!("fps = 25\n[[camera]]\nname = \"a\"\n{keys}\n"));
        let message = complaint(&folder);
        assert!(message.contains(part), "{message}");
    }
}

#[test]
fn images_alone_do_not_tell_the_frame_rate() {
    let folder = folder();
    for name in ["images/a/0.png", "images/a/1.png"] {
        image(&folder, name, 50);
    }
    assert!(complaint(&folder).contains("--fps"));
}
