//! What `maquette silhouettes` refuses, in one line.

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
