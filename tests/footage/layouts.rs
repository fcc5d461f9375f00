//! Good footage of every layout.

use crate::tiny::{are_in_place, folder, greys, image, read, video, write};
use maquette::Recording;
use maquette::camera::CameraId;
use maquette::io::recording::footage::FootageNote;
use maquette::pipeline::PictureStream;
use maquette::silhouette::FrameIndex;

const TWO: &str = "fps = 25\n[[camera]]\nname = \"a\"\n";

fn manifest_of_video(file: &str) -> String {
    format!("{TWO}video = \"{file}\"\n")
}

#[test]
fn a_folder_of_videos_needs_no_manifest_and_no_frame_rate() {
    let folder = folder();
    if !(video(&folder, "videos/a.mp4", 12, &[]) && video(&folder, "videos/b.mp4", 10, &[])) {
        return;
    }
    let footage = Recording::open(folder.path()).and_then(|found| found.footage()).unwrap();
    assert!((footage.fps - 25.0).abs() < 1e-9);
    assert_eq!(footage.rig.names().collect::<Vec<_>>(), ["a", "b"]);
    let lengths = vec![("a".into(), 12), ("b".into(), 10)];
    assert_eq!(footage.notes, [FootageNote::Lengths { cameras: lengths }]);
    let mut sets = footage.frame_sets(0..=usize::MAX);
    let seen: Vec<(FrameIndex, usize)> =
        sets.by_ref().map(|(frame, p)| (frame, p.iter().flatten().count())).collect();
    assert_eq!(seen.len(), 12);
    assert_eq!((seen[9].1, seen[10]), (2, (FrameIndex(10), 1)));
    assert_eq!(sets.notes(), [""; 0]);
}

#[test]
fn every_picture_of_a_video_is_there_in_order_whatever_its_format() {
    for (name, options) in [
        ("b_frames.mp4", &["-c:v", "libx264", "-bf", "3"][..]),
        ("mpeg4.avi", &["-c:v", "mpeg4", "-bf", "2"]),
        ("ten_bit.mkv", &["-c:v", "ffv1", "-pix_fmt", "yuv420p10le"]),
        ("grey.mkv", &["-c:v", "ffv1", "-pix_fmt", "gray"]),
        ("sixteen.mkv", &["-c:v", "ffv1", "-pix_fmt", "gray16le"]),
        ("alpha.mov", &["-c:v", "png", "-pix_fmt", "rgba"]),
        ("full.mkv", &["-c:v", "mjpeg", "-q:v", "2"]),
        ("raw.h264", &["-c:v", "libx264", "-bf", "2"]),
    ] {
        let folder = folder();
        if !video(&folder, name, 20, options) {
            return;
        }
        write(&folder, "sequence.toml", manifest_of_video(name));
        let (greys, notes) = read(folder.path(), None);
        let numbers: Vec<usize> = greys.iter().map(|(k, _)| *k).collect();
        assert_eq!(numbers, (0..20).collect::<Vec<_>>(), "{name}: {notes:?}");
        assert!(are_in_place(&greys), "{name}: {greys:?}");
        assert_eq!(notes, [], "{name}");
    }
}

#[test]
fn a_video_of_varying_rate_keeps_to_the_clock() {
    let folder = folder();
    let drop = "select='not(between(n,4,7))'";
    if !video(&folder, "v.mp4", 12, &["-vf", drop, "-fps_mode", "passthrough"]) {
        return;
    }
    write(&folder, "sequence.toml", manifest_of_video("v.mp4"));
    let (greys, _) = read(folder.path(), None);
    let numbers: Vec<usize> = greys.iter().map(|(k, _)| *k).collect();
    assert_eq!(numbers, [0, 1, 2, 3, 8, 9, 10, 11, 12, 13, 14, 15]);
    assert!(are_in_place(&greys), "{greys:?}");
}

#[test]
fn a_range_of_frames_is_decoded_and_no_more() {
    let folder = folder();
    if !video(&folder, "v.mp4", 20, &[]) {
        return;
    }
    write(&folder, "sequence.toml", format!("{}offset_frames = 3\n", manifest_of_video("v.mp4")));
    let footage = Recording::open(folder.path()).and_then(|found| found.footage()).unwrap();
    let (greys, notes) = greys(footage.stream(CameraId(0), 10..=12));
    let numbers: Vec<usize> = greys.iter().map(|(k, _)| *k).collect();
    assert_eq!((numbers, notes), (vec![10, 11, 12], vec![]));
    let shifted: Vec<_> = greys.iter().map(|(k, grey)| (k - 3, *grey)).collect();
    assert!(are_in_place(&shifted), "{greys:?}");
}

#[test]
fn images_are_numbered_by_their_names_and_shifted_by_the_clock() {
    let folder = folder();
    for k in [4_u8, 7, 8] {
        image(&folder, &format!("images/a/{k:06}.png"), 10 * k);
        image(&folder, &format!("images/b/{k:06}.png"), 20 * k);
    }
    let footage =
        Recording::open(folder.path()).and_then(|found| found.with_fps(50.0).footage()).unwrap();
    let sets: Vec<_> = footage.frame_sets(5..=7).collect();
    assert_eq!((sets.len(), sets[0].0), (1, FrameIndex(7)));
    let second = sets[0].1[1].as_ref().unwrap();
    assert_eq!(second.get(3, 3), Some([140; 3]));
    write(
        &folder,
        "sequence.toml",
        "fps = 50\n[[camera]]\nname = \"b\"\nimages = \"images/b/%06d.png\"\nstart_s = 0.1\n",
    );
    let footage = Recording::open(folder.path()).and_then(|found| found.footage()).unwrap();
    assert_eq!(footage.frames(), [9, 12, 13].map(FrameIndex));
}

#[test]
fn a_video_named_almost_as_its_camera_is_that_cameras() {
    let folder = folder();
    write(
        &folder,
        "calibration.toml",
        crate::tiny::calibration(&["cam_01", "cam_02"], crate::tiny::SIZE),
    );
    for k in 0..2 {
        image(&folder, &format!("images/Cam01/{k}.png"), 50);
        image(&folder, &format!("images/cam02/{k}.png"), 50);
        image(&folder, &format!("images/other/{k}.png"), 50);
    }
    let footage =
        Recording::open(folder.path()).and_then(|found| found.with_fps(50.0).footage()).unwrap();
    assert_eq!(footage.rig.names().collect::<Vec<_>>(), ["cam_01", "cam_02"]);
    let unknown = FootageNote::Uncalibrated { camera: "other".into() };
    assert_eq!(footage.notes, [unknown]);
}

#[test]
fn the_empty_scene_is_an_image_or_a_video() {
    let folder = folder();
    image(&folder, "images/a/0.png", 50);
    image(&folder, "images/b/0.png", 50);
    image(&folder, "background/a.png", 30);
    if !video(&folder, "background/b.mp4", 5, &[]) {
        return;
    }
    let footage =
        Recording::open(folder.path()).and_then(|found| found.with_fps(50.0).footage()).unwrap();
    assert_eq!(greys(footage.background(CameraId(0))).0, [(0, 30.0)]);
    assert_eq!(greys(footage.background(CameraId(1))).0.len(), 5);
    assert_eq!(footage.background(CameraId(9)).count(), 0);
}

#[test]
fn whoever_stops_early_ends_the_decoder() {
    let folder = folder();
    if !video(&folder, "videos/a.mp4", 25, &[]) {
        return;
    }
    let footage = Recording::open(folder.path()).and_then(|found| found.footage()).unwrap();
    let first = footage.stream(CameraId(0), 0..=usize::MAX).next();
    assert_eq!(first.map(|(frame, _)| frame), Some(FrameIndex(0)));
}
