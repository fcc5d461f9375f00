//! Recordings on disk: good ones of every layout, and each way to be bad.

use std::fs;
use std::path::{Path, PathBuf};

use image::{DynamicImage, GrayImage, ImageFormat, Luma, Rgba, RgbaImage};
use maquette::io::recording::{Note, Recording, RecordingError};
use maquette::silhouette::{FrameIndex, FrameObservations, Rejected, SilhouetteOptions};
use tempfile::TempDir;

const SIZE: (u32, u32) = (64, 48);

fn is_person(x: u32, y: u32) -> bool {
    (20..40).contains(&x) && (10..40).contains(&y)
}

fn mask() -> DynamicImage {
    GrayImage::from_fn(SIZE.0, SIZE.1, |x, y| {
        Luma([if is_person(x, y) { 255 } else { 0 }])
    })
    .into()
}

fn write(path: PathBuf, bytes: impl AsRef<[u8]>) {
    fs::create_dir_all(path.parent().expect("a parent")).expect("a folder");
    fs::write(path, bytes).expect("a file");
}

fn save(path: PathBuf, image: &DynamicImage) {
    fs::create_dir_all(path.parent().expect("a parent")).expect("a folder");
    image.save(path).expect("an image");
}

fn calibration(cameras: &[&str]) -> String {
    let camera = |name: &&str| {
        format!(
            "[{name}]\nname = \"{name}\"\nsize = [64.0, 48.0]\n\
             matrix = [[60.0, 0.0, 31.5], [0.0, 60.0, 23.5], [0.0, 0.0, 1.0]]\n\
             distortions = [0.0, 0.0, 0.0, 0.0]\nrotation = [1.2, 1.2, -1.2]\n\
             translation = [0.0, 0.0, 4.0]\nfisheye = false\n"
        )
    };
    cameras.iter().map(camera).collect()
}

/// `calibration.toml` and three frames of masks for each camera, without manifest.
fn recording(cameras: &[&str]) -> TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    write(folder.path().join("calibration.toml"), calibration(cameras));
    for camera in cameras {
        for frame in 0..3 {
            save(
                folder.path().join(format!("masks/{camera}/{frame:06}.png")),
                &mask(),
            );
        }
    }
    folder
}

fn with_manifest(cameras: &[&str], manifest: &str) -> TempDir {
    let folder = recording(cameras);
    write(folder.path().join("sequence.toml"), manifest);
    folder
}

fn open(folder: &Path) -> Result<Recording, RecordingError> {
    Recording::open(folder, Some(50.0))
}

fn load(folder: &Path, position: usize) -> Result<FrameObservations, RecordingError> {
    open(folder)?.load_frame(position, &SilhouetteOptions::default())
}

/// The one line that says what is wrong.
fn complaint<T>(result: Result<T, RecordingError>) -> String {
    let Err(error) = result else {
        panic!("expected an error");
    };
    let message = error.to_string();
    assert!(!message.contains('\n'), "{message}");
    message
}

fn assert_complains<T>(result: Result<T, RecordingError>, parts: &[&str]) {
    let message = complaint(result);
    for part in parts {
        assert!(message.contains(part), "{part:?} is not in {message:?}");
    }
}

#[test]
fn a_folder_with_calibration_and_masks_needs_no_manifest() {
    let folder = recording(&["a", "b"]);
    let recording = open(folder.path()).expect("a recording");
    assert_eq!(recording.rig.names().collect::<Vec<_>>(), ["a", "b"]);
    assert_eq!(recording.frames, [0, 1, 2].map(FrameIndex));
    assert_eq!(
        (
            recording.fps,
            recording.missing.len(),
            recording.notes.len()
        ),
        (50.0, 0, 0)
    );
    let frame = recording
        .load_frame(2, &SilhouetteOptions::default())
        .expect("a frame");
    assert_eq!(
        (frame.frame, frame.views.len(), frame.rejected.len()),
        (FrameIndex(2), 2, 0)
    );
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
    for path in [
        folder.path().to_owned(),
        folder.path().join("sequence.toml"),
    ] {
        let recording = Recording::open(&path, None).expect("a recording");
        assert_eq!(recording.rig.names().collect::<Vec<_>>(), ["d", "a", "b"]);
        assert_eq!(recording.fps, 25.0);
        assert_eq!(recording.body.as_deref(), Some("arm-2d"));
        assert_eq!(recording.frames, [0, 1, 2, 3].map(FrameIndex));
        let missing: Vec<_> = recording
            .missing
            .iter()
            .map(|m| (m.camera.0, m.frames.clone()))
            .collect();
        let expected =
            [(0, 0), (1, 3), (2, 3)].map(|(camera, frame)| (camera, vec![FrameIndex(frame)]));
        assert_eq!(missing, expected);
        let notes: Vec<_> = recording.notes.iter().map(ToString::to_string).collect();
        let expected = [
            "video: not used, the masks are",
            "camera c: no masks in the manifest: not used",
        ];
        assert_eq!(notes, expected);
        let first = recording
            .load_frame(0, &SilhouetteOptions::default())
            .expect("a frame");
        assert_eq!(
            first.views.iter().map(|(id, _)| id.0).collect::<Vec<_>>(),
            [1, 2]
        );
    }
    let faster = Recording::open(folder.path(), Some(100.0)).expect("a recording");
    assert_eq!(faster.fps, 100.0);
}

#[test]
fn a_manifest_without_cameras_takes_the_folders() {
    let folder = with_manifest(&["a", "b"], "fps = 25\n");
    let recording = Recording::open(folder.path(), None).expect("a recording");
    assert_eq!(recording.rig.cameras.len(), 2);
}

#[test]
fn one_calibration_file_for_each_camera() {
    let folder = with_manifest(
        &["a", "b"],
        "fps = 25\ncalibration = { a = \"a.toml\", b = \"b.toml\" }\n",
    );
    write(folder.path().join("a.toml"), calibration(&["a"]));
    write(folder.path().join("b.toml"), calibration(&["b"]));
    let recording = Recording::open(folder.path(), None).expect("a recording");
    assert_eq!(recording.rig.names().collect::<Vec<_>>(), ["a", "b"]);
    let inputs: Vec<_> = recording
        .checksums()
        .expect("checksums")
        .into_iter()
        .map(|c| c.input)
        .collect();
    assert_eq!(
        inputs,
        [
            "sequence.toml",
            "a.toml",
            "b.toml",
            "masks of a",
            "masks of b"
        ]
    );
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
        Note::Uncalibrated {
            camera: "cc".into(),
            nearest: "c".into(),
        },
        Note::Unmasked {
            cameras: vec!["c".into()],
        },
        Note::Unnumbered {
            camera: "a".into(),
            files: 1,
        },
    ];
    assert_eq!(recording.notes, expected);
}

#[test]
fn frames_that_never_meet_are_told() {
    let manifest = "[[camera]]\nname = \"a\"\nmasks = \"masks/a\"\noffset_frames = -1\n\
                    [[camera]]\nname = \"b\"\nmasks = \"masks/b\"\noffset_frames = 100\n";
    let folder = with_manifest(&["a", "b"], manifest);
    let notes = open(folder.path()).expect("a recording").notes;
    assert_eq!(
        notes,
        [
            Note::BeforeFirst {
                camera: "a".into(),
                files: 1
            },
            Note::NoCommonFrame
        ]
    );
}

#[test]
fn masks_of_every_format_and_depth_are_the_same_mask() {
    let folder = recording(&["a", "b"]);
    let cut_out = RgbaImage::from_fn(SIZE.0, SIZE.1, |x, y| {
        Rgba([30, 20, 10, if is_person(x, y) { 255 } else { 0 }])
    });
    let (deep, rgb, rgba) = (
        mask().into_luma16(),
        mask().into_rgb8(),
        mask().into_rgba8(),
    );
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
        let frame = recording
            .load_frame(position, &SilhouetteOptions::default())
            .expect(name);
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
fn a_missing_recording_is_named() {
    assert_complains(
        open(Path::new("no/where")),
        &["no/where: no such folder or file"],
    );
    let empty = tempfile::tempdir().expect("a folder");
    assert_complains(open(empty.path()), &["no masks: expected masks/<camera>/"]);
    let folder = recording(&["a", "b"]);
    fs::remove_file(folder.path().join("calibration.toml")).expect("removed");
    assert!(matches!(
        open(folder.path()),
        Err(RecordingError::Calibration(_))
    ));
}

#[test]
fn a_frame_rate_must_be_known_and_positive() {
    let folder = recording(&["a", "b"]);
    assert_complains(
        Recording::open(folder.path(), None),
        &["frame rate is not known", "--fps"],
    );
    for fps in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert_complains(
            Recording::open(folder.path(), Some(fps)),
            &["expected a positive number"],
        );
    }
    let folder = with_manifest(&["a", "b"], "fps = 0\n");
    assert_complains(
        Recording::open(folder.path(), None),
        &["sequence.toml:1: fps = 0"],
    );
}

#[test]
fn video_alone_is_not_enough() {
    let folder = with_manifest(&["a", "b"], "[[camera]]\nname = \"a\"\nvideo = \"a.avi\"\n");
    assert_complains(
        open(folder.path()),
        &[
            "no masks",
            "; a have none: images and video must be segmented first",
        ],
    );
}

#[test]
fn cameras_must_be_calibrated_distinct_and_more_than_one() {
    let two = |a: &str, b: &str| {
        let camera = |name| format!("[[camera]]\nname = \"{name}\"\nmasks = \"masks/a\"\n");
        with_manifest(&["a", "b"], &(camera(a) + &camera(b)))
    };
    let folder = two("a", "z");
    assert_complains(open(folder.path()), &["no camera \"z\"", "it has a, b"]);
    let folder = two("a", "a");
    assert_complains(open(folder.path()), &["camera \"a\" is listed 2 times"]);
    let folder = recording(&["a"]);
    assert_complains(
        open(folder.path()),
        &["one camera only (a)", "cannot be told apart"],
    );
    let folder = recording(&["a", "b"]);
    write(
        folder.path().join("calibration.toml"),
        calibration(&["c", "d"]),
    );
    assert_complains(open(folder.path()), &["no camera \"a\"", "it has c, d"]);
}

#[test]
fn masks_that_are_not_there_are_named() {
    let folder = with_manifest(
        &["a", "b"],
        "[[camera]]\nname = \"a\"\nmasks = \"masks/a/%04d.jpg\"\n[[camera]]\nname = \"b\"\nmasks = \"masks/b\"\n",
    );
    assert_complains(
        open(folder.path()),
        &["camera a: no mask at", "masks/a/%04d.jpg"],
    );
    let manifest = folder.path().join("sequence.toml");
    for (pattern, part) in [
        ("nowhere/%06d.png", "nowhere: the folder cannot be read"),
        ("nowhere", "no mask at"),
        ("masks/a/%06x.png", "expected one %d or %06d"),
        ("masks/**a/*.png", "expected a glob"),
    ] {
        write(
            manifest.clone(),
            format!("[[camera]]\nname = \"a\"\nmasks = \"{pattern}\"\n"),
        );
        assert_complains(open(folder.path()), &[part]);
    }
    let folder = recording(&["a", "b"]);
    save(folder.path().join("masks/a/1.jpg"), &mask());
    assert_complains(
        open(folder.path()),
        &["camera a: ", "000001.png", "1.jpg", "are both number 1"],
    );
}

#[test]
fn a_mask_that_cannot_be_used_is_named_with_camera_and_frame() {
    let folder = recording(&["a", "b"]);
    let path = folder.path().join("masks/b/000001.png");
    let whole = fs::read(&path).expect("a mask");
    let labels = GrayImage::from_fn(SIZE.0, SIZE.1, |x, y| Luma([u8::from(is_person(x, y))]));
    let mut label_bytes = std::io::Cursor::new(Vec::new());
    labels
        .write_to(&mut label_bytes, ImageFormat::Png)
        .expect("an image");
    for (bytes, part) in [
        (whole[..whole.len() / 2].to_vec(), "cannot be decoded"),
        (Vec::new(), "cannot be decoded"),
        (b"not an image".to_vec(), "cannot be decoded"),
        (
            with_size(&whole, 100_000, 100_000),
            "larger than 32768 × 32768 px",
        ),
        (
            with_size(&whole, 640, 480),
            "the mask is 640 × 480 px, expected 64 × 48 px",
        ),
        (with_size(&whole, 0, 48), "cannot be decoded"),
        (
            label_bytes.into_inner(),
            "values are 0 to 1 of 255: these look like labels",
        ),
    ] {
        write(path.clone(), bytes);
        assert_complains(
            load(folder.path(), 1),
            &["masks/b/000001.png: camera b, frame 1: ", part],
        );
        assert_eq!(
            load(folder.path(), 0).expect("another frame").views.len(),
            2
        );
    }
    let recording = open(folder.path()).expect("a recording");
    fs::remove_file(&path).expect("removed");
    let options = SilhouetteOptions::default();
    assert_complains(
        recording.load_frame(1, &options),
        &["camera b, frame 1: the mask cannot be read"],
    );
    assert_complains(
        recording.load_frame(3, &options),
        &["position 3 of a recording of 3"],
    );
}

/// A PNG with another size in its header.
fn with_size(png: &[u8], width: u32, height: u32) -> Vec<u8> {
    let mut png = png.to_vec();
    png[16..20].copy_from_slice(&width.to_be_bytes());
    png[20..24].copy_from_slice(&height.to_be_bytes());
    let sum = png[12..29].iter().fold(u32::MAX, |sum, byte| {
        (0..8).fold(sum ^ u32::from(*byte), |sum, _| {
            (sum >> 1) ^ (0xEDB8_8320 & (sum & 1).wrapping_neg())
        })
    });
    png[29..33].copy_from_slice(&(!sum).to_be_bytes());
    png
}

#[test]
fn checksums_change_with_the_input_and_only_then() {
    let folder = recording(&["a", "b"]);
    let checksums = || {
        open(folder.path())
            .and_then(|r| r.checksums())
            .expect("checksums")
    };
    let before = checksums();
    assert_eq!(before, checksums());
    assert_eq!(
        before.iter().map(|c| c.files).collect::<Vec<_>>(),
        [1, 3, 3]
    );
    save(
        folder.path().join("masks/b/000002.png"),
        &mask().rotate180(),
    );
    let after = checksums();
    assert_eq!(before[..2], after[..2]);
    assert_ne!(before[2], after[2]);
}

/// A set of the shared data; `None`, with a line, where it is absent.
fn shared(set: &str) -> Option<PathBuf> {
    let beside = || Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared");
    let shared = std::env::var_os("MAQUETTE_SHARED").map_or_else(beside, PathBuf::from);
    let folder = shared.join("data").join(set);
    if folder.is_dir() {
        return Some(folder);
    }
    eprintln!("skipped: {} is absent", folder.display());
    None
}

#[test]
fn seven_cameras_are_streamed_in_less_than_two_megabytes_a_frame() {
    for set in ["walk7", "walk7-noisy"] {
        let Some(folder) = shared(set) else { return };
        let recording = open(&folder).expect("a recording");
        assert_eq!(
            (recording.rig.cameras.len(), recording.frames.len()),
            (7, 79)
        );
        assert!(recording.missing.is_empty() && recording.notes.is_empty());
        for position in (0..79).step_by(13) {
            let frame = recording
                .load_frame(position, &SilhouetteOptions::default())
                .expect("a frame");
            assert_eq!(frame.views.len(), 7);
            let bytes: usize = frame
                .views
                .iter()
                .map(|(_, silhouette)| silhouette.heap_bytes())
                .sum();
            assert!(bytes < 2_000_000, "{bytes}");
        }
    }
}

#[test]
fn noise_moves_silhouettes_by_little() {
    let (Some(clean), Some(noisy)) = (shared("walk7"), shared("walk7-noisy")) else {
        return;
    };
    let (clean, noisy) = (
        load(&clean, 42).expect("a frame"),
        load(&noisy, 42).expect("a frame"),
    );
    for ((_, clean), (_, noisy)) in clean.views.iter().zip(&noisy.views) {
        approx::assert_relative_eq!(clean.bounds.0, noisy.bounds.0, epsilon = 6.0);
        approx::assert_relative_eq!(clean.bounds.1, noisy.bounds.1, epsilon = 6.0);
        let overlap = clean.overlap(noisy.bounds, |pixel| noisy.contains(pixel));
        assert!(overlap.iou() > 0.85, "{overlap:?}");
    }
}

#[test]
fn a_recording_with_video_and_masks_says_that_the_video_is_not_used() {
    let Some(folder) = shared("balance") else {
        return;
    };
    let recording = Recording::open(&folder, None).expect("a recording");
    assert_eq!((recording.fps, recording.frames.len()), (60.0, 100));
    assert_eq!(
        recording.notes,
        [Note::Ignored {
            keys: vec!["video"]
        }]
    );
    let frame = recording
        .load_frame(50, &SilhouetteOptions::default())
        .expect("a frame");
    assert_eq!(frame.views.len(), 4);
}
