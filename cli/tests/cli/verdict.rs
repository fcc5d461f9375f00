//! A fit that cannot be used says so, and why, wherever it is read.

use std::fs;
use std::path::Path;

use assert_cmd::Command;
use maquette::{FittedRecording, Side};
use serde_json::Value;

fn maquette(arguments: &[&str]) -> (Option<i32>, String) {
    let ran = Command::cargo_bin("maquette").expect("the program").args(arguments).output();
    let ran = ran.expect("a run");
    (ran.status.code(), String::from_utf8_lossy(&ran.stderr).into_owned())
}

fn text(path: &Path) -> &str {
    path.to_str().expect("UTF-8")
}

#[test]
fn two_exchanged_cameras_are_named_and_no_certainty_is_stated() {
    let folder = tempfile::tempdir().expect("a folder");
    let (recording, out) = (folder.path().join("recording"), folder.path().join("out"));
    let made = ["synth", text(&recording), "--frames", "12", "--cameras", "5", "--quiet"];
    assert_eq!(maquette(&made).0, Some(0));
    let masks = |name: &str| recording.join("masks").join(name);
    fs::rename(masks("cam_01"), masks("other")).expect("renamed");
    fs::rename(masks("cam_03"), masks("cam_01")).expect("renamed");
    fs::rename(masks("other"), masks("cam_03")).expect("renamed");

    // the fit
    let (code, said) = maquette(&["fit", text(&recording), "--out", text(&out), "--quiet"]);
    assert_eq!(code, Some(3), "{said}");
    assert!(
        said.contains("not usable") && said.contains("cam_01 and cam_03 are exchanged"),
        "{said}"
    );

    let result = fs::read_to_string(out.join("result.json")).expect("a result");
    let result: Value = serde_json::from_str(&result).expect("JSON");
    assert_eq!(result["verdict"]["causes"][0]["cause"], "exchanged");
    let lengths = result["shape"]["lengths"].as_array().expect("lengths");
    assert!(lengths.iter().all(|l| l["sd_m"].is_null() && l["confidence"]["p_within"].is_null()));
    let frames = result["motion"]["frames"].as_array().expect("frames");
    assert!(frames.iter().all(|frame| frame["sd"].is_null()));

    // who asks for a number gets the verdict
    let fit = FittedRecording::read(&out, None).expect("a fit");
    let length = fit.length("thigh").map(|_| ());
    let angle = fit.angle("knee_flexion", Side::Left).map(|_| ());
    for refused in [length, angle] {
        let said = refused.expect_err("no number").to_string();
        assert!(said.contains("not usable") && said.contains("cam_01 and cam_03"), "{said}");
    }

    // what is made of it
    let (code, said) = maquette(&["report", text(&out), "--quiet"]);
    assert_eq!(code, Some(3), "{said}");
    let report = fs::read_to_string(out.join("report.html")).expect("a report");
    assert!(report.matches("class=\"verdict\"").count() > 5);

    let (code, said) = maquette(&["gait", text(&out), "--quiet"]);
    assert_eq!(code, Some(3), "{said}");
    let gait = fs::read_to_string(out.join("gait/gait.json")).expect("a gait");
    let gait: Value = serde_json::from_str(&gait).expect("JSON");
    assert_eq!(gait["curves"].as_array().map(Vec::len), Some(0));
    assert_eq!(gait["parameters"].as_array().map(Vec::len), Some(0));
    assert!(gait["notes"][0].as_str().is_some_and(|note| note.starts_with("not usable")));
}

#[test]
fn a_height_that_is_given_tests_the_size_of_the_world_and_changes_nothing_of_the_fit() {
    let folder = tempfile::tempdir().expect("a folder");
    let recording = folder.path().join("recording");
    let made = ["synth", text(&recording), "--frames", "6", "--cameras", "4", "--quiet"];
    assert_eq!(maquette(&made).0, Some(0));
    let fitted = |name: &str, more: &[&str]| {
        let out = folder.path().join(name);
        let fit = ["fit", text(&recording), "--out", text(&out), "--quiet"];
        let (code, said) = maquette(&[&fit[..], more].concat());
        assert_eq!(code, Some(0), "{said}");
        let result = fs::read_to_string(out.join("result.json")).expect("a result");
        serde_json::from_str::<Value>(&result).expect("JSON")
    };
    let plain = fitted("plain", &[]);
    assert_eq!(plain["verdict"]["causes"].as_array().map(Vec::len), Some(0));

    // in the manifest, and over it on the command line
    let manifest = recording.join("sequence.toml");
    let written = fs::read_to_string(&manifest).expect("a manifest");
    fs::write(&manifest, format!("height_m = 2.4\n{written}")).expect("written");
    let small = fitted("small", &[]);
    assert_eq!(small["verdict"]["causes"][0]["cause"], "height");
    let found_m = &small["verdict"]["causes"][0]["found_m"];
    let right = fitted("right", &["--height", &found_m.to_string()]);
    assert_eq!(right["verdict"]["causes"].as_array().map(Vec::len), Some(0));

    for part in ["shape", "motion"] {
        assert!(small[part] == plain[part] && right[part] == plain[part], "{part}");
    }
}

#[test]
fn the_chart_of_the_overlap_has_gaps_where_nobody_was_seen_and_where_frames_are_missing() {
    let folder = tempfile::tempdir().expect("a folder");
    let (recording, out) = (folder.path().join("recording"), folder.path().join("out"));
    let made = ["synth", text(&recording), "--frames", "14", "--cameras", "3", "--quiet"];
    assert_eq!(maquette(&made).0, Some(0));
    for camera in ["cam_01", "cam_02", "cam_03"] {
        let mask = |frame: usize| recording.join(format!("masks/{camera}/{frame:06}.png"));
        let size = image::image_dimensions(mask(0)).expect("a mask");
        for nobody in [5, 6] {
            image::GrayImage::new(size.0, size.1).save(mask(nobody)).expect("written");
        }
        fs::remove_file(mask(10)).expect("removed");
    }

    let quick = ["--likelihood", "ellipses", "--joint", "off", "--quiet"];
    let fit = ["fit", text(&recording), "--out", text(&out), "--body", "human-ellipsoids"];
    assert_eq!(maquette(&[&fit[..], &quick].concat()).0, Some(0));
    assert_eq!(maquette(&["report", text(&out), "--no-pictures", "--quiet"]).0, Some(0));

    // frames 0–4, 7–9 and 11–13, a line and a band each
    let report = fs::read_to_string(out.join("report.html")).expect("a report");
    let chart = report.split("Overlap of body and outlines").nth(1).expect("a chart");
    let chart = chart.split("</svg>").next().expect("its end");
    assert_eq!(chart.matches("stroke=\"#333333\" stroke-width=\"1.5\"").count(), 3);
    assert_eq!(chart.matches("fill=\"#333333\" fill-opacity=\"0.2\"").count(), 3);
}
