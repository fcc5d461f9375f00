//! What a report shows of the recording that was fitted.

use std::fs;

use image::{Rgb, RgbImage};

use crate::arm::{Arm, run};
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
