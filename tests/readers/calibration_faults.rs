//! Every wrong calibration gives one line that names file, line, camera, expected and found.

use crate::calibration_fault_tables as tables;
use crate::calibration_samples::*;
use maquette::io::calibration::{CalibrationOptions, read, read_per_camera, select};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::fs;
use std::path::Path;

/// The message, with the folder taken off the path.
fn message(name: &str, text: &str) -> String {
    let folder = folder(&[(name, text)]);
    let error =
        read(&folder.path().join(name), &CalibrationOptions::default()).expect_err("a fault");
    let prefix = format!("{}/", folder.path().display());
    error.to_string().replace(&prefix, "")
}

fn assert_messages(name: &str, text: &str, faults: &[tables::Fault]) {
    for (from, to, expected) in faults {
        assert!(text.contains(from), "the sample has no {from:?}");
        assert_eq!(message(name, &text.replacen(from, to, 1)), *expected);
    }
}

#[test]
fn a_file_that_is_missing_is_named_as_it_was_given() {
    let error = read(Path::new("no/such.toml"), &CalibrationOptions::default()).unwrap_err();
    let message = error.to_string();
    assert!(message.starts_with("cannot read no/such.toml: "), "{message}");
}

#[test]
fn a_folder_without_calibration_says_what_was_looked_for() {
    let folder = folder(&[("notes.md", ""), ("sequence.toml", "")]);
    let error = read(folder.path(), &CalibrationOptions::default()).unwrap_err();
    assert!(error.to_string().contains("no calibration in this folder"));
}

#[test]
fn faults_in_toml_are_named() {
    assert_messages("a.toml", POSE2SIM, tables::TOML);
    let none = "[metadata]\nadjusted = false\n";
    assert_eq!(message("a.toml", none), "a.toml: no calibrated camera in this file");
    assert_eq!(message("a.toml", ""), "a.toml: no calibrated camera in this file");
}

#[test]
fn faults_in_qualisys_files_are_named() {
    assert_messages("a.qca.txt", QUALISYS, tables::QUALISYS);
}

#[test]
fn faults_in_vicon_files_are_named() {
    assert_messages("a.xcp", VICON, tables::VICON);
}

#[test]
fn an_image_larger_than_its_sensor_is_refused() {
    let text = VICON.replace("1000 800", "640 480");
    let error = read_text("a.xcp", &text, &with_sizes()).unwrap_err().to_string();
    let expected = "camera cam1: the image, 800 × 600, is larger than the sensor, 640 × 480";
    assert!(error.ends_with(expected), "{error}");
}

#[test]
fn faults_in_opencv_files_are_named() {
    let error = |intri: &str, extri: &str| {
        let folder = folder(&[("intri.yml", intri), ("extri.yml", extri)]);
        let error = read(folder.path(), &CalibrationOptions::default()).unwrap_err();
        let prefix = format!("{}/", folder.path().display());
        error.to_string().replace(&prefix, "")
    };
    assert_eq!(
        error(&INTRI.replace("K_cam", "k_cam"), EXTRI),
        "intri.yml: camera cam1: K_cam1 is missing"
    );
    assert_eq!(
        error(INTRI, &EXTRI.replace("T_cam1", "t_cam1")),
        "extri.yml: camera cam1: T_cam1 is missing"
    );
    assert_eq!(
        error(INTRI, &EXTRI.replace("-0.996459910140367", "1")),
        "extri.yml:21: camera cam2: Rot_cam2 is not a rotation: |RᵀR − I| = 2.4e-1"
    );
    assert_eq!(
        error(INTRI, &EXTRI.replace("1.5547493448357081, ", "")),
        "extri.yml:6: camera cam1: R_cam1: expected rows × cols numbers, found 2"
    );
    assert_eq!(
        error(&INTRI.replace("W_cam1", "w_cam1"), EXTRI),
        "intri.yml:6: camera cam1: the file does not state the image size, and this camera has no masks, images or video to take it from"
    );
    assert_eq!(message("intri.yml", INTRI), "intri.yml: expected extri.yml beside it");
    assert_eq!(
        message("cam.xml", &XML[0].replace("camera_matrix", "matrix")),
        "cam.xml: camera cam: camera_matrix is missing"
    );
    assert_eq!(
        message("cam.xml", "<svg/>"),
        "cam.xml: expected <opencv_storage>, <Cameras> or <calibration>, found <svg>"
    );
    assert_eq!(
        message("cam.yml", "just text\n"),
        "cam.yml:1: expected key: value, found \"just text\""
    );
}

#[test]
fn faults_in_projection_matrices_are_named() {
    assert_messages("a.txt", MATRICES, tables::MATRICES);
    let nameless = MATRICES.replace("cam1\n", "").replace("cam2:\n", "");
    assert_eq!(
        message("a.txt", &nameless),
        "a.txt:4: the camera's name above its matrix is missing"
    );
}

#[test]
fn formats_that_are_not_read_say_so() {
    assert!(message("Cam0.pickle", "").ends_with("convert it to TOML with Pose2Sim"));
    assert!(
        message("a.json", "{}").starts_with("a.json: unknown calibration format: expected *.toml")
    );
}

#[test]
fn a_camera_that_the_file_lacks_is_named_with_those_it_has() {
    let rig = expected(lens());
    let path = Path::new("a.toml");
    let error = select(&rig, path, &["cam_2"]).unwrap_err().to_string();
    assert_eq!(error, "a.toml: no camera \"cam_2\": it has cam1, cam2; did you mean \"cam2\"?");
    let error = select(&rig, path, &["left"]).unwrap_err().to_string();
    assert_eq!(error, "a.toml: no camera \"left\": it has cam1, cam2");
    let error = select(&rig, path, &["cam1", "cam1"]).unwrap_err().to_string();
    assert_eq!(error, "a.toml: camera cam1: another camera has the same name");
}

#[test]
fn a_file_for_one_camera_may_not_hold_others() {
    let folder = folder(&[("a.toml", POSE2SIM), ("none.toml", "")]);
    let options = CalibrationOptions::default();
    let read = |file: &str| {
        let files = [("left".to_owned(), folder.path().join(file))];
        read_per_camera(&files, &options).unwrap_err().to_string()
    };
    assert!(read("a.toml").ends_with("a.toml: expected one camera, for \"left\", found 2"));
    assert!(read("none.toml").ends_with("none.toml: no calibrated camera in this file"));
    assert!(read_per_camera(&[], &options).is_err());
}

#[test]
fn two_files_for_one_camera_name_are_refused() {
    let folder = folder(&[("a.xml", XML[1])]);
    let path = folder.path().join("a.xml");
    let files = [("cam1".to_owned(), path.clone()), ("cam1".to_owned(), path)];
    let error = read_per_camera(&files, &with_sizes()).unwrap_err().to_string();
    assert!(error.ends_with("camera cam1: another camera has the same name"));
}

/// Cuts and damages every sample; whatever comes out, it is a rig or one line.
#[test]
fn damaged_files_give_a_rig_or_one_line_and_never_a_panic() {
    let samples = [
        ("a.toml", POSE2SIM),
        ("b.toml", CALISCOPE),
        ("a.yml", INTRI),
        ("a.xml", XML[0]),
        ("a.qca.txt", QUALISYS),
        ("a.xcp", VICON),
        ("a.txt", MATRICES),
    ];
    let folder = folder(&[]);
    let mut rng = ChaCha8Rng::seed_from_u64(0x0dd);
    for (name, text) in samples {
        let path = folder.path().join(name);
        for _ in 0..ROUNDS {
            fs::write(&path, damaged(text, &mut rng)).unwrap();
            if let Err(error) = read(&path, &with_sizes()) {
                assert!(!error.to_string().contains('\n'), "{error}");
            }
        }
    }
}

const ROUNDS: usize = 100;

/// The beginning of a text, a few of its bytes replaced by ones with a meaning.
fn damaged(text: &str, rng: &mut ChaCha8Rng) -> Vec<u8> {
    let meaningful = b"\0[]{}<>\"'=:;-.e9\n\xff ";
    let mut bytes = text.as_bytes().to_vec();
    bytes.truncate(rng.random_range(1..=bytes.len()));
    for _ in 0..rng.random_range(0..4) {
        let at = rng.random_range(0..bytes.len());
        bytes[at] = meaningful[rng.random_range(0..meaningful.len())];
    }
    bytes
}

#[test]
fn a_line_of_colons_does_not_exhaust_the_stack() {
    let text = format!("cam1\n{}\n", ":".repeat(1_000_000));
    assert!(read_text("a.txt", &text, &with_sizes()).is_err());
}
