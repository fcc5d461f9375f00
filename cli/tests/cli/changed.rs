//! Results that are not as `fit` wrote them.

use std::fs;
use std::path::Path;

use maquette::io::result::ResultFile;

use crate::arm::{Arm, run};

/// Every verb that reads a result, on one that somebody changed, says so.
fn refused(arm: &Arm, parts: &[&str]) {
    let out = arm.out("out").display().to_string();
    for verb in ["skin", "gait", "report", "export"] {
        run(&[verb, &out]).refused(parts);
    }
}

fn write(arm: &Arm, text: &str) {
    fs::write(arm.out("out").join("result.json"), text).expect("written");
}

#[test]
fn a_result_of_another_version_or_with_another_byte_is_refused() {
    let arm = Arm::new();
    arm.fit("out", &["--quiet"]).succeeded();
    let whole = String::from_utf8(arm.bytes("out", "result.json")).expect("UTF-8");
    for (from, to, parts) in [
        (
            "\"version\": 6",
            "\"version\": 3",
            &["version 3 of the format", "reads version 6: fit the"][..],
        ),
        (
            "\"version\": 6",
            "\"version\": 99",
            &["version 99 of the format", "use the newer program"],
        ),
        ("maquette-result", "other", &["expected the format \"maquette-result\", found \"other\""]),
        (
            "\"fps\": 10",
            "\"fps\": 50",
            &["result.json: changed since `maquette fit` wrote it", "--resume"],
        ),
    ] {
        assert!(whole.contains(from), "{from}");
        write(&arm, &whole.replacen(from, to, 1));
        refused(&arm, parts);
    }
    write(&arm, &whole[..whole.len() - 3]);
    refused(&arm, &["result.json:"]);

    // what it says to do helps
    arm.fit("out", &["--quiet", "--resume"]).succeeded();
    assert_eq!(arm.bytes("out", "result.json"), whole.as_bytes());
    ResultFile::read(&arm.out("out")).expect("whole");
}

#[test]
fn points_of_another_fit_are_found_and_points_that_were_removed_are_not_missed() {
    let arm = Arm::new();
    arm.fit("out", &["--quiet"]).succeeded();
    let joints = arm.out("out").join("joints.trc");
    let text = fs::read_to_string(&joints).expect("points");
    fs::write(&joints, text.replacen('1', "2", 1)).expect("written");
    refused(&arm, &["joints.trc: changed since it was written with result.json"]);
    fs::remove_file(&joints).expect("removed");
    ResultFile::read(&arm.out("out")).expect("whole");
}

/// A change of a result, and what must be said of it.
type Change = (fn(&mut ResultFile), &'static str);

#[test]
fn numbers_that_no_fit_writes_are_refused_even_with_the_right_sum() {
    let arm = Arm::new();
    arm.fit("out", &["--quiet"]).succeeded();
    let whole = ResultFile::read(&arm.out("out")).expect("whole");
    let changes: [Change; 8] = [
        (|r| r.recording.fps = -50.0, "recording.fps: expected a frame rate"),
        (|r| r.recording.fps = 1e9, "recording.fps: expected a frame rate"),
        (|r| r.recording.frames = 7, "recording.frames"),
        (|r| r.winner = 99, "winner: expected the number of a hypothesis"),
        (|r| r.motion.frames.reverse(), "motion.frames"),
        (|r| r.motion.frames[1].points_m.truncate(1), "as many angles and points"),
        (|r| r.hypotheses[0].coefficients.clear(), "hypotheses"),
        (|r| r.shape.covariance = Some(vec![vec![]]), "shape.covariance"),
    ];
    for (change, expected) in changes {
        let mut result = whole.clone();
        change(&mut result);
        for (name, bytes) in result.files().expect("JSON") {
            fs::write(arm.out("out").join(name), bytes).expect("written");
        }
        let message = ResultFile::read(&arm.out("out")).expect_err(expected).to_string();
        assert!(message.contains(expected), "{message}");
    }
    assert!(ResultFile::read(Path::new("no/where")).is_err());
}
