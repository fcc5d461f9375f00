//! Files and folders of odd kinds: pipes, devices, one long line, a percent sign in a name.

use std::fs;

use crate::arm::{Arm, run};

#[cfg(unix)]
#[test]
fn inputs_that_never_end_are_refused_at_once() {
    let pipe = |path: &std::path::Path| {
        drop(fs::remove_file(path));
        let made = std::process::Command::new("mkfifo").arg(path).status();
        assert!(made.is_ok_and(|status| status.success()), "no mkfifo");
    };

    let arm = Arm::new();
    let mask = arm.mask_path("cam_02", 4);
    fs::remove_file(&mask).expect("removed");
    std::os::unix::fs::symlink("/dev/zero", &mask).expect("a link");
    arm.fit("out", &[]).refused(&["cam_02/000004.png", "expected a file, found a device"]);
    pipe(&mask);
    arm.fit("out", &[]).refused(&["cam_02/000004.png", "expected a file, found a pipe"]);

    for name in ["sequence.toml", "calibration.toml"] {
        let arm = Arm::new();
        pipe(&arm.recording().join(name));
        arm.fit("out", &[]).refused(&[name, "expected a file, found a pipe"]);
    }
    for name in ["body.toml", "walk.trc", "norm.toml"] {
        pipe(&arm.recording().join(name));
    }
    let at = |name: &str| arm.recording().join(name).display().to_string();
    let expected = &["expected a file, found a pipe"];
    Arm::new().fit_with_body("out", &at("body.toml"), &[]).refused(expected);
    run(&["gait", &at("walk.trc")]).refused(expected);
}

#[test]
fn a_file_of_one_long_line_gives_a_short_message() {
    let long = "7".repeat(2_000_000);
    for (name, text) in [
        ("calibration.toml", format!("[cam_01]\nname = {long}x\n")),
        ("sequence.toml", format!("fps = \"{long}\"\n")),
    ] {
        let arm = Arm::new();
        arm.write(name, &text);
        let said = arm.fit("out", &[]);
        assert!(said.err.len() < 1500, "{} bytes", said.err.len());
        said.refused(&[name]);
    }
}

#[test]
fn a_folder_may_have_a_percent_sign_in_its_name() {
    let arm = Arm::new();
    let folder = arm.out("100%d");
    fs::rename(arm.recording(), &folder).expect("renamed");
    fs::write(folder.join("sequence.toml"), "fps = 10\nmasks = \"masks/{camera}/%06d.png\"\n")
        .expect("written");
    let mut arguments = arm.fit_arguments("out");
    arguments[1] = folder.display().to_string();
    run(&arguments).succeeded();
}
