//! Videos: two of one camera, clocks that jump back, and what their sound says of their clocks.

use std::fs;
use std::path::Path;
use std::process::Command;

use crate::arm::Arm;
use crate::cameras::{fitted, on};
use crate::schema::check;

/// Whether a program can be run.
fn has(program: &str) -> bool {
    Command::new(program).arg("-version").output().is_ok()
}

#[test]
#[allow(clippy::print_stderr, reason = "a skipped test says so")]
fn two_videos_of_one_camera_and_a_clock_that_jumps_back_are_refused() {
    if !has("ffmpeg") {
        eprintln!("skipped: no ffmpeg here");
        return;
    }
    let arm = Arm::new();
    let videos = arm.recording().join("videos");
    fs::create_dir_all(&videos).unwrap();
    fs::remove_dir_all(arm.recording().join("masks")).unwrap();
    let film = |name: &str| {
        let made = Command::new("ffmpeg")
            .args([
                "-v",
                "error",
                "-y",
                "-f",
                "lavfi",
                "-i",
                "testsrc=size=160x120:rate=10:duration=1",
            ])
            .args(["-c:v", "mpeg2video", "-bf", "0"])
            .arg(videos.join(name))
            .status();
        assert!(made.unwrap().success());
    };
    for name in ["cam_01.ts", "cam_02.ts", "cam_03.ts", "cam_02.mkv"] {
        film(name);
    }
    arm.fit("two", &[]).refused(&["camera cam_02: both ", "cam_02.mkv", "cam_02.ts"]);
    fs::remove_file(videos.join("cam_02.mkv")).unwrap();
    let one = fs::read(videos.join("cam_01.ts")).unwrap();
    fs::write(videos.join("cam_01.ts"), [&one[..], &one[..]].concat()).unwrap();
    arm.fit("back", &[]).refused(&["cam_01.ts: the time stamps go backwards, from "]);
}

/// A video of six seconds with beeps at these times.
fn beeping(path: &Path, beeps_s: [f64; 3]) {
    let beep = |at: f64| format!("between(t,{at},{})", at + 0.02);
    let beeps = beeps_s.map(beep).join("+");
    let sound = format!("aevalsrc='0.001*sin(700*t)+({beeps})*0.7*sin(6000*t)':d=6");
    let made = Command::new("ffmpeg")
        .args(["-v", "error", "-f", "lavfi", "-i", "testsrc=size=160x120:rate=10:duration=6"])
        .args(["-f", "lavfi", "-i", &sound, "-c:a", "pcm_s16le", "-c:v", "mpeg4"])
        .arg(path)
        .status();
    assert!(made.expect("it runs").success());
}

#[test]
#[allow(clippy::print_stderr, reason = "a skipped test says so")]
fn the_sound_of_videos_agrees_or_differs() {
    if !has("ffmpeg") {
        eprintln!("skipped: no ffmpeg here");
        return;
    }
    let arm = Arm::new();
    let fit = fitted(&arm, "out", |_| {});
    let videos = arm.recording().join("videos");
    fs::create_dir_all(&videos).unwrap();
    // what began 2.3 frames later hears everything that much earlier in its video
    for (camera, later_s) in [("cam_01", 0.0), ("cam_02", 0.23), ("cam_03", -1.0)] {
        let beeps = [2.0, 2.7, 4.1].map(|at| at - later_s);
        beeping(&videos.join(format!("{camera}.mkv")), beeps);
    }
    let said = check("sync", &on("sync", &[&fit], &["--json", "--quiet"]).succeeded().out);
    let sound = |i: usize| &said["cameras"][i]["sound"];
    assert!(sound(0).is_null());
    assert_eq!(
        (sound(1)["agrees"].as_bool(), sound(1)["against"].as_str()),
        (Some(true), Some("cam_01"))
    );
    assert!((sound(1)["after_frames"].as_f64().unwrap() - 2.3).abs() < 0.02, "{said}");
    // the third keeps its offset, and its sound says that it should not
    assert_eq!(sound(2)["agrees"].as_bool(), Some(false));
    assert!((sound(2)["after_frames"].as_f64().unwrap() + 10.0).abs() < 0.02, "{said}");

    let ran = on("sync", &[&fit], &["--overwrite", "--no-sound"]).succeeded();
    assert!(!ran.out.contains("by sound"), "{}", ran.out);
    let ran = on("sync", &[&fit], &["--overwrite"]).succeeded();
    assert!(ran.out.contains("after cam_01: agrees") && ran.out.contains("DIFFERS"), "{}", ran.out);
}
