//! What a video sounds like.

use std::path::Path;
use std::process::Command;

use maquette::io::recording::footage::Loudness;
use maquette::pipeline::sound_delay_s;

/// A video of four seconds with beeps at these times, or without sound.
fn film(path: &Path, beeps_s: Option<[f64; 3]>) {
    let mut ffmpeg = Command::new("ffmpeg");
    ffmpeg.args(["-v", "error", "-f", "lavfi", "-i", "testsrc=size=32x24:rate=25:duration=6"]);
    if let Some(beeps) = beeps_s {
        let beep = |at: &f64| format!("between(t,{at},{})", at + 0.02);
        let beeps = beeps.iter().map(beep).collect::<Vec<_>>().join("+");
        let sound = format!("aevalsrc='0.001*sin(700*t)+({beeps})*0.7*sin(6000*t)':d=6");
        ffmpeg.args(["-f", "lavfi", "-i", &sound, "-c:a", "pcm_s16le"]);
    }
    assert!(ffmpeg.args(["-c:v", "mpeg4"]).arg(path).status().expect("it runs").success());
}

#[test]
#[allow(clippy::print_stderr, reason = "a skipped test says so")]
fn the_sound_of_two_videos_tells_their_delay() {
    if Command::new("ffmpeg").arg("-version").output().is_err() {
        eprintln!("skipped: no ffmpeg here");
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let loudness = |name: &str, beeps: Option<[f64; 3]>| {
        let path = folder.path().join(name);
        film(&path, beeps);
        Loudness::of(&path).expect("ffmpeg runs")
    };
    let beeps = [1.0, 1.7, 3.1];
    let a = loudness("a.mkv", Some(beeps)).expect("it sounds");
    let b = loudness("b.mov", Some(beeps.map(|at| at + 0.36))).expect("it sounds");
    let delay_s = sound_delay_s(&a.energy, &b.energy, 2.0).expect("it is distinct");
    assert!((delay_s + b.start_s - a.start_s - 0.36).abs() < 2e-3, "{delay_s}");
    assert_eq!(loudness("c.mkv", None), None);
}
