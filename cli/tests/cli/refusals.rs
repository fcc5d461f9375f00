//! Bad input: one line, exit code 2, nothing written.

use std::fs;

use image::{GrayImage, Luma};
use maquette::io::calibration;

use crate::arm::{Arm, FRAMES, SIZE, mask, rig, run};

/// A way to spoil a recording, arguments to go with it, and what must be said.
type Case = (&'static str, fn(&Arm), &'static [&'static str], &'static [&'static str]);

fn check(cases: &[Case]) {
    for (name, spoil, arguments, parts) in cases {
        let arm = Arm::new();
        spoil(&arm);
        let ran = arm.fit("out", arguments);
        ran.refused(parts);
        assert!(!arm.out("out").exists(), "{name}: something was written");
    }
}

fn edit_calibration(arm: &Arm, from: &str, to: &str) {
    let text = calibration::write_toml(&rig());
    assert!(text.contains(from), "{from} not in {text}");
    arm.write("calibration.toml", &text.replacen(from, to, 1));
}

/// Turns a camera by half a turn about its vertical axis.
fn look_away(arm: &Arm) {
    let mut rig = rig();
    let pose = &mut rig.cameras[1].camera_from_world;
    let turn =
        nalgebra::UnitQuaternion::from_scaled_axis(nalgebra::Vector3::y() * std::f64::consts::PI);
    *pose = nalgebra::Isometry3::from_parts(nalgebra::Translation3::identity(), turn) * *pose;
    arm.write("calibration.toml", &calibration::write_toml(&rig));
}

fn fill_masks(arm: &Arm, value: u8) {
    for camera in &rig().cameras {
        for frame in 0..FRAMES {
            let filled = GrayImage::from_pixel(SIZE.0, SIZE.1, Luma([value]));
            arm.write_mask(&camera.name, frame, &filled);
        }
    }
}

fn spoil_mask(arm: &Arm, spoil: impl Fn(&mut Vec<u8>)) {
    let path = arm.mask_path("cam_02", 4);
    let mut bytes = fs::read(&path).expect("a mask");
    spoil(&mut bytes);
    fs::write(path, bytes).expect("written");
}

const CALIBRATIONS: &[Case] = &[
    (
        "missing",
        |arm| fs::remove_file(arm.recording().join("calibration.toml")).expect("removed"),
        &[],
        &["no calibration in this folder"],
    ),
    ("unreadable", |arm| arm.write("calibration.toml", "[cam_01\n"), &[], &["calibration.toml:1"]),
    (
        "focal length 0",
        |arm| edit_calibration(arm, "150.0", "0.0"),
        &[],
        &["calibration.toml:", "camera cam_01", "focal length 0 px is not positive"],
    ),
    (
        "NaN",
        |arm| edit_calibration(arm, "150.0", "nan"),
        &[],
        &["camera cam_01", "expected a finite number, found NaN"],
    ),
    (
        "not a rotation",
        |arm| {
            edit_calibration(
                arm,
                "rotation = [",
                "rotation = [[1.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 1.0]] # [",
            );
        },
        &[],
        &["camera cam_01", "rotation"],
    ),
    (
        "two cameras of one name",
        |arm| edit_calibration(arm, "name = \"cam_02\"", "name = \"cam_01\""),
        &[],
        &["cam_01"],
    ),
    (
        "a camera that looks away",
        look_away,
        &[],
        &["camera cam_02 sees no volume in common with the other cameras", "unit and up"],
    ),
    (
        "millimetres taken for metres",
        |arm| arm.write("sequence.toml", "fps = 10\nunit = \"mm\"\n"),
        &[],
        &["masks or points show something 0.00", "check unit"],
    ),
];

#[test]
fn calibrations_that_cannot_be_used() {
    check(CALIBRATIONS);
}

const MASKS: &[Case] = &[
    (
        "no masks",
        |arm| fs::remove_dir_all(arm.recording().join("masks")).expect("removed"),
        &[],
        &["no masks and no pictures: expected masks/<camera>/"],
    ),
    (
        "points only",
        |arm| {
            fs::rename(arm.recording().join("masks"), arm.recording().join("points"))
                .expect("renamed");
        },
        &[],
        &["no masks and no pictures"],
    ),
    (
        "truncated",
        |arm| spoil_mask(arm, |bytes| bytes.truncate(bytes.len() / 2)),
        &[],
        &["masks/cam_02/000004.png: camera cam_02, frame 4: the mask cannot be decoded"],
    ),
    (
        "an absurd header",
        |arm| {
            spoil_mask(arm, |bytes| {
                bytes[16..20].copy_from_slice(&100_000u32.to_be_bytes());
                bytes[20..24].copy_from_slice(&100_000u32.to_be_bytes());
            });
        },
        &[],
        &["camera cam_02, frame 4: "],
    ),
    (
        "another size",
        |arm| arm.write_mask("cam_03", 2, &GrayImage::new(80, 60)),
        &[],
        &["camera cam_03, frame 2: the mask is 80 × 60 px, expected 160 × 120 px"],
    ),
    (
        "all empty",
        |arm| fill_masks(arm, 0),
        &[],
        &["none of the 18 masks shows a person", "the mask is empty"],
    ),
    (
        "all full",
        |arm| fill_masks(arm, 255),
        &[],
        &["none of the 18 masks shows a person", "image edge"],
    ),
    (
        "somebody who is not yet in view",
        |arm| {
            for (i, camera) in rig().cameras.iter().enumerate() {
                for frame in 0..FRAMES {
                    // the middle of the upper, the left and the lower edge
                    let edge = |x: u32, y: u32| match i {
                        0 => y < 8 && x.abs_diff(SIZE.0 / 2) < 20,
                        1 => x < 8 && y.abs_diff(SIZE.1 / 2) < 20,
                        _ => y > SIZE.1 - 8 && x.abs_diff(SIZE.0 / 2) < 20,
                    };
                    let mask = GrayImage::from_fn(SIZE.0, SIZE.1, |x, y| {
                        Luma([if edge(x, y) { 255 } else { 0 }])
                    });
                    arm.write_mask(&camera.name, frame, &mask);
                }
            }
        },
        &[],
        &["is the person in view yet?", "--frames FIRST:LAST"],
    ),
    (
        "one camera has all there is to see",
        |arm| {
            fill_masks(arm, 0);
            arm.write_mask("cam_02", 0, &mask(&rig().cameras[1], 0));
        },
        &[],
        &[
            "no frame shows the person to two cameras at once (most are shown by camera cam_02: 1)",
            "cannot be told apart",
        ],
    ),
    (
        "only one camera",
        |arm| {
            for camera in ["cam_02", "cam_03"] {
                fs::remove_dir_all(arm.recording().join("masks").join(camera)).expect("removed");
            }
        },
        &[],
        &["only one camera (cam_01) has masks", "cannot tell size"],
    ),
];

#[test]
fn masks_that_cannot_be_used() {
    check(MASKS);
}

const MANIFESTS: &[Case] = &[
    (
        "a camera that is not calibrated",
        |arm| {
            arm.write("sequence.toml", "[[camera]]\nname = \"cam_9\"\nmasks = \"masks/cam_01\"\n")
        },
        &[],
        &["no camera \"cam_9\"", "cam_01, cam_02, cam_03"],
    ),
    (
        "two cameras of one name",
        |arm| {
            let camera = "[[camera]]\nname = \"cam_01\"\nmasks = \"masks/cam_01\"\n";
            arm.write("sequence.toml", &format!("{camera}{camera}"));
        },
        &[],
        &["camera \"cam_01\" is listed 2 times"],
    ),
    (
        "an unknown key",
        |arm| arm.write("sequence.toml", "fsp = 10\n"),
        &[],
        &["sequence.toml:1: unknown key \"fsp\"; did you mean \"fps\"?"],
    ),
    (
        "fps 1e308",
        |arm| arm.write("sequence.toml", "fps = 1e308\n"),
        &[],
        &["fps = 1", "expected a frame rate from 0.1 to 100000 Hz"],
    ),
    (
        "a clock that is none",
        |arm| arm.write("sequence.toml", "[[camera]]\nname = \"cam_01\"\nstart_s = nan\n"),
        &[],
        &["camera cam_01: start_s = NaN: expected a number"],
    ),
    (
        "an offset of 2^63",
        |arm| {
            let offset = i64::MIN;
            let text = format!("[[camera]]\nname = \"cam_01\"\noffset_frames = {offset}\n");
            arm.write("sequence.toml", &text);
        },
        &[],
        &["camera cam_01: offset_frames = -9"],
    ),
    (
        "numbers that are no frames",
        |arm| {
            for camera in ["cam_01", "cam_02", "cam_03"] {
                let late = arm.mask_path(camera, 0).with_file_name("1700000000.png");
                fs::rename(arm.mask_path(camera, 5), late).expect("renamed");
            }
        },
        &[],
        &["numbered from frame 0 to frame 1700000000", "number the files by frame"],
    ),
    (
        "fps 0",
        |arm| arm.write("sequence.toml", "body = \"arm-2d\"\nfps = 0\n"),
        &[],
        &["sequence.toml:2: fps = 0: expected a frame rate from 0.1 to 100000 Hz"],
    ),
];

#[test]
fn manifests_that_cannot_be_used() {
    check(MANIFESTS);
}

#[test]
fn bodies_that_cannot_be_used() {
    let bodies = [
        (
            "cycle.toml",
            "name = \"upper\"\n",
            "name = \"upper\"\nparent = \"lower\"\n",
            "expected one part without a parent",
        ),
        (
            "orphan.toml",
            "parent = \"upper\"",
            "parent = \"uper\"",
            "\"uper\", which the file does not define",
        ),
        (
            "negative.toml",
            "radii = [0.5, 0.12, 0.12]",
            "radii = [0.5, -0.12, 0.12]",
            "radius -0.12 m is not positive",
        ),
        ("syntax.toml", "[[part]]", "[[part", "syntax.toml:"),
    ];
    let shipped = maquette::io::model::SHIPPED;
    let text = shipped.iter().find(|(name, _)| *name == "arm-2d").expect("shipped").1;
    for (name, from, to, part) in bodies {
        let arm = Arm::new();
        assert!(text.contains(from), "{from}");
        arm.write(name, &text.replacen(from, to, 1));
        let body = arm.recording().join(name).display().to_string();
        arm.fit_with_body("out", &body, &[]).refused(&[name, part]);
        assert!(!arm.out("out").exists());
    }
    let arm = Arm::new();
    arm.fit_with_body("out", "human", &[])
        .refused(&["no body model \"human\": shipped are human-ellipsoids"]);
}

#[test]
fn a_body_without_what_it_is_to_be_compared_by() {
    let arm = Arm::new();
    for likelihood in ["metaballs", "both"] {
        arm.fit("out", &["--likelihood", likelihood])
            .refused(&["the body arm-2d has no metaballs", "another --likelihood"]);
    }
    let mut arguments = arm.fit_arguments("out");
    arguments.extend(["--body", "walker-metaballs", "--likelihood", "ellipses"].map(Into::into));
    arguments.retain(|a| a != "arm-2d");
    let first = arguments.iter().position(|a| a == "--body").expect("a body");
    arguments.remove(first);
    run(&arguments).refused(&["the body walker-metaballs has no ellipsoids"]);
    assert!(!arm.out("out").exists());
}

#[test]
fn places_that_cannot_be_written() {
    let arm = Arm::new();
    fs::write(arm.out("file"), "").expect("written");
    arm.fit("file", &[]).refused(&["file: this is a file: expected a folder"]);
    arm.fit("file/out", &[]).refused(&["file: this is a file"]);
    assert_eq!(arm.bytes("", "file"), b"");
}

/// Nobody may make a folder there, not even root.
#[cfg(target_os = "linux")]
#[test]
fn a_place_that_is_read_only_is_told_before_anything_is_computed() {
    let arm = Arm::new();
    let mut arguments = arm.fit_arguments("out");
    let out = arguments.iter().position(|a| a == "--out").expect("--out") + 1;
    arguments[out] = "/proc/maquette/out".into();
    // the fault is OUT, and not the recording, which is read after it
    fs::remove_dir_all(arm.recording().join("masks")).expect("removed");
    run(&arguments).refused(&["/proc/maquette", "cannot be written"]);
}

#[test]
fn arguments_that_make_no_sense() {
    let recording = Arm::new();
    let path = recording.recording().display().to_string();
    for (arguments, part) in [
        (&["fit"][..], "--out <OUT>"),
        (&["fitt"], "unrecognized subcommand 'fitt'; tip: a similar subcommand exists: 'fit'"),
        (&["fit", &path, "--out", "x", "--keyframe-evry", "3"], "'--keyframe-every'"),
        (&["fit", &path, "--out", "x", "--fps", "fast"], "invalid value 'fast' for '--fps <FPS>'"),
        (&["fit", &path, "--out", "x", "--likelihood", "best"], "'best'"),
        (&["fit", &path, "--out", "x", "--frames", "7:3"], "expected FIRST:LAST"),
        (&["fit", &path, "--out", "x", "--resume", "--overwrite"], "cannot be used with"),
        (&["fit", &path, "--out", "x", "--fps", "10", "--frames", "90:99"], "it has 0 to 5"),
        (
            &["fit", &path, "--out", "x", "--fps", "10", "--keyframe-every", "0"],
            "keyframe_every = 0",
        ),
        (&["fit", "no/where", "--out", "x"], "no/where: no such folder or file"),
        (&["fit", &path, "--out", "x"], "the frame rate is not known: give --fps"),
    ] {
        run(arguments).refused(&[part]);
    }
}
