//! The smaller commands.

use maquette::io::recording::Recording;

use crate::arm::{Arm, run};

#[test]
fn without_arguments_the_program_says_what_it_is_for() {
    let said = run::<&str>(&[]).succeeded();
    for part in ["Usage: maquette", "fit", "Examples:", "--out out/walker"] {
        assert!(said.out.contains(part), "{part} not in {}", said.out);
    }
    assert_eq!(said.err, "");
    let help = run(&["fit", "--help"]).succeeded().out;
    for part in ["--keyframe-every", "[default: 20,", "joints.trc", "--resume"] {
        assert!(help.contains(part), "{part} not in {help}");
    }
    let version = run(&["--version"]).succeeded().out;
    assert_eq!(version.trim(), format!("maquette {}", env!("CARGO_PKG_VERSION")));
}

#[test]
fn every_shipped_model_is_listed() {
    let said = run(&["models"]).succeeded().out;
    for (name, _) in maquette::io::model::SHIPPED {
        assert!(said.contains(name), "{name} not in {said}");
    }
}

#[test]
fn a_synthetic_recording_can_be_read_and_is_not_written_over() {
    let place = Arm::new();
    let out = place.out("somebody").display().to_string();
    let make = |seed| {
        run(&[
            "synth",
            &out,
            "--seed",
            seed,
            "--cameras",
            "2",
            "--frames",
            "1",
            "--noise",
            "none",
            "--points",
        ])
    };
    let said = make("3").succeeded();
    assert!(said.out.contains("1 frame of 2 cameras at 50 Hz"), "{}", said.out);
    let recording = Recording::open(place.out("somebody"))
        .and_then(|found| found.observations())
        .expect("a recording");
    assert_eq!((recording.rig.cameras.len(), recording.frames.len()), (2, 1));
    assert!(place.out("somebody").join("points/000000.ply").is_file());
    make("4").refused(&["this folder is not empty"]);
    run(&["synth", &out, "--fps", "0"]).refused(&["expected a frame rate from 0.1"]);
    run(&["synth", &out, "--cameras", "0"]).refused(&["0 is not in 1..=64"]);
}

#[test]
fn photographs_before_clutter_are_made_by_three_cameras_without_masks() {
    let place = Arm::new();
    let out = place.out("film").display().to_string();
    let said = run(&["synth", &out, "--clutter", "--frames", "1"]).succeeded();
    assert!(said.out.contains("1 frame of 3 cameras at 25 Hz"), "{}", said.out);
    let image = place.out("film").join("images/center/000000.jpg");
    assert!(image.is_file());
    run(&["synth", &out, "--clutter", "--cameras", "4"]).refused(&["--clutter", "--cameras"]);
}
