//! Recordings of a fitted body by the fit's own cameras.

use std::fs;

use serde_json::Value;

use crate::arm::{Arm, FRAMES, run};
use crate::skin::soft_arm;

#[test]
fn a_simulated_fit_has_the_fits_frames_cameras_and_lengths() {
    let arm = Arm::new();
    let body = soft_arm(&arm);
    arm.fit_with_body("out", &body, &[]).succeeded();
    let [fit, again] = ["out", "again"].map(|name| arm.out(name).display().to_string());
    let said = run(&["simulate", &fit, "--body", &body, "--out", &again, "--json"]).succeeded();
    let printed = crate::schema::check("simulate", &said.out);
    assert_eq!(printed["frames"].as_u64(), Some(FRAMES as u64));

    let fitted = arm.result("out");
    let truth: Value = serde_json::from_slice(&arm.bytes("again", "truth.json")).expect("JSON");
    for length in fitted["shape"]["lengths"].as_array().expect("a list") {
        let name = length["name"].as_str().expect("a name");
        let metres = |value: &Value| value.as_f64().expect("a number");
        let apart = metres(&truth["lengths_m"][name]) - metres(&length["length_m"]);
        assert!(apart.abs() < 1e-6, "{name}: {apart}");
    }
    let masks = |camera: &str| fs::read_dir(arm.out("again").join("masks").join(camera));
    for camera in fitted["recording"]["cameras"].as_array().expect("a list") {
        let camera = camera.as_str().expect("a name");
        assert_eq!(masks(camera).expect("a folder").count(), FRAMES, "{camera}");
    }
    run(&["simulate", &fit, "--body", &body, "--out", &again]).refused(&["not empty"]);
}

#[test]
fn a_fit_whose_recording_is_gone_or_whose_body_has_no_skin_is_not_simulated() {
    let arm = Arm::new();
    arm.fit("out", &[]).succeeded();
    let [fit, again] = ["out", "again"].map(|name| arm.out(name).display().to_string());
    run(&["simulate", &fit, "--out", &again]).refused(&["metaball"]);
    fs::remove_file(arm.out("out").join("recording.toml")).expect("a file");
    run(&["simulate", &fit, "--out", &again]).refused(&["recording.toml names no recording"]);
    assert!(!arm.out("again").exists());
}
