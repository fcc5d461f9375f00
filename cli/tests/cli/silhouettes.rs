//! What `maquette silhouettes` prints, and what it refuses in one line.

use std::fs;

use crate::arm::{Arm, Ran, run};
use crate::segment::photographed;

fn silhouettes(arm: &Arm, more: &[&str]) -> Ran {
    let (recording, out) = (arm.recording(), arm.out("contours"));
    let (recording, out) = (recording.display().to_string(), out.display().to_string());
    let arguments = ["silhouettes", &recording, "--out", &out, "--fps", "10"];
    run(&[&arguments, more].concat())
}

#[test]
fn cameras_that_do_not_stand_side_by_side_need_a_fitted_body() {
    let arm = photographed();
    silhouettes(&arm, &[]).refused(&["--fit DIR"]);
    assert!(!arm.out("contours").join("quality.csv").exists());
    let nowhere = arm.out("nowhere").display().to_string();
    silhouettes(&arm, &["--fit", &nowhere]).refused(&["nowhere"]);
}

#[test]
fn a_body_without_metaballs_and_frames_that_are_not_there_are_refused() {
    let arm = photographed();
    silhouettes(&arm, &["--body", "arm-2d"]).refused(&["arm-2d", "metaballs"]);
    silhouettes(&arm, &["--frames", "70:80"]).refused(&["--frames 70:80", "it has 0 to 5"]);
}

#[test]
fn masks_alone_are_no_pictures() {
    silhouettes(&Arm::new(), &[]).refused(&["no pictures: expected videos/<camera>.*"]);
}

#[test]
fn a_fit_may_have_joint_contours_and_points_measured_within_them() {
    let arm = photographed();
    let (recording, out) = (arm.recording(), arm.out("fit"));
    let (recording, out) = (recording.display().to_string(), out.display().to_string());
    let arguments = ["fit", &recording, "--out", &out, "--fps", "10"];
    let both = ["--silhouettes", "joint", "--stereo"];
    // what is amiss is where the cameras stand, not that both were asked for
    run(&[&arguments[..], &both].concat()).refused(&["side by side"]);
}

#[test]
fn what_is_printed_as_json_is_described() {
    // photographs of a person before clutter, and a fit to the true masks
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name).display().to_string();
    run(&["synth", &path("photos"), "--clutter", "--frames", "1", "--quiet"]).succeeded();
    fs::create_dir(path("masked")).expect("a folder");
    fs::rename(path("photos/truth/masks"), path("masked/masks")).expect("the true masks");
    fs::copy(path("photos/calibration.toml"), path("masked/calibration.toml")).expect("a copy");
    let fit = ["fit", &path("masked"), "--out", &path("fit"), "--fps", "25", "--quiet"];
    let quick = ["--body", "human-metaballs", "--likelihood", "ellipses", "--joint", "off"];
    run(&[&fit[..], &quick].concat()).succeeded();

    let (photos, out, fit) = (path("photos"), path("out"), path("fit"));
    let arguments = ["silhouettes", &photos, "--out", &out, "--fit", &fit];
    let said = run(&[&arguments[..], &["--pipeline", "simple", "--json"]].concat()).succeeded();
    let printed = crate::schema::check("silhouettes", &said.out);
    assert_eq!(printed["cameras"].as_array().map(Vec::len), Some(3));
    assert!(printed["cameras"][0]["reliability"].is_number());
}
