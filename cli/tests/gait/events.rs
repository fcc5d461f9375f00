//! Foot strikes and foot offs that a person has corrected, from outside.

use std::fs;
use std::path::{Path, PathBuf};

use serde_json::{Value, json};
use tempfile::TempDir;

use crate::arm::{Ran, run};
use crate::walker::Walker;

/// A walk, and the events that the program finds, as the report's page saves them.
fn walk() -> (TempDir, PathBuf, Value) {
    let folder = tempfile::tempdir().expect("a folder");
    let trc = folder.path().join("walk.trc");
    fs::write(&trc, Walker::new(0.4).trc()).expect("a file");
    let gait = gait(&trc, &["--out", &text(&folder.path().join("first"))]).succeeded();
    let gait: Value = serde_json::from_str(&gait.out).expect("JSON");
    let (gait, fps) = (&gait["gait"], &gait["gait"]["fps"]);
    assert_eq!(gait["event_source"], "detected");

    let event = |event: &Value| {
        let frame = event["time_s"].as_f64().expect("a time") * fps.as_f64().expect("a rate");
        json!({ "side": event["side"], "kind": event["kind"], "frame": frame })
    };
    let events: Vec<Value> = gait["events"].as_array().expect("events").iter().map(event).collect();
    let file = json!({
        "format": "maquette-events", "version": 1, "fps": fps, "first_frame": 0, "frames": gait["frames"], "events": events,
    });
    (folder, trc, file)
}

fn text(path: &Path) -> String {
    path.display().to_string()
}

fn gait(trc: &Path, more: &[&str]) -> Ran {
    run(&[&["gait", &text(trc), "--json", "--overwrite"][..], more].concat())
}

#[test]
fn corrected_events_stand_in_the_place_of_those_that_are_found_and_every_output_says_so() {
    let (folder, trc, mut file) = walk();
    // the last event was none
    file["events"].as_array_mut().expect("events").pop();
    let events = folder.path().join("corrected.json");
    fs::write(&events, file.to_string()).expect("a file");
    let events = text(&events);

    let said = gait(&trc, &["--events", &events, "--report"]).succeeded();
    let said: Value = serde_json::from_str(&said.out).expect("JSON");
    assert_eq!(said["gait"]["event_source"], "person");
    let times = said["gait"]["events"].as_array().map(Vec::len);
    assert_eq!(times, file["events"].as_array().map(Vec::len));
    let out = folder.path().join("walk_gait");
    let report = fs::read_to_string(out.join("report.html")).expect("a report");
    assert!(report.contains("as a person corrected them (events.json)"));
    assert!(report.contains("id=\"event-save\""));

    let summary = run(&["gait", &text(&trc), "--overwrite", "--events", &events]).succeeded();
    assert!(summary.out.contains("! a person corrected the foot strikes"), "{}", summary.out);
}

#[test]
fn corrected_events_that_cannot_be_are_refused_in_one_line() {
    let (folder, trc, file) = walk();
    let path = folder.path().join("corrected.json");
    let refused = |file: &Value, expected: &str| {
        fs::write(&path, file.to_string()).expect("a file");
        gait(&trc, &["--events", &text(&path)]).refused(&["corrected.json: ", expected]);
    };
    let mut other = file.clone();
    other["frames"] = json!(12);
    refused(&other, "frames 12, but what is analysed has");
    let mut twice = file.clone();
    let again = twice["events"][1].clone();
    twice["events"].as_array_mut().expect("events").push(again);
    refused(&twice, "event ");
    let mut nobody = file;
    nobody["events"][2]["side"] = json!("middle");
    refused(&nobody, "event 3: side \"middle\": expected \"left\" or \"right\"");
    gait(&trc, &["--events", "nowhere.json"]).refused(&["nowhere.json: cannot be read"]);
}
