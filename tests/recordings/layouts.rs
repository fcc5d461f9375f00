//! Good recordings of every layout.

use std::fs;

use image::{DynamicImage, GrayImage, Luma, Rgba, RgbaImage};
use maquette::io::recording::{Note, Recording};
use maquette::silhouette::{FrameIndex, Rejected, SilhouetteOptions};

use crate::tiny::{
    SIZE, assert_complains, calibration, is_person, load, mask, open, recording, save,
    with_manifest, write,
};

#[test]
fn a_folder_with_calibration_and_masks_needs_no_manifest() {
    let folder = recording(&["a", "b"]);
    let recording = open(folder.path()).expect("a recording");
    assert_eq!(recording.rig.names().collect::<Vec<_>>(), ["a", "b"]);
    assert_eq!(recording.frames, [0, 1, 2].map(FrameIndex));
    assert_eq!((recording.fps, recording.missing.len(), recording.notes.len()), (50.0, 0, 0));
    let frame = recording.load_frame(2, &SilhouetteOptions::default()).expect("a frame");
    assert_eq!((frame.frame, frame.views.len(), frame.rejected.len()), (FrameIndex(2), 2, 0));
    approx::assert_relative_eq!(frame.views[0].1.area_px, 600.0, max_relative = 0.02);
}

#[test]
fn a_manifest_is_followed() {
    let folder = with_manifest(
        &["a", "b", "c", "d"],
        "fps = 25\ncalibration = \"calibration.toml\"\nbody = \"arm-2d\"\n\
         [[camera]]\nname = \"d\"\nmasks = \"masks/d/%06d.png\"\noffset_frames = 1\n\
         [[camera]]\nname = \"a\"\nmasks = \"masks/a/*.png\"\n\
         [[camera]]\nname = \"b\"\nmasks = \"masks/b\"\nvideo = \"b.avi\"\n\
         [[camera]]\nname = \"c\"\nvideo = \"c.avi\"\n",
    );
    for path in [folder.path().to_owned(), folder.path().join("sequence.toml")] {
        let recording =
            Recording::open(&path).and_then(|found| found.observations()).expect("a recording");
        assert_eq!(recording.rig.names().collect::<Vec<_>>(), ["d", "a", "b"]);
        approx::assert_relative_eq!(recording.fps, 25.0);
        let body = Recording::open(&path).expect("a recording");
        assert_eq!(body.body(), Some("arm-2d"));
        assert_eq!(recording.frames, [0, 1, 2, 3].map(FrameIndex));
        let missing: Vec<_> =
            recording.missing.iter().map(|m| (m.camera.as_str(), m.frames.clone())).collect();
        let expected =
            [("d", 0), ("a", 3), ("b", 3)].map(|(camera, frame)| (camera, vec![FrameIndex(frame)]));
        assert_eq!(missing, expected);
        let notes: Vec<_> = recording.notes.iter().map(ToString::to_string).collect();
        let expected = [
            "video: not used, because there are masks",
            "camera c: no masks in the manifest: not used",
        ];
        assert_eq!(notes, expected);
        let first = recording.load_frame(0, &SilhouetteOptions::default()).expect("a frame");
        assert_eq!(first.views.iter().map(|(id, _)| id.0).collect::<Vec<_>>(), [1, 2]);
    }
    let faster = Recording::open(folder.path())
        .and_then(|found| found.with_fps(100.0).observations())
        .expect("a recording");
    approx::assert_relative_eq!(faster.fps, 100.0);
}

#[test]
fn a_manifest_without_cameras_takes_the_folders() {
    let folder = with_manifest(&["a", "b"], "fps = 25\n");
    let recording =
        Recording::open(folder.path()).and_then(|found| found.observations()).expect("a recording");
    assert_eq!(recording.rig.cameras.len(), 2);
}

#[test]
fn one_calibration_file_for_each_camera() {
    let folder =
        with_manifest(&["a", "b"], "fps = 25\ncalibration = { a = \"a.toml\", b = \"b.toml\" }\n");
    write(folder.path().join("a.toml"), calibration(&["a"]));
    write(folder.path().join("b.toml"), calibration(&["b"]));
    let recording =
        Recording::open(folder.path()).and_then(|found| found.observations()).expect("a recording");
    assert_eq!(recording.rig.names().collect::<Vec<_>>(), ["a", "b"]);
    let inputs: Vec<_> =
        recording.checksums().expect("checksums").into_iter().map(|c| c.input).collect();
    assert_eq!(inputs, ["sequence.toml", "a.toml", "b.toml", "masks of a", "masks of b"]);
}

#[test]
fn odd_files_are_passed_over_and_told() {
    let folder = recording(&["a", "b", "c"]);
    let masks = folder.path().join("masks");
    write(masks.join("a/readme.txt"), "7");
    write(masks.join("a/._000009.png"), "");
    save(masks.join("a/mean.png"), &mask());
    save(masks.join("cc/000000.png"), &mask());
    fs::remove_dir_all(masks.join("c")).expect("removed");
    let recording = open(folder.path()).expect("a recording");
    assert_eq!(recording.frames.len(), 3);
    let expected = [
        Note::Uncalibrated { camera: "cc".into(), nearest: "c".into() },
        Note::Unmasked { cameras: vec!["c".into()] },
        Note::Unnumbered { camera: "a".into(), files: 1 },
    ];
    assert_eq!(recording.notes, expected);
}

#[test]
fn frames_that_never_meet_are_told() {
    let manifest = "[[camera]]\nname = \"a\"\nmasks = \"masks/a\"\noffset_frames = -1\n\
                    [[camera]]\nname = \"b\"\nmasks = \"masks/b\"\noffset_frames = 100\n";
    let folder = with_manifest(&["a", "b"], manifest);
    let notes = open(folder.path()).expect("a recording").notes;
    assert_eq!(notes, [Note::BeforeFirst { camera: "a".into(), files: 1 }, Note::NoCommonFrame]);
}

#[test]
fn masks_of_every_format_and_depth_are_the_same_mask() {
    let folder = recording(&["a", "b"]);
    let cut_out = RgbaImage::from_fn(SIZE.0, SIZE.1, |x, y| {
        Rgba([30, 20, 10, if is_person(x, y) { 255 } else { 0 }])
    });
    let (deep, rgb, rgba) = (mask().into_luma16(), mask().into_rgb8(), mask().into_rgba8());
    let deep_rgb = mask().into_rgb16();
    let pictures: Vec<(&str, DynamicImage)> = vec![
        ("0.bmp", mask()),
        ("1.jpg", mask()),
        ("2.tif", deep.clone().into()),
        ("3.png", deep.into()),
        ("4.png", rgb.into()),
        ("5.png", rgba.into()),
        ("6.png", cut_out.into()),
        ("7.pgm", mask()),
        ("8.webp", mask().into_rgb8().into()),
        ("9.png", deep_rgb.into()),
    ];
    fs::remove_dir_all(folder.path().join("masks/a")).expect("removed");
    for (name, picture) in &pictures {
        save(folder.path().join("masks/a").join(name), picture);
    }
    let recording = open(folder.path()).expect("a recording");
    for (position, (name, _)) in pictures.iter().enumerate() {
        let frame = recording.load_frame(position, &SilhouetteOptions::default()).expect(name);
        approx::assert_relative_eq!(frame.views[0].1.area_px, 600.0, max_relative = 0.02);
    }
}

#[test]
fn a_mask_without_a_person_is_listed_and_the_others_are_used() {
    let folder = recording(&["a", "b"]);
    let grey = |value| DynamicImage::from(GrayImage::from_pixel(SIZE.0, SIZE.1, Luma([value])));
    save(folder.path().join("masks/a/000000.png"), &grey(0));
    save(folder.path().join("masks/a/000001.png"), &grey(255));
    let rejected = |position| {
        let frame = load(folder.path(), position).expect("a frame");
        assert_eq!(frame.views.len(), 1);
        frame.rejected[0].1
    };
    assert_eq!(rejected(0), Rejected::Empty);
    assert!(matches!(rejected(1), Rejected::Full { .. }));
}

#[test]
fn a_calibration_without_image_size_takes_that_of_the_masks() {
    let folder = recording(&["a", "b"]);
    fs::remove_file(folder.path().join("calibration.toml")).expect("removed");
    let matrix = |name: &str, rows, columns, data: &str| {
        format!(
            "{name}: !!opencv-matrix\n  rows: {rows}\n  cols: {columns}\n  dt: d\n  data: [{data}]\n"
        )
    };
    let (mut intrinsic, mut extrinsic) = (String::new(), String::new());
    for camera in ["a", "b"] {
        let k = "60., 0., 31.5, 0., 60., 23.5, 0., 0., 1.";
        intrinsic += &matrix(&format!("K_{camera}"), 3, 3, k);
        intrinsic += &matrix(&format!("dist_{camera}"), 1, 5, "0., 0., 0., 0., 0.");
        extrinsic += &matrix(&format!("R_{camera}"), 3, 1, "1.2, 1.2, -1.2");
        extrinsic += &matrix(&format!("T_{camera}"), 3, 1, "0., 0., 4.");
    }
    let head = "%YAML:1.0\n---\nnames:\n  - \"a\"\n  - \"b\"\n";
    write(folder.path().join("intri.yml"), format!("{head}{intrinsic}"));
    write(folder.path().join("extri.yml"), format!("{head}{extrinsic}"));
    let recording = open(folder.path()).expect("a recording");
    let camera = &recording.rig.cameras[1];
    assert_eq!((camera.width_px, camera.height_px), SIZE);
    assert_eq!(
        recording.load_frame(0, &SilhouetteOptions::default()).expect("a frame").views.len(),
        2
    );
    let inputs: Vec<_> =
        recording.checksums().expect("checksums").into_iter().map(|c| c.input).collect();
    assert_eq!(inputs[..2], ["extri.yml", "intri.yml"]);
}

#[test]
fn checksums_change_with_the_input_and_only_then() {
    let folder = recording(&["a", "b"]);
    let checksums = || open(folder.path()).and_then(|r| r.checksums()).expect("checksums");
    let before = checksums();
    assert_eq!(before, checksums());
    assert_eq!(before.iter().map(|c| c.files).collect::<Vec<_>>(), [1, 3, 3]);
    save(folder.path().join("masks/b/000002.png"), &mask().rotate180());
    let after = checksums();
    assert_eq!(before[..2], after[..2]);
    assert_ne!(before[2], after[2]);
}

/// An EasyMocap calibration in which one camera has a lens only.
fn easymocap(cameras: &[&str], posed: &[&str]) -> [(&'static str, String); 2] {
    let head = "%YAML:1.0\n---\n";
    let names = |of: &[&str]| {
        let lines: String = of.iter().map(|name| format!("   - \"{name}\"\n")).collect();
        format!("names:\n{lines}")
    };
    let matrix = |key: &str, [rows, cols]: [usize; 2], data: &str| {
        format!(
            "{key}: !!opencv-matrix\n   rows: {rows}\n   cols: {cols}\n   dt: d\n   data: [ {data} ]\n"
        )
    };
    let lens = |name: &&str| {
        matrix(&format!("K_{name}"), [3, 3], "60., 0., 31.5, 0., 60., 23.5, 0., 0., 1.")
            + &matrix(&format!("dist_{name}"), [1, 5], "0., 0., 0., 0., 0.")
    };
    let pose = |name: &&str| {
        matrix(&format!("R_{name}"), [3, 1], "1.2, 1.2, -1.2")
            + &matrix(&format!("T_{name}"), [3, 1], "0., 0., 4.")
    };
    let lenses: String = cameras.iter().map(lens).collect();
    let poses: String = posed.iter().map(pose).collect();
    [
        ("intri.yml", format!("{head}{}{lenses}", names(cameras))),
        ("extri.yml", format!("{head}{}{poses}", names(posed))),
    ]
}

#[test]
fn of_easymocaps_cameras_those_with_lens_and_pose_are_used_and_the_others_named() {
    let folder = recording(&["01", "02"]);
    std::fs::remove_file(folder.path().join("calibration.toml")).expect("removed");
    for (name, text) in easymocap(&["01", "02", "03"], &["01", "02"]) {
        write(folder.path().join(name), text);
    }
    let found = open(folder.path()).expect("a recording");
    assert_eq!(found.rig.names().collect::<Vec<_>>(), ["01", "02"]);
    let notes: Vec<String> = found.notes.iter().map(ToString::to_string).collect();
    assert!(
        notes.iter().any(|note| note.contains("intri.yml") && note.contains("03")),
        "{notes:?}"
    );
}

#[test]
fn a_trial_finds_the_calibration_of_its_session() {
    let session = tempfile::tempdir().expect("a folder");
    let trial = recording(&["a", "b"]);
    let calibration = std::fs::read(trial.path().join("calibration.toml")).expect("read");
    write(session.path().join("calibration/Calib_scene.toml"), calibration);
    write(session.path().join("Trial_1/Config.toml"), "");
    std::fs::rename(trial.path().join("masks"), session.path().join("Trial_1/masks"))
        .expect("moved");
    let found = open(&session.path().join("Trial_1")).expect("a recording");
    assert_eq!(found.rig.cameras.len(), 2);
    let notes: Vec<String> = found.notes.iter().map(ToString::to_string).collect();
    assert!(notes[0].contains("calibration: read from"), "{notes:?}");
}

#[test]
fn masks_that_are_named_otherwise_get_the_lines_to_write() {
    let folder = recording(&["left", "right"]);
    write(folder.path().join("calibration.toml"), calibration(&["north", "south"]));
    let lines = "camera = [{ name = \"north\", masks = \"masks/left\" }, { name = \"south\", masks = \"masks/right\" }]";
    assert_complains(open(folder.path()), &["left, right", "north, south", lines]);
    // which are what a manifest may hold
    write(folder.path().join("sequence.toml"), lines);
    assert_eq!(open(folder.path()).expect("a recording").rig.cameras.len(), 2);
}

#[test]
fn numbers_name_cameras_and_one_instant_needs_no_clock() {
    let folder = recording(&["cam_0", "cam_1"]);
    let text = calibration(&["0", "1"]).replace('[', "[cameras.").replace("= [cameras.", "= [");
    let text = text.replace("[[cameras.", "[[").replace(", [cameras.", ", [");
    write(folder.path().join("calibration.toml"), text);
    assert_eq!(
        open(folder.path()).expect("a recording").rig.names().collect::<Vec<_>>(),
        ["0", "1"]
    );

    let without_fps = || Recording::open(folder.path()).and_then(|found| found.observations());
    assert_complains(without_fps(), &["frame rate"]);
    for camera in ["cam_0", "cam_1"] {
        for frame in 1..3 {
            let mask = folder.path().join(format!("masks/{camera}/{frame:06}.png"));
            std::fs::remove_file(mask).expect("removed");
        }
    }
    assert_eq!(without_fps().expect("one instant").frames.len(), 1);
}

#[test]
fn videos_elsewhere_are_shown_as_the_cameras_of_a_manifest() {
    let folder = tempfile::tempdir().expect("a folder");
    for camera in ["Cam0", "Cam1"] {
        for trial in ["walk1", "walk2", "walk3"] {
            write(
                folder.path().join(format!("Videos/{camera}/InputMedia/{trial}/{trial}.mov")),
                "a video",
            );
        }
        write(
            folder.path().join(format!("Videos/{camera}/cameraIntrinsicsExtrinsics.pickle")),
            "a pickle",
        );
    }
    let said = || open(folder.path()).map(|_| ()).expect_err("nothing to be fitted").to_string();
    let opencap = said();
    for part in [
        "are not read: convert them to calibration.toml with Pose2Sim, and write [[camera]] into sequence.toml",
        r#"{ name = "cam_01", video = "Videos/Cam1/InputMedia/walk1/walk1.mov" }"#,
    ] {
        assert!(opencap.contains(part), "{part} not in {opencap}");
    }

    // what is shown is what a manifest may hold
    let cameras = opencap.split("here in one line: ").nth(1).expect("the cameras");
    write(folder.path().join("sequence.toml"), cameras);
    Recording::open(folder.path()).expect("a manifest");

    // no pickle: the cameras have the names of their folders
    fs::remove_file(folder.path().join("sequence.toml")).expect("removed");
    for camera in ["Cam0", "Cam1"] {
        let pickle = format!("Videos/{camera}/cameraIntrinsicsExtrinsics.pickle");
        fs::remove_file(folder.path().join(pickle)).expect("removed");
    }
    let others = said();
    assert!(
        others.contains(r#"name = "Cam1", video = "Videos/Cam1"#) && !others.contains("pickle"),
        "{others}"
    );
}
