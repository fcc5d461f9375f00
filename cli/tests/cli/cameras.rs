//! `maquette calibrate` and `maquette sync`: what they write, say and refuse.

use std::fs;
use std::path::{Path, PathBuf};

use maquette::camera::Rig;
use maquette::io::calibration::{self, CalibrationOptions};
use maquette::io::folder::OutFolder;
use maquette::io::result::ResultFile;
use maquette::pipeline::{CameraFound, ClockFound, POSE, PoseFound};
use serde_json::Value;

use crate::arm::{Arm, Ran, rig, run};
use crate::schema::check;

/// The folder of a fit of the arm, changed as if its cameras had been unknowns.
pub(crate) fn fitted(arm: &Arm, out: &str, change: impl FnOnce(&mut ResultFile)) -> PathBuf {
    arm.fit(out, &["--quiet"]).succeeded();
    let folder = arm.out(out);
    let mut result = ResultFile::read(&folder).expect("a result");
    for (i, camera) in result.quality.cameras.iter_mut().enumerate() {
        camera.found.pose = (i < 2).then_some(PoseFound {
            turn_deg: [1.0, 0.0, -0.2],
            turn_sd_deg: Some([0.05; 3]),
            displacement_m: [0.0, 0.02, 0.001],
            displacement_sd_m: Some([0.002; 3]),
            zoom: 0.98,
            zoom_sd: Some(0.00098),
            used: true,
        });
        let ahead_s = 0.1 * (i as f64 * 2.3 - 1.7);
        camera.found.clock = (i < 2).then_some(ClockFound { ahead_s, sd_s: Some(0.004) });
    }
    // no camera's numbers hang on another's
    let variance = |k: usize| match k % POSE {
        0..3 => 0.05_f64.to_radians().powi(2),
        3..6 => 4e-6,
        _ => 1e-6,
    };
    let all = 2 * POSE;
    let row = |i: usize| (0..all).map(|j| if i == j { variance(i) } else { 0.0 }).collect();
    result.quality.poses_covariance = Some((0..all).map(row).collect());
    result.quality.clocks_covariance = Some(vec![vec![16e-6, 8e-6], vec![8e-6, 16e-6]]);
    change(&mut result);
    let opened = OutFolder::open(&folder).expect("a folder");
    for (name, bytes) in result.files().expect("a result") {
        opened.write(name, &bytes).expect("written");
    }
    folder
}

/// Nothing was found of any camera.
fn forget(result: &mut ResultFile) {
    let quality = &mut result.quality;
    (quality.poses_covariance, quality.clocks_covariance) = (None, None);
    quality.cameras.iter_mut().for_each(|camera| camera.found = CameraFound::default());
}

pub(crate) fn on(verb: &str, paths: &[&Path], more: &[&str]) -> Ran {
    let paths: Vec<String> = paths.iter().map(|path| path.display().to_string()).collect();
    let mut arguments = vec![verb.to_owned()];
    arguments.extend(paths.into_iter().chain(more.iter().map(ToString::to_string)));
    run(&arguments)
}

fn calibrate(paths: &[&Path], out: &Path, more: &[&str]) -> Ran {
    let out = out.display().to_string();
    on("calibrate", paths, &[&["--out", &out], more].concat())
}

/// The largest difference of two rigs' centres, m.
fn apart_m(a: &Rig, b: &Rig) -> f64 {
    let pairs = a.cameras.iter().map(|a| (a, b.by_name(&a.name).expect("the same cameras").1));
    pairs.map(|(a, b)| (a.centre_world() - b.centre_world()).norm()).fold(0.0, f64::max)
}

#[test]
fn a_refined_calibration_is_written_in_every_format_and_says_what_it_is() {
    let arm = Arm::new();
    let fit = fitted(&arm, "out", |_| {});
    let read = |path: &Path| calibration::read(path, &CalibrationOptions::default()).unwrap();
    let toml = arm.out("rig.toml");
    let printed = calibrate(&[&fit], &toml, &["--json", "--quiet"]).succeeded();
    let said = check("calibrate", &printed.out);

    // the first two are where they were found, the third where it was
    let refined = read(&toml);
    for (camera, before) in refined.cameras.iter().zip(&rig().cameras) {
        let way = camera.centre_world() - before.centre_world();
        let moved = if camera.name == "cam_03" { [0.0; 3] } else { [0.0, 0.02, 0.001] };
        assert!((way - nalgebra::Vector3::from(moved)).norm() < 1e-9, "{way}");
        let turned = camera.camera_from_world.rotation.angle_to(&before.camera_from_world.rotation);
        let expected = if camera.name == "cam_03" { 0.0 } else { 1.04_f64.sqrt() };
        assert!((turned.to_degrees() - expected).abs() < 1e-6, "{turned}");
    }
    assert_eq!(
        said["cameras"][0]["displacement_sd_m"][1].as_f64().map(|sd| sd < 0.0021),
        Some(true)
    );
    assert_eq!(said["cameras"][2]["kept"], "no two others look across its line of sight");
    assert_eq!(said["recordings"][0]["cameras"], 2);
    let text = fs::read_to_string(&toml).unwrap();
    assert!(
        text.contains("[metadata.refined.cam_01]") && !text.contains("refined.cam_03"),
        "{text}"
    );

    // the other formats hold the same
    for name in ["intri.yml", "rig.yml", "rig.xml", "rig.qca.txt"] {
        let path = arm.out(name);
        calibrate(&[&fit], &path, &["--quiet"]).succeeded();
        assert!(apart_m(&read(&path), &refined) < 1e-9, "{name}");
    }
    assert!(arm.out("extri.yml").is_file());
    calibrate(&[&fit], &arm.out("{camera}.xml"), &["--quiet"]).succeeded();
    assert!(arm.out("cam_03.xml").is_file());

    // for a person
    let text = calibrate(&[&fit], &toml, &["--overwrite"]).succeeded().out;
    for part in [
        "cam_01",
        "20.0 ± ",
        "1.02 ± ",
        "of 7",
        "-2.00 ± 0.10 %",
        "cam_03 keeps its calibration: no two",
    ] {
        assert!(text.contains(part), "{part} not in {text}");
    }
}

#[test]
fn recordings_are_put_together_and_those_that_disagree_are_named() {
    let arm = Arm::new();
    let first = fitted(&arm, "first", |_| {});
    let second = fitted(&arm, "second", |_| {});
    let other = fitted(&arm, "other", |result| {
        let pose = result.quality.cameras[1].found.pose.as_mut().expect("it is there");
        pose.displacement_m[1] = -0.03;
    });
    let told = |paths: &[&Path]| -> Value {
        let out = arm.out("rig.toml");
        let printed = calibrate(paths, &out, &["--json", "--quiet", "--overwrite"]).succeeded();
        check("calibrate", &printed.out)
    };
    let sd = |said: &Value| said["cameras"][0]["displacement_sd_m"][1].as_f64().expect("a number");
    let (one, two) = (told(&[&first]), told(&[&first, &second]));
    // the same twice, and the prior once: less than √2 surer, and surer
    assert!(sd(&two) < 0.9 * sd(&one) && sd(&two) > sd(&one) / 2.0_f64.sqrt(), "{one} {two}");
    assert_eq!(two["notes"].as_array().map(Vec::len), Some(0));
    let note = told(&[&first, &second, &other])["notes"].to_string();
    assert!(note.contains("something else of cam_02") && !note.contains("cam_01"), "{note}");
}

#[test]
fn what_a_recording_does_not_determine_is_refused_in_one_line() {
    let arm = Arm::new();
    let (fit, toml) = (fitted(&arm, "out", |_| {}), arm.out("rig.toml"));

    // names and files
    calibrate(&[&fit], &arm.out("rig.xcp"), &[]).refused(&["rig.xcp: expected *.toml, intri.yml"]);
    calibrate(&[&fit], &arm.out("none/rig.toml"), &[]).refused(&["none: no such folder"]);
    fs::write(&toml, "mine").unwrap();
    calibrate(&[&fit], &toml, &[]).refused(&["rig.toml: this file stands already", "--overwrite"]);
    assert_eq!(fs::read_to_string(&toml).unwrap(), "mine");
    let out = arm.out("a.toml");
    calibrate(&[&arm.out("nobody")], &out, &[]).refused(&["nobody: no such folder or file"]);

    // what nothing tells
    let held = fitted(&arm, "held", |result| {
        forget(result);
    });
    let why = "no camera's place can be told: no camera has two others";
    calibrate(&[&held], &out, &[]).refused(&["held: ", why]);
    let trusted = fitted(&arm, "trusted", |result| {
        result.quality.poses_covariance = None;
        result.options.estimate.cameras = maquette::pipeline::Cameras::Trust;
    });
    calibrate(&[&trusted], &out, &[]).refused(&["trusted: ", "fitted with --cameras trust"]);
    let blind = fitted(&arm, "blind", |result| {
        result.quality.cameras.iter_mut().for_each(|camera| camera.frames = 0);
    });
    calibrate(&[&blind], &out, &[]).refused(&["the motion determines no camera's place"]);
    let recording = arm.recording();
    let ran = calibrate(&[&recording], &out, &["--fps", "10", "--body", "arm-2d"]);
    ran.refused(&["recording: no camera's place can be told", "or the body is held"]);

    // two calibrations
    let mut other = rig();
    other.cameras[1].camera_from_world.translation.vector.x += 0.01;
    arm.write("calibration.toml", &calibration::write_toml(&other));
    let second = fitted(&arm, "second", |_| {});
    let first_again = Arm::new();
    let first = fitted(&first_again, "first", |_| {});
    calibrate(&[&first, &second], &out, &[])
        .refused(&["camera cam_02: ", "different calibrations"]);
    assert!(!out.exists());
}

#[test]
fn cameras_without_places_need_one_recording_with_detections_and_nothing_else_takes_a_size() {
    let arm = Arm::new();
    let (recording, out) = (arm.recording(), arm.out("rig.toml"));
    let lenses = ["--from", "lenses"];
    let ran = calibrate(&[&recording], &out, &[&lenses[..], &["--fps", "10"]].concat());
    ran.refused(&["recording: ", "placed by detections of joints, and there are none"]);
    let ran = calibrate(&[&recording, &recording], &out, &lenses);
    ran.refused(&["--from lenses: expected one recording"]);
    let ran = calibrate(&[&recording], &out, &["--height", "1.7"]);
    ran.refused(&["--height and --distance are for --from lenses"]);
    let distance = ["--distance", "cam_01", "cam_02", "far"];
    let ran = calibrate(&[&recording], &out, &[&lenses[..], &distance].concat());
    ran.refused(&["--distance: expected metres, found \"far\""]);
    assert!(!out.exists());
}

#[test]
fn a_camera_that_sees_nobody_keeps_its_calibration_and_its_clock() {
    let arm = Arm::new();
    let fit = fitted(&arm, "out", |result| {
        let cameras = &mut result.quality.cameras;
        cameras[1].frames = 0;
        cameras[2].found.clock = Some(ClockFound { ahead_s: 0.03, sd_s: Some(0.004) });
        let row = |i: usize| (0..3).map(|j| if i == j { 16e-6 } else { 8e-6 }).collect();
        result.quality.clocks_covariance = Some((0..3).map(row).collect());
    });
    let printed = calibrate(&[&fit], &arm.out("rig.toml"), &["--json", "--quiet"]).succeeded();
    assert_eq!(check("calibrate", &printed.out)["cameras"][1]["kept"], "it sees nobody");
    let printed = on("sync", &[&fit], &["--json", "--quiet"]).succeeded();
    let said = check("sync", &printed.out);
    assert_eq!(said["cameras"][1]["kept"], "it sees nobody");
    assert!((said["cameras"][2]["offset_frames"].as_f64().unwrap() - 2.0).abs() < 1e-9, "{said}");
}

#[test]
fn offsets_are_written_where_the_next_fit_reads_them() {
    let arm = Arm::new();
    let fit = fitted(&arm, "out", |_| {});
    let said = check("sync", &on("sync", &[&fit], &["--json", "--quiet"]).succeeded().out);
    let offset = |said: &Value, i: usize| said["cameras"][i]["offset_frames"].as_f64();
    // the first camera's clock is the recording's
    assert_eq!((said["reference"].as_str(), offset(&said, 0)), (Some("cam_01"), Some(0.0)));
    assert!((offset(&said, 1).unwrap() - 2.3).abs() < 1e-9, "{said}");
    assert_eq!(said["cameras"][2]["kept"], "no other camera looks across its line of sight");
    assert!((said["cameras"][1]["sd_ms"].as_f64().unwrap() - 4.0).abs() < 1e-9);
    assert!(said["no_drift"].as_str().is_some_and(|why| why.contains("too short to tell drift")));

    // whole frames shift the files, and the rest is where the clock starts
    let text = fs::read_to_string(arm.recording().join("offsets.toml")).unwrap();
    assert!(text.contains("name = \"cam_02\"\noffset_frames = 2.3\nsd_frames = 0.04"), "{text}");
    assert!(text.contains("name = \"cam_03\"\noffset_frames = 0.0\n"), "{text}");
    arm.fit("again", &["--quiet"]).succeeded();
    let result = ResultFile::read(&arm.out("again")).unwrap();
    assert_eq!(result.recording.offset_frames, [0.0, 2.3, 0.0]);
    let ahead = &result.options.estimate.ahead_frames;
    assert!(ahead.len() == 1 && (ahead["cam_02"] - 0.3).abs() < 1e-9, "{ahead:?}");
    assert!(result.inputs.iter().any(|input| input.input == "offsets.toml"));
    let late = result.quality.views.iter().filter(|view| view.camera == "cam_02");
    let first = late.map(|view| view.frame.0).min();
    assert_eq!(first, Some(2), "its first picture is of the third moment");

    // a fit with offsets has what it found on top of them
    let again = fitted(&arm, "more", |_| {});
    on("sync", &[&again], &[]).refused(&["offsets.toml: this file stands already", "--overwrite"]);
    let ran = on("sync", &[&again], &["--overwrite"]).succeeded();
    for part in [
        "+4.30 ± 0.04",
        "+430.0 ± 4.0",
        "+2.30",
        "against cam_01",
        "cam_03 keeps its offset",
        "too short",
    ] {
        assert!(ran.out.contains(part), "{part} not in {}", ran.out);
    }
}

#[test]
fn clocks_that_nothing_tells_are_refused_in_one_line() {
    let arm = Arm::new();
    let recording = arm.recording();
    let body = ["--fps", "10", "--body", "arm-2d"];
    let ran = on("sync", &[&recording], &body);
    ran.refused(&["recording: no camera's clock can be told", "or the body is held"]);
    let ran = on("sync", &[&recording], &[&body[..], &["--windows", "2"]].concat());
    ran.refused(&["6 frames: expected 200 or more for 2 windows of 100 frames"]);
    let trusted = fitted(&arm, "trusted", |result| {
        forget(result);
        result.options.estimate.clocks = maquette::pipeline::Clocks::Trust;
    });
    on("sync", &[&trusted], &[]).refused(&["trusted: ", "fitted with --clocks trust"]);
    fs::remove_file(trusted.join("recording.toml")).unwrap();
    on("sync", &[&trusted], &[]).refused(&["recording.toml names no recording"]);
    assert!(!recording.join("offsets.toml").exists());
}

#[test]
fn offsets_that_do_not_fit_the_recording_are_told() {
    let arm = Arm::new();
    let camera = |offset: &str| {
        format!("fps = 10.0\n[[camera]]\nname = \"cam_02\"\noffset_frames = {offset}\n")
    };
    arm.write("offsets.toml", &camera("50"));
    let ran = arm.fit("late", &["--quiet"]);
    assert_eq!(ran.code, Some(0), "{ran:?}");
    let line = "camera cam_02: none of its frames (50 to 55) is one of the other cameras' (0 to 5)";
    assert!(ran.err.contains(line), "{}", ran.err);
    arm.write("offsets.toml", &camera("-50"));
    let ran = arm.fit("early", &["--quiet"]);
    assert!(
        ran.err.contains("camera cam_02: offset_frames puts 6 masks before frame 0"),
        "{}",
        ran.err
    );
    arm.write("offsets.toml", &camera("1e9"));
    arm.fit("far", &[]).refused(&["frame"]);
    arm.write("offsets.toml", &camera("nan"));
    arm.fit("nan", &[]).refused(&["offsets.toml: camera cam_02: offset_frames = NaN"]);
    arm.write("offsets.toml", &camera("1").replace("10.0", "25.0"));
    arm.fit("rate", &[]).refused(&["offsets.toml: found at 25 frames per second", "read at 10"]);
}
