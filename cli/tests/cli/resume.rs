//! Runs that were stopped, and results that are there already.

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use maquette::io::folder::OutFolder;
use maquette::io::model;

use crate::arm::{Arm, program, run};

fn journal_files(out: &Path) -> Vec<String> {
    let entries = fs::read_dir(out.join(".journal")).into_iter().flatten();
    let mut names: Vec<String> =
        entries.flatten().map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

#[test]
fn a_run_that_lost_its_end_continues_to_the_same_bytes() {
    let arm = Arm::new();
    arm.fit("whole", &["--quiet"]).succeeded();
    arm.fit("cut", &["--quiet"]).succeeded();
    let out = arm.out("cut");
    let journal = out.join(".journal");
    fs::remove_file(out.join("result.json")).expect("removed");
    for name in ["trial-0002.json", "keyframe-000002.json"] {
        fs::remove_file(journal.join(name)).expect("removed");
    }
    let half = fs::read(journal.join("trial-0003.json")).expect("a trial");
    fs::write(journal.join("trial-0003.json"), &half[..half.len() / 2]).expect("written");
    fs::write(journal.join(".writing-abc"), "left by a kill").expect("written");
    let said = arm.fit("cut", &["--resume"]).succeeded();
    let note = "note: ";
    assert!(
        said.err.starts_with(note) && said.err.contains("trial-0003.json: changed"),
        "{said:?}"
    );
    for name in ["result.json", "joints.trc"] {
        assert_eq!(arm.bytes("whole", name), arm.bytes("cut", name), "{name}");
    }
    assert_eq!(journal_files(&out), journal_files(&arm.out("whole")));
}

#[test]
fn a_run_that_was_killed_at_any_time_continues_to_the_same_bytes() {
    let arm = Arm::new();
    arm.fit("whole", &["--quiet"]).succeeded();
    for (i, wanted) in ["run.json", "keyframe-000002.json", "trial-0001.json"].iter().enumerate() {
        let name = format!("killed-{i}");
        let awaited = arm.out(&name).join(".journal").join(wanted);
        let mut child = Command::new(program())
            .args(arm.fit_arguments(&name))
            .stdout(Stdio::null())
            .spawn()
            .expect("started");
        let start = Instant::now();
        while !awaited.exists() && start.elapsed() < Duration::from_secs(20) {
            std::thread::sleep(Duration::from_millis(1));
        }
        child.kill().expect("killed");
        child.wait().expect("ended");
        arm.fit(&name, &["--quiet", "--resume"]).succeeded();
        assert_eq!(arm.bytes("whole", "result.json"), arm.bytes(&name, "result.json"), "{wanted}");
    }
}

#[test]
fn to_resume_what_was_never_begun_is_to_begin() {
    let arm = Arm::new();
    arm.fit("out", &["--quiet", "--resume"]).succeeded();
    assert!(arm.out("out").join("result.json").exists());
}

#[test]
fn another_option_or_input_is_not_continued_and_nothing_is_lost() {
    let arm = Arm::new();
    arm.fit("out", &["--quiet"]).succeeded();
    let before = (arm.bytes("out", "result.json"), journal_files(&arm.out("out")));
    arm.fit("out", &["--resume", "--likelihood", "published"])
        .refused(&["started with another options estimate likelihood", "--overwrite"]);
    arm.fit("out", &["--resume", "--frames", "0:3"])
        .refused(&["started with another last frame (5, now 3)"]);
    let other = crate::arm::mask(&crate::arm::rig().cameras[0], 0);
    arm.write_mask("cam_01", 1, &other);
    arm.fit("out", &["--resume"]).refused(&["another inputs 2: masks of cam_01"]);
    let after = (arm.bytes("out", "result.json"), journal_files(&arm.out("out")));
    assert_eq!(before, after);
}

#[test]
fn a_run_is_not_continued_with_another_base_of_its_body() {
    let arm = Arm::new();
    let path = |name: &str| arm.recording().join(name);
    let shipped = model::SHIPPED.iter().find(|(name, _)| *name == "arm-2d");
    let (_, base) = shipped.expect("shipped");
    arm.write("base.toml", base);
    arm.write("body.toml", "name = \"mine\"\nextends = \"base.toml\"\n");
    let body = path("body.toml").display().to_string();
    arm.fit_with_body("out", &body, &[]).succeeded();
    arm.fit_with_body("out", &body, &["--resume"]).succeeded();
    arm.write("base.toml", &base.replacen("sd = 1.0", "sd = 0.9", 1));
    arm.fit_with_body("out", &body, &["--resume"]).refused(&["another inputs", "body arm-2d"]);
}

#[test]
fn a_result_is_replaced_only_on_request_and_only_by_a_complete_one() {
    let arm = Arm::new();
    arm.fit("out", &["--quiet", "--overlays"]).succeeded();
    fs::write(arm.out("out").join("notes.txt"), "mine").expect("written");
    let before = arm.bytes("out", "result.json");
    arm.fit("out", &[]).refused(&["out: this folder is not empty", "--overwrite", "--resume"]);
    // a fault in the input is found before anything is touched
    let calibration = fs::read_to_string(arm.recording().join("calibration.toml")).expect("read");
    arm.write("calibration.toml", "nonsense");
    arm.fit("out", &["--overwrite"]).refused(&["calibration.toml"]);
    assert_eq!(arm.bytes("out", "result.json"), before);
    arm.write("calibration.toml", &calibration);
    arm.fit("out", &["--quiet", "--overwrite", "--frames", "0:3"]).succeeded();
    assert_eq!(arm.result("out")["recording"]["frames"], 4);
    assert_eq!(arm.bytes("out", "notes.txt"), b"mine");
    assert!(!arm.out("out").join("overlays").exists(), "pictures of the older result");
}

#[test]
fn one_run_at_a_time_writes_into_a_folder() {
    let arm = Arm::new();
    let this = format!("another run writes into this folder (process {}: ", std::process::id());
    let held = OutFolder::open(&arm.out("out")).expect("locked");
    for more in [&[][..], &["--resume"], &["--overwrite"]] {
        arm.fit("out", more).refused(&[&this]);
    }
    let (recording, out) = (arm.recording(), arm.out("out"));
    let [recording, out] = [&recording, &out].map(|path| path.display().to_string());
    for verb in ["segment", "stereo", "silhouettes"] {
        run(&[verb, &recording, "--out", &out, "--overwrite"]).refused(&[&this]);
    }

    // a lock that is left by a run that was killed holds nobody up
    drop(held);
    fs::create_dir(&out).expect("a folder");
    fs::write(arm.out("out").join(".lock"), "process 1: maquette fit").expect("written");
    arm.fit("out", &["--quiet"]).succeeded();
    assert!(!arm.out("out").join(".lock").exists());
}

#[test]
fn steps_of_a_longer_run_are_named_and_computed_again() {
    let arm = Arm::new();
    arm.fit("long", &["--quiet"]).succeeded();
    arm.fit("short", &["--quiet", "--frames", "0:3"]).succeeded();
    let whole = arm.bytes("short", "result.json");

    let foreign: Vec<String> =
        journal_files(&arm.out("long")).into_iter().filter(|name| name != "run.json").collect();
    for name in &foreign {
        let [from, to] = ["long", "short"].map(|out| arm.out(out).join(".journal").join(name));
        fs::copy(from, to).expect("copied");
    }
    fs::remove_file(arm.out("short").join("result.json")).expect("removed");
    let said = arm.fit("short", &["--resume", "--frames", "0:3"]).succeeded();
    let others = format!("another run's, and {} more like it", foreign.len() - 1);
    assert!(said.err.contains(&others), "{said:?}");
    assert_eq!(arm.bytes("short", "result.json"), whole);
}

#[test]
fn a_step_that_cannot_be_kept_ends_the_run_at_once_and_what_was_kept_is_continued_from() {
    let arm = Arm::new();
    arm.fit("whole", &["--quiet"]).succeeded();
    arm.fit("out", &["--quiet"]).succeeded();
    let journal = arm.out("out").join(".journal");
    fs::remove_file(arm.out("out").join("result.json")).expect("removed");
    for name in journal_files(&arm.out("out")).iter().filter(|name| name.starts_with("trial-")) {
        fs::remove_file(journal.join(name)).expect("removed");
    }
    // no file can take the place of a folder that is not empty
    for i in 0..9 {
        fs::create_dir_all(journal.join(format!("trial-{i:04}.json/full"))).expect("a folder");
    }

    let stopped = arm.fit("out", &["--resume", "--quiet"]);
    assert_eq!(stopped.code, Some(2), "{stopped:?}");
    for part in [".json: cannot be written", "continue it with --resume"] {
        assert!(stopped.err.contains(part), "{part} not in {}", stopped.err);
    }
    assert!(!arm.out("out").join("result.json").exists());
    for i in 0..9 {
        fs::remove_dir_all(journal.join(format!("trial-{i:04}.json"))).expect("removed");
    }
    arm.fit("out", &["--resume", "--quiet"]).succeeded();
    assert_eq!(arm.bytes("out", "result.json"), arm.bytes("whole", "result.json"));
}

#[cfg(unix)]
#[test]
fn a_result_that_cannot_be_written_can_be_resumed() {
    let arm = Arm::new();
    arm.fit("out", &["--quiet"]).succeeded();
    let whole = arm.bytes("out", "result.json");
    fs::remove_file(arm.out("out").join("result.json")).expect("removed");

    // no file may be longer than a kilobyte, and the result is
    assert!(whole.len() > 1024);
    let mut arguments = arm.fit_arguments("out");
    arguments.extend(["--quiet", "--resume"].map(Into::into));
    let limited = "trap '' XFSZ; ulimit -f 1; exec \"$@\"";
    let stopped =
        Command::new("sh").args(["-c", limited, "sh", program()]).args(&arguments).output();
    let stopped = stopped.expect("a shell");
    let said = String::from_utf8_lossy(&stopped.stderr);
    assert_eq!(stopped.status.code(), Some(2), "{said}");
    assert_eq!(said.lines().count(), 1, "{said}");
    for part in ["cannot be written: ", "continue it with --resume"] {
        assert!(said.contains(part), "{part} not in {said}");
    }
    assert!(!arm.out("out").join("result.json").exists());

    arm.fit("out", &["--resume", "--quiet"]).succeeded();
    assert_eq!(arm.bytes("out", "result.json"), whole);
}

#[cfg(unix)]
#[test]
fn a_signal_ends_a_run_with_one_line_that_says_how_to_go_on() {
    for (signal, code) in [("INT", 130), ("TERM", 143), ("HUP", 129)] {
        let arm = Arm::new();
        // a body that takes long to find
        let mut arguments = arm.fit_arguments("out");
        let body = arguments.iter().position(|a| a == "arm-2d").expect("a body");
        arguments[body] = "human-ellipsoids".into();
        let mut child = Command::new(program());
        child.args(&arguments).stdout(Stdio::null()).stderr(Stdio::piped());
        let child = child.spawn().expect("started");

        let (begun, start) = (arm.out("out").join(".journal/run.json"), Instant::now());
        while !begun.exists() && start.elapsed() < Duration::from_secs(60) {
            std::thread::sleep(Duration::from_millis(1));
        }
        let pid = child.id().to_string();
        let sent = Command::new("kill").args(["-s", signal, &pid]).status();
        assert!(sent.is_ok_and(|status| status.success()), "no kill");
        let ended = child.wait_with_output().expect("ended");
        let said = String::from_utf8_lossy(&ended.stderr);
        assert_eq!(ended.status.code(), Some(code), "{said}");
        assert_eq!(said.lines().count(), 1, "{said}");
        assert!(
            said.starts_with(&format!("stopped by SIG{signal}: ")) && said.contains("--resume")
        );

        // its lock holds nobody up
        assert!(arm.out("out").join(".lock").exists());
        OutFolder::open(&arm.out("out")).expect("free");
    }
}
