//! What a report shows of the recording that was fitted.

use std::fs;
#[cfg(unix)]
use std::os::unix::fs::PermissionsExt;

#[cfg(unix)]
use assert_cmd::Command;
use image::{Rgb, RgbImage};
use serde_json::json;

use crate::arm::{Arm, run};
#[cfg(unix)]
use crate::arm::{program, ran};
use crate::schema::check;

/// A walk of ten frames before three cameras, with masks and with pictures of one colour.
fn filmed(place: &Arm, name: &str, seed: &str) -> String {
    let folder = place.out(name);
    let path = folder.display().to_string();
    let made = ["synth", &path, "--seed", seed, "--frames", "10", "--cameras", "3"];
    run(&made).succeeded();
    let manifest = folder.join("sequence.toml");
    let mut text = fs::read_to_string(&manifest).expect("a manifest");
    for camera in ["cam_01", "cam_02", "cam_03"] {
        let masks = format!("masks = \"masks/{camera}/%06d.png\"");
        text = text.replace(&masks, &format!("{masks}\nimages = \"images/{camera}/%06d.jpg\""));
        fs::create_dir_all(folder.join("images").join(camera)).expect("a folder");
        for frame in 0..10 {
            let image = RgbImage::from_pixel(640, 480, Rgb([10, 120, 200]));
            let file = folder.join(format!("images/{camera}/{frame:06}.jpg"));
            image.save(file).expect("a picture");
        }
    }
    fs::write(manifest, text).expect("written");
    path
}

#[test]
fn a_report_finds_its_recording_shows_its_pictures_and_refuses_another_one() {
    let place = Arm::new();
    let recording = filmed(&place, "walk", "1");
    let out = place.out("out").display().to_string();
    let fit = ["fit", &recording, "--out", &out, "--keyframe-every", "9", "--joint", "off"];
    run(&[&fit[..], &["--quiet"]].concat()).succeeded();

    let report = |arguments: &[&str]| {
        let said = run(&[&["report", &out][..], arguments].concat()).succeeded();
        (said.err, fs::read_to_string(place.out("out/report.html")).expect("a report"))
    };
    let (_, page) = report(&[]);
    assert!(page.contains("\"jpeg\":\"/9j/") && page.contains("id=\"camera-body\""));
    assert!(page.contains("<td>walk</td>"), "the name of the recording");
    let json = run(&["report", &out, "--json", "--quiet"]).succeeded().out;
    assert!(check("report", &json)["report"].as_str().is_some_and(|p| p.ends_with("report.html")));
    let json = run(&["export", &out, "--format", "c3d,mot", "--json"]).succeeded().out;
    assert_eq!(check("export", &json)["files"].as_array().map(Vec::len), Some(2));
    let (_, page) = report(&["--no-pictures"]);
    assert!(!page.contains("\"jpeg\"") && page.contains("\"cam_02\""), "outlines only");

    // events that a person has put beside the fit, and of another recording
    let fps = place.result("out")["recording"]["fps"].clone();
    let events = |frames: usize| {
        let event = json!({ "side": "left", "kind": "off", "frame": 4 });
        let file = json!({
            "format": "maquette-events", "version": 1, "fps": fps, "first_frame": 0, "frames": frames, "events": [event],
        });
        file.to_string()
    };
    fs::write(place.out("out/events.json"), events(10)).expect("written");
    assert!(report(&[]).1.contains("as a person corrected them"));
    assert!(!report(&["--events", "none"]).1.contains("as a person corrected them"));
    fs::write(place.out("out/events.json"), events(11)).expect("written");
    run(&["report", &out]).refused(&["out/events.json: frames 11, but"]);
    fs::remove_file(place.out("out/events.json")).expect("removed");

    // another person before the same cameras
    let other = filmed(&place, "other", "2");
    run(&["report", &out, "--recording", &other]).refused(&["other", "not the recording"]);
    // the recording is not where it was
    fs::rename(place.out("walk"), place.out("moved")).expect("moved");
    let (said, page) = report(&[]);
    assert!(said.contains("without camera views") && said.contains("walk"), "{said}");
    assert!(page.contains("No camera views"));
    let moved = place.out("moved").display().to_string();
    assert!(report(&["--recording", &moved]).1.contains("\"jpeg\""));
}

#[cfg(unix)]
#[test]
#[allow(clippy::print_stderr, reason = "a test that is skipped says so")]
fn a_report_is_printed_by_the_browser_that_is_named_or_an_installed_one() {
    let place = Arm::new();
    let recording = filmed(&place, "walk", "1");
    let out = place.out("out").display().to_string();
    let fit = ["fit", &recording, "--out", &out, "--keyframe-every", "9", "--joint", "off"];
    run(&[&fit[..], &["--quiet"]].concat()).succeeded();

    let report = |browser: Option<&str>| {
        let mut program = Command::new(program());
        program.args(["report", &out, "--pdf", "--json", "--quiet"]);
        program.env_remove("CHROME").envs(browser.map(|name| ("CHROME", name)));
        ran(&program.output().expect("the program starts"))
    };
    let script = |text: &str| {
        let path = place.out("browser");
        fs::write(&path, format!("#!/bin/sh\n{text}\n")).expect("a file");
        fs::set_permissions(&path, fs::Permissions::from_mode(0o755)).expect("a program");
        path.display().to_string()
    };
    let pdf = place.out("out/report.pdf");

    let prints =
        script("for word; do case $word in --print-to-pdf=*) echo %PDF > ${word#*=};; esac; done");
    let said = report(Some(&prints)).succeeded();
    assert_eq!(check("report", &said.out)["pdf"], pdf.display().to_string());
    assert_eq!((fs::read(&pdf).expect("a PDF"), said.err), (b"%PDF\n".to_vec(), String::new()));

    // the page stays, and no PDF of another page beside it
    fs::remove_file(place.out("out/report.html")).expect("removed");
    report(Some(&script("echo noise >&2; exit 9")))
        .refused(&["report.html: no PDF", "browser wrote none"]);
    assert!(place.out("out/report.html").exists() && !pdf.exists());
    report(Some("no-such-browser")).refused(&["no-such-browser", "print it"]);

    let installed = report(None);
    if installed.err.contains("no Chromium or Chrome is installed") {
        eprintln!("skipped: no browser is installed here");
        return;
    }
    installed.succeeded();
    let printed = fs::read(&pdf).expect("a PDF");
    let text = String::from_utf8_lossy(&printed);
    assert!(text.starts_with("%PDF-") && text.contains("/MediaBox [0 0 594"), "on A4");
}
