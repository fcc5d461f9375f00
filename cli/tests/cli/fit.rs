//! A recording from end to end.

use std::path::Path;

use image::{GrayImage, Luma};
use maquette::body::{BodyModel, Motion, Posed, Shape};
use maquette::io::model;
use maquette::io::points::trc::{Trajectories, read_trc};
use maquette::io::points::write_ply;
use maquette::io::result::ResultFile;
use maquette::skin::{SkinOptions, skin};
use maquette::stereo::{CloudPoint, Spread};
use nalgebra::Vector3;

use crate::arm::{Arm, FRAMES, SHAPE, SIZE, points, rig};

fn joints(arm: &Arm, out: &str) -> Trajectories {
    let text = String::from_utf8(arm.bytes(out, "joints.trc")).expect("UTF-8");
    read_trc(&text, Path::new("joints.trc")).expect("a TRC file")
}

#[test]
fn a_recording_is_fitted_from_end_to_end() {
    let arm = Arm::new();
    let said = arm.fit("out", &["--overlays"]).succeeded();
    assert_eq!(said.err, "", "no terminal, no progress");
    for part in [
        "arm-2d fitted to 6 frames of 3 cameras at 10 Hz",
        "upper",
        "cam_03",
        "▸",
        "± SD",
        "SD: standard deviation of the true length",
    ] {
        assert!(said.out.contains(part), "{part} not in {}", said.out);
    }
    assert!(!said.out.contains("p within"), "a probability beside a length: {}", said.out);
    // the shape, from lengths in metres
    let result = arm.result("out");
    let upper = result["shape"]["lengths"][0]["length_m"].as_f64().expect("a length");
    let truth = 2.0 / (1.0 + (-SHAPE).exp());
    assert!((upper - truth).abs() < 0.02, "{upper} {truth}");
    // the motion, as points
    let joints = joints(&arm, "out");
    assert_eq!(joints.names, ["Elbow", "Tip", "Shoulder"]);
    assert_eq!(joints.frames.len(), FRAMES);
    for (frame, found) in joints.frames.iter().enumerate() {
        for (found, truth) in found.iter().zip(points(frame)) {
            let error = (found.expect("a point") - truth).norm();
            assert!(error < 0.03, "frame {frame}: {error} m");
        }
    }
    // how sure, of every length, coefficient and frame
    assert!(result["shape"]["lengths"][0]["sd_m"].as_f64().is_some_and(|sd| sd > 0.0));
    assert!(
        result["shape"]["noise"]["outlines"]["together"].as_f64().is_some_and(|tau| tau >= 1.0)
    );
    for frame in result["motion"]["frames"].as_array().expect("frames") {
        let sd = frame["sd"]["angles_rad"][0].as_f64();
        assert!(sd.is_some_and(|sd| sd > 0.0 && sd < 0.2), "{frame}");
    }
    // a picture for each mask
    let picture = image::load_from_memory(&arm.bytes("out", "overlays/cam_02/000003.png"));
    let picture = picture.expect("a picture");
    assert_eq!((picture.width(), picture.height()), SIZE);
    let has_ffmpeg = std::process::Command::new("ffmpeg").arg("-version").output().is_ok();
    assert_eq!(arm.out("out/overlays/cam_02.mp4").is_file(), has_ffmpeg, "a film of the pictures");
}

#[test]
fn the_result_says_what_it_is_made_of() {
    let arm = Arm::new();
    arm.fit("out", &["--quiet"]).succeeded();
    let text = String::from_utf8(arm.bytes("out", "result.json")).expect("UTF-8");
    assert!(!text.contains(&arm.recording().display().to_string()), "a path of this machine");
    let result: ResultFile = serde_json::from_str(&text).expect("the documented fields");
    assert_eq!((result.format.as_str(), result.version), ("maquette-result", 6));
    assert_eq!(result.recording.cameras, ["cam_01", "cam_02", "cam_03"]);
    assert_eq!(result.options.estimate.search.keyframe_every, Some(2));
    let inputs: Vec<&str> = result.inputs.iter().map(|i| i.input.as_str()).collect();
    let expected = [
        "calibration.toml",
        "masks of cam_01",
        "masks of cam_02",
        "masks of cam_03",
        "body arm-2d",
    ];
    assert_eq!(inputs, expected);
    assert_eq!(result.quality.views.len(), 3 * FRAMES);
    for camera in &result.quality.cameras {
        assert!(camera.mean_iou > 0.9, "{camera:?}");
        assert!(camera.median_px.is_some_and(|px| px < 0.4), "{camera:?}");
    }
    for hypothesis in &result.hypotheses {
        let sum = hypothesis.minus_log_posterior;
        let parts = sum.shape + sum.data + sum.pose + sum.step;
        approx::assert_relative_eq!(sum.total, parts, max_relative = 1e-9);
    }
    let winner = &result.hypotheses[result.winner];
    let finished = result.hypotheses.iter().filter(|h| h.frames_fitted == FRAMES);
    let least = finished.map(|h| h.minus_log_posterior.total).fold(f64::INFINITY, f64::min);
    approx::assert_relative_eq!(winner.minus_log_posterior.total, least);
    assert_eq!(result.shape.all_lengths.keyframes, 3);
}

/// Every key of the objects in a value, but of `options`, which the code describes.
fn keys(value: &serde_json::Value, found: &mut std::collections::BTreeSet<String>) {
    match value {
        serde_json::Value::Object(object) => {
            for (key, inner) in object {
                found.insert(key.clone());
                if key != "options" {
                    keys(inner, found);
                }
            }
        }
        serde_json::Value::Array(items) => items.iter().for_each(|item| keys(item, found)),
        _ => {}
    }
}

#[test]
fn every_field_of_the_result_stands_in_the_description_of_formats() {
    let arm = Arm::new();
    arm.fit("out", &["--quiet"]).succeeded();
    let mut found = std::collections::BTreeSet::new();
    keys(&arm.result("out"), &mut found);
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/formats.md");
    let formats = std::fs::read_to_string(path).expect("part of the repository");
    let section = formats.split("## `result.json`").nth(1).expect("a section");
    let words: Vec<&str> = section.split(|c: char| !(c.is_alphanumeric() || c == '_')).collect();
    let missing: Vec<&String> = found.iter().filter(|k| !words.contains(&k.as_str())).collect();
    assert!(found.len() > 60 && missing.is_empty(), "{missing:?}");
}

#[test]
fn the_bytes_do_not_depend_on_the_number_of_threads() {
    let arm = Arm::new();
    for threads in ["1", "2", "8"] {
        arm.fit(threads, &["--threads", threads, "--quiet"]).succeeded();
    }
    for name in ["result.json", "joints.trc"] {
        assert_eq!(arm.bytes("1", name), arm.bytes("2", name), "{name}");
        assert_eq!(arm.bytes("1", name), arm.bytes("8", name), "{name}");
    }
}

#[test]
fn without_pruning_the_same_hypothesis_wins_with_the_same_posterior() {
    let arm = Arm::new();
    arm.fit("pruned", &["--quiet"]).succeeded();
    arm.fit("all", &["--quiet", "--no-pruning"]).succeeded();
    let (pruned, all) = (arm.result("pruned"), arm.result("all"));
    assert_eq!(pruned["winner"], all["winner"]);
    assert_eq!(pruned["motion"], all["motion"]);
    let outcomes = all["hypotheses"].as_array().expect("hypotheses").iter();
    assert!(outcomes.clone().all(|h| h["outcome"] != "pruned"));
}

#[test]
fn quiet_says_warnings_alone_and_json_says_the_summary() {
    let arm = Arm::new();
    let said = arm.fit("quiet", &["--quiet"]).succeeded();
    assert_eq!(said.out, "");
    assert!(said.err.lines().all(|line| line.starts_with("warning: ")), "{}", said.err);
    assert_eq!(
        said.err.lines().count(),
        arm.result("quiet")["warnings"].as_array().map_or(0, Vec::len)
    );
    let said = arm.fit("json", &["--json"]).succeeded();
    let summary: serde_json::Value = serde_json::from_str(&said.out).expect("JSON");
    assert_eq!(summary["frames"], FRAMES);
    assert_eq!(summary["cameras"][2]["camera"], "cam_03");
    assert_eq!(summary["lengths"], arm.result("json")["shape"]["lengths"]);
}

#[test]
fn the_published_likelihood_is_another_one() {
    let arm = Arm::new();
    arm.fit("outline", &["--quiet"]).succeeded();
    arm.fit("published", &["--quiet", "--likelihood", "published"]).succeeded();
    let (outline, published) = (arm.result("outline"), arm.result("published"));
    let ellipses = &published["options"]["estimate"]["likelihood"]["ellipses"];
    assert_eq!(ellipses["variant"], "published");
    assert_ne!(outline["motion"], published["motion"]);
}

#[test]
fn without_the_joint_optimum_there_is_no_standard_deviation() {
    let arm = Arm::new();
    let said = arm.fit("out", &["--joint", "off"]).succeeded().out;
    assert!(!said.contains("± SD"), "{said}");
    let result = arm.result("out");
    assert!(result["options"]["estimate"]["joint"].is_null() && result["shape"]["noise"].is_null());
    assert!(result["shape"]["lengths"][0]["sd_m"].is_null());
    assert!(result["motion"]["frames"][0]["sd"].is_null());
}

#[test]
fn some_frames_may_be_chosen() {
    let arm = Arm::new();
    arm.fit("some", &["--quiet", "--frames", "2:4"]).succeeded();
    let result = arm.result("some");
    let recording = &result["recording"];
    assert_eq!((&recording["first_frame"], &recording["last_frame"]), (&2.into(), &4.into()));
    approx::assert_relative_eq!(result["motion"]["frames"][0]["time_s"].as_f64().expect("s"), 0.2);
    let joints = joints(&arm, "some");
    assert_eq!((joints.first_frame, joints.frames.len()), (2, 3));
}

#[test]
fn what_was_missing_is_said() {
    let arm = Arm::new();
    let empty = GrayImage::from_pixel(SIZE.0, SIZE.1, Luma([0]));
    // frame 3: nobody in any mask; frame 4: one camera sees the arm; frame 5: no mask of one camera
    for camera in ["cam_01", "cam_02", "cam_03"] {
        arm.write_mask(camera, 3, &empty);
    }
    for camera in ["cam_01", "cam_02"] {
        arm.write_mask(camera, 4, &empty);
    }
    std::fs::remove_file(arm.mask_path("cam_02", 5)).expect("removed");
    let said = arm.fit("out", &[]).succeeded().out;
    for part in [
        "no camera sees the person in 1 frame (3)",
        "only one camera sees the person in 1 frame (4)",
        "cam_01 shows nobody in 2 frames (3, 4): the mask is empty",
    ] {
        assert!(said.contains(part), "{part} not in {said}");
    }
    let result = arm.result("out");
    assert_eq!(result["recording"]["missing"][0]["camera"], "cam_02");
    assert_eq!(result["recording"]["missing"][0]["frames"][0], 5);
    assert_eq!(result["recording"]["rejected"].as_array().map(Vec::len), Some(5));
    let views = |frame: usize| result["motion"]["frames"][frame]["views"].as_u64();
    assert_eq!([2, 3, 4, 5].map(views), [Some(3), Some(0), Some(1), Some(2)]);
    let joints = joints(&arm, "out");
    assert!(joints.frames[3].iter().all(Option::is_none));
    assert!(joints.frames[4].iter().all(Option::is_some));
}

#[test]
fn a_gap_in_the_frame_numbers_is_a_gap_in_time() {
    let arm = Arm::new();
    for camera in &rig().cameras {
        std::fs::remove_file(arm.mask_path(&camera.name, 2)).expect("removed");
    }
    arm.fit("out", &["--quiet"]).succeeded();
    let joints = joints(&arm, "out");
    assert_eq!(joints.frames.len(), FRAMES);
    assert!(joints.frames[2].iter().all(Option::is_none));
    assert_eq!(arm.result("out")["recording"]["frames"], FRAMES - 1);
}

#[test]
fn a_camera_that_looks_elsewhere_than_the_masks_say_is_told() {
    let arm = Arm::new();
    // the masks of one camera are moved by half of the picture
    let camera = &rig().cameras[1];
    for frame in 0..FRAMES {
        let mask = crate::arm::mask(camera, frame);
        let moved = GrayImage::from_fn(SIZE.0, SIZE.1, |x, y| {
            let from = (x + SIZE.0 / 2, y + SIZE.1 / 2);
            let value = mask.get_pixel_checked(from.0, from.1);
            value.copied().unwrap_or(Luma([0]))
        });
        arm.write_mask(&camera.name, frame, &moved);
    }
    let said = arm.fit("out", &[]).succeeded().out;
    let part = "cam_02 sees the person in another place than the other cameras do";
    assert!(said.contains(part), "{said}");
    assert!(!said.contains("is this the right body"), "{said}");
}

/// Points on the bone of the upper part, which all silhouettes show, moved by this.
fn write_points(arm: &Arm, by_m: Vector3<f64>) {
    for frame in 0..FRAMES {
        let ends = points(frame);
        let cloud: Vec<CloudPoint> = (0..60)
            .map(|i| ends[2] + (ends[0] - ends[2]) * (0.1 + 0.8 * f64::from(i) / 60.0))
            .map(|point| CloudPoint {
                position_world: point + by_m,
                spread: Spread::Isotropic(0.002),
            })
            .collect();
        let path = arm.recording().join(format!("points/{frame:06}.ply"));
        std::fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
        std::fs::write(path, write_ply(&cloud)).expect("written");
    }
}

#[test]
fn points_that_disagree_with_the_silhouettes_are_told_with_their_frames() {
    let part = "points and silhouettes disagree";
    let arm = Arm::new();
    write_points(&arm, Vector3::zeros());
    let said = arm.fit("agree", &[]).succeeded().out;
    assert!(!said.contains(part), "{said}");
    write_points(&arm, Vector3::z() * 0.5);
    let said = arm.fit("disagree", &[]).succeeded().out;
    let told = "points and silhouettes disagree in 6 frames (0–5): 100 % of the points lie outside a silhouette, by 0.";
    assert!(said.contains(told), "{said}");
    let result = arm.result("disagree");
    let quality = &result["quality"]["points"][3];
    assert_eq!(quality["points"], 60);
    assert_eq!(quality["outside"], 1.0);
    assert!(quality["outside_m"].as_f64().is_some_and(|m| (0.1..0.5).contains(&m)), "{quality}");
}

/// How the arm of three metaballs a limb moves.
fn fleshy_motion(model: &BodyModel, frame: usize) -> Motion {
    let mut motion = Motion::rest(model);
    motion.angles[0] = 0.3 + 0.05 * frame as f64;
    // flexed, so that the turns of both limbs show
    let elbow = model.joints.iter().position(|j| j.name == "elbow_flexion");
    motion.angles[elbow.expect("an elbow")] = 0.8;
    motion
}

#[test]
fn an_arm_is_fitted_to_points_alone() {
    let arm = Arm::new();
    std::fs::remove_dir_all(arm.recording().join("masks")).expect("removed");
    let model = model::load("arm", Path::new("")).expect("a shipped model");
    let shape = Shape(model.statistics.mean.clone());
    for frame in 0..FRAMES {
        let motion = fleshy_motion(&model, frame);
        let body = Posed::new(&model, &shape, &motion);
        let mesh = skin(&body, &SkinOptions::default()).expect("a skin");
        let cloud: Vec<CloudPoint> = mesh
            .vertices
            .iter()
            .map(|vertex| CloudPoint {
                position_world: (*vertex).into(),
                spread: Spread::Isotropic(0.002),
            })
            .collect();
        let path = arm.recording().join(format!("points/{frame:06}.ply"));
        std::fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
        std::fs::write(path, write_ply(&cloud)).expect("written");
    }
    let said = arm.fit_with_body("out", "arm", &[]).succeeded().out;
    assert!(!said.contains("no camera sees"), "{said}");
    for (frame, found) in joints(&arm, "out").frames.iter().enumerate() {
        let truth = Posed::new(&model, &shape, &fleshy_motion(&model, frame)).points();
        assert_eq!(found.len(), truth.len());
        for found in found {
            let found = found.expect("a point");
            let off = truth.iter().map(|t| (t - found).norm());
            let off = off.fold(f64::INFINITY, f64::min);
            assert!(off < 0.01, "frame {frame}: {off} m");
        }
    }
    arm.fit_with_body("none", "arm-2d", &[]).refused(&["the body arm-2d has no metaballs"]);

    // the published residual is another one
    arm.fit_with_body("field", "arm", &["--quiet", "--residual", "field"]).succeeded();
    let (distance, field) = (arm.result("out"), arm.result("field"));
    let points = |result: &serde_json::Value| {
        result["options"]["estimate"]["likelihood"]["points"]["residual"].clone()
    };
    assert_eq!((points(&distance), points(&field)), ("distance".into(), "field".into()));
    assert_ne!(distance["motion"], field["motion"]);
}

#[test]
fn what_is_dropped_is_in_the_warnings_and_is_said_although_quiet() {
    let arm = Arm::new();
    for frame in [1, 2, 4] {
        std::fs::remove_file(arm.mask_path("cam_02", frame)).expect("removed");
    }
    let points = arm.recording().join("points");
    std::fs::create_dir(&points).expect("a folder");
    let cloud: Vec<String> =
        crate::arm::points(0).iter().map(|p| format!("{} {} {}", p.x, p.y, p.z)).collect();
    std::fs::write(points.join("000000.xyz"), cloud.join("\n")).expect("written");

    let said = arm.fit("out", &["--quiet"]).succeeded();
    let result = arm.result("out");
    let warnings: Vec<&str> = result["warnings"]
        .as_array()
        .expect("warnings")
        .iter()
        .filter_map(|w| w.as_str())
        .collect();
    for part in [
        "camera cam_02: 3 of 6 masks are missing (1, 2, 4)",
        "points: not fitted to: the body arm-2d is compared by its ellipsoids",
    ] {
        assert!(warnings.iter().any(|w| w.contains(part)), "{part} not in {warnings:?}");
        assert!(said.err.contains(part), "{part} not in {}", said.err);
    }
    assert_eq!(said.out, "");
}
