//! From pictures to masks, and from pictures to a fit.

use std::fs;
use std::path::Path;

use assert_cmd::Command;
use image::{Rgb, RgbImage};

use crate::arm::{Arm, FRAMES, SIZE, mask, program, rig, run};

/// A textured wall, with grain.
fn wall(x: u32, y: u32, grain: u32) -> [u8; 3] {
    let random = (x * 7919 + y * 104_729 + grain * 1_299_709) % 7;
    let value = (90 + 40 * ((x / 9 + y / 7) % 2) + random) as u8;
    [value, value + 20, value - 20]
}

fn save(path: &Path, colour: impl Fn(u32, u32) -> [u8; 3]) {
    fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
    let picture = RgbImage::from_fn(SIZE.0, SIZE.1, |x, y| Rgb(colour(x, y)));
    picture.save(path).expect("a picture");
}

/// The arm's recording as photographs, with the empty wall, in the place of masks.
pub(crate) fn photographed() -> Arm {
    let arm = Arm::new();
    let folder = arm.recording();
    for camera in &rig().cameras {
        let empty = folder.join(format!("background/{}.png", camera.name));
        save(&empty, |x, y| wall(x, y, 1000));
        for frame in 0..FRAMES {
            let mask = mask(camera, frame);
            let path = folder.join(format!("images/{}/{frame:06}.png", camera.name));
            save(&path, |x, y| match mask.get_pixel(x, y).0[0] {
                0 => wall(x, y, frame as u32),
                _ => [210, 60 + ((x + y) % 5) as u8, 50],
            });
        }
    }
    fs::remove_dir_all(folder.join("masks")).expect("removed");
    arm
}

fn segment(arm: &Arm, more: &[&str]) -> crate::arm::Ran {
    let (recording, out) = (arm.recording(), arm.out("cut"));
    let (recording, out) = (recording.display().to_string(), out.display().to_string());
    let arguments = ["segment", &recording, "--out", &out, "--fps", "10"];
    run(&[&arguments, more].concat())
}

fn overlap(path: &Path, truth: &image::GrayImage) -> f64 {
    let found = image::open(path).expect("a mask").into_luma8();
    let both = found.pixels().zip(truth.pixels());
    let (mut common, mut all) = (0.0, 0.0);
    for (found, truth) in both {
        let (found, truth) = (found.0[0] > 127, truth.0[0] > 127);
        common += f64::from(u8::from(found && truth));
        all += f64::from(u8::from(found || truth));
    }
    common / all
}

#[test]
fn pictures_become_masks_with_a_line_of_quality_for_each() {
    let arm = photographed();
    let said = segment(&arm, &["--probability", "--overlays"]).succeeded();
    assert!(said.out.contains("cam_02") && said.out.contains("18 masks in"), "{}", said.out);
    for camera in &rig().cameras {
        for frame in 0..FRAMES {
            let path = arm.out("cut").join(format!("masks/{}/{frame:06}.png", camera.name));
            let overlap = overlap(&path, &mask(camera, frame));
            assert!(overlap > 0.9, "{} {frame}: {overlap}", camera.name);
        }
    }
    let table = String::from_utf8(arm.bytes("cut", "quality.csv")).expect("UTF-8");
    let head = "frame,camera,area_px,pieces,touches_edge,undecided,unsupported,filled_in";
    assert_eq!(table.lines().next(), Some(head));
    assert_eq!(table.lines().count(), 1 + 3 * FRAMES);
    for picture in ["probability/cam_01/000000.png", "mask-overlays/cam_03/000005.jpg"] {
        image::load_from_memory(&arm.bytes("cut", picture)).expect("a picture");
    }
}

#[test]
fn a_range_of_frames_is_written_and_no_more_and_threads_change_nothing() {
    let arm = photographed();
    let said = segment(&arm, &["--frames", "2:3", "--threads", "1", "--json"]).succeeded();
    crate::schema::check("segment", &said.out);
    let folder = arm.out("cut").join("masks/cam_01");
    let names = fs::read_dir(&folder).expect("masks").count();
    assert_eq!(names, 2);
    let first = arm.bytes("cut", "masks/cam_02/000003.png");
    segment(&arm, &["--frames", "2:3", "--threads", "2", "--overwrite"]).succeeded();
    assert_eq!(arm.bytes("cut", "masks/cam_02/000003.png"), first);
}

#[test]
fn a_recording_of_pictures_is_segmented_and_fitted() {
    let arm = photographed();
    let said = arm.fit("out", &["--joint", "off"]).succeeded();
    assert!(said.err.contains("no masks: the person is cut out of the pictures first"), "{said:?}");
    let result = arm.result("out");
    let iou = result["quality"]["cameras"][0]["mean_iou"].as_f64();
    assert!(iou.is_some_and(|iou| iou > 0.8), "{iou:?}");
    assert!(arm.out("out").join("masks/cam_03/000005.png").is_file(), "kept");
    assert!(arm.out("out").join("quality.csv").is_file());
}

#[test]
#[allow(clippy::print_stderr, reason = "a skipped test says so")]
fn a_camera_whose_video_cannot_be_read_is_in_the_warnings_of_every_run() {
    if Command::new("ffprobe").arg("-version").output().is_err() {
        eprintln!("skipped: ffmpeg is not here");
        return;
    }
    let arm = photographed();
    fs::create_dir_all(arm.recording().join("videos")).expect("a folder");
    fs::write(arm.recording().join("videos/cam_03.mp4"), "a video").expect("written");

    let said = arm.fit("out", &["--joint", "off", "--quiet"]).succeeded();
    let dropped = |text: &str| text.contains("camera cam_03: ") && text.contains(": not used");
    assert!(dropped(&said.err), "{}", said.err);
    assert!(
        dropped(&arm.result("out")["warnings"].to_string()),
        "{}",
        arm.result("out")["warnings"]
    );

    // a run that goes on with the masks of the first knows of it too
    let whole = arm.bytes("out", "result.json");
    fs::remove_file(arm.out("out").join("result.json")).expect("removed");
    arm.fit("out", &["--joint", "off", "--resume"]).succeeded();
    assert_eq!(arm.bytes("out", "result.json"), whole);
}

#[test]
fn bad_pictures_are_told_in_one_line() {
    let arm = photographed();
    segment(&arm, &["--frames", "70:80"]).refused(&["--frames 70:80", "it has 0 to 5"]);
    let empty = arm.recording().join("background/cam_02.png");
    RgbImage::new(10, 10).save(&empty).expect("a picture");
    let said = segment(&arm, &[]).succeeded();
    assert!(
        said.err.contains(
            "cam_02.png: 1 picture of another size (10 × 10 px, expected 160 × 120 px): not used"
        ),
        "{}",
        said.err
    );
    fs::remove_dir_all(arm.recording().join("images")).expect("removed");
    segment(&arm, &["--overwrite"]).refused(&["no pictures: expected videos/<camera>.*"]);
    arm.fit("out", &[]).refused(&["no masks and no pictures"]);
}

#[test]
fn without_ffmpeg_a_video_says_how_to_install_it() {
    let arm = photographed();
    fs::create_dir_all(arm.recording().join("videos")).expect("a folder");
    fs::write(arm.recording().join("videos/cam_01.mp4"), "a video").expect("written");
    let said = Command::new(program())
        .args(["segment", &arm.recording().display().to_string(), "--out", "nowhere"])
        .env("PATH", "")
        .output()
        .expect("the program starts");
    let line = String::from_utf8(said.stderr).expect("UTF-8");
    assert_eq!(line.lines().count(), 1, "{line}");
    assert!(line.contains("cam_01.mp4") && line.contains("apt install ffmpeg"), "{line}");
}
