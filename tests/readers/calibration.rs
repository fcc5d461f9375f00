//! Every calibration format gives the same two cameras.

use crate::calibration_samples::*;
use maquette::camera::{Distortion, UpAxis, check_projection};
use maquette::io::calibration::{
    CalibrationOptions, Poses, Unit, read, read_per_camera, select, write_toml,
};
use maquette::math::Rigid3;
use nalgebra::Point3;
use std::fs;
use std::path::Path;

fn defaults() -> CalibrationOptions {
    CalibrationOptions::default()
}

#[test]
fn lenses_without_poses_are_read_where_these_are_not_wanted_and_refused_else() {
    let is_pose = |line: &str| line.starts_with("rotation") || line.starts_with("translation");
    let lines = POSE2SIM.lines().map(str::trim_start).filter(|line| !is_pose(line));
    let lenses: String = lines.map(|line| format!("{line}\n")).collect();
    let ignored = CalibrationOptions { poses: Poses::Ignored, ..defaults() };
    for text in [lenses.as_str(), POSE2SIM] {
        let rig = read_text("Calib_scene.toml", text, &ignored).unwrap();
        assert!(rig.cameras.iter().all(|c| c.camera_from_world == Rigid3::identity()));
        assert_eq!(rig.cameras[0].intrinsics, expected(lens()).cameras[0].intrinsics);
    }
    let fault = read_text("Calib_scene.toml", &lenses, &defaults()).unwrap_err().to_string();
    assert!(fault.contains("rotation and translation are missing"), "{fault}");
}

#[test]
fn pose2sim_gives_the_two_cameras() {
    let rig = read_text("Calib_scene.toml", POSE2SIM, &defaults()).unwrap();
    assert_same(&rig, &expected(lens()));
}

#[test]
fn caliscope_gives_the_two_cameras_and_leaves_out_ignored_and_unposed_ones() {
    let rig = read_text("camera_array.toml", CALISCOPE, &defaults()).unwrap();
    assert_same(&rig, &expected(lens()));
}

#[test]
fn freemocap_is_in_millimetres_by_itself() {
    let rig = read_text("calibration.toml", FREEMOCAP, &defaults()).unwrap();
    assert_same(&rig, &expected(lens()));
}

#[test]
fn a_unit_that_is_given_wins_over_the_formats_own() {
    let in_metres = CalibrationOptions { unit: Some(Unit::Metre), ..defaults() };
    let rig = read_text("calibration.toml", FREEMOCAP, &in_metres).unwrap();
    let centre = rig.cameras[0].centre_world();
    approx::assert_relative_eq!(centre, Point3::new(3e3, -2e3, 1.5e3), epsilon = 1e-6);
}

#[test]
fn easymocap_gives_the_two_cameras_by_either_file_or_the_folder() {
    let folder = folder(&[("intri.yml", INTRI), ("extri.yml", EXTRI)]);
    for path in ["", "intri.yml", "extri.yml"] {
        let rig = read(&folder.path().join(path), &defaults()).unwrap();
        assert_same(&rig, &expected(lens()));
    }
}

#[test]
fn one_opencv_yaml_may_hold_all_cameras() {
    let extrinsics = EXTRI.split_once("cam2\"\r\n").unwrap().1;
    let rig = read_text("rig.yaml", &format!("{INTRI}{extrinsics}"), &defaults()).unwrap();
    assert_same(&rig, &expected(lens()));
}

#[test]
fn opencv_xml_per_camera_gives_the_two_cameras() {
    let folder = folder(&[("a.xml", XML[0]), ("b.xml", XML[1])]);
    let files = [("cam1", "a.xml"), ("cam2", "b.xml")]
        .map(|(name, file)| (name.to_owned(), folder.path().join(file)));
    let options = CalibrationOptions { unit: Some(Unit::Millimetre), ..with_sizes() };
    assert_same(&read_per_camera(&files, &options).unwrap(), &expected(lens()));
}

#[test]
fn qualisys_gives_the_two_cameras() {
    let rig = read_text("Calib.qca.txt", QUALISYS, &defaults()).unwrap();
    assert_same(&rig, &expected(lens()));
}

#[test]
fn vicon_gives_the_two_cameras() {
    let rig = read_text("session.xcp", VICON, &with_sizes()).unwrap();
    assert_same(&rig, &expected(Distortion::None));
}

#[test]
fn vicon_without_a_given_size_takes_the_whole_sensor() {
    let rig = read_text("session.xcp", VICON, &defaults()).unwrap();
    let camera = &rig.cameras[0];
    assert_eq!((camera.width_px, camera.height_px), (1000, 800));
    assert_eq!((camera.intrinsics.cx_px, camera.intrinsics.cy_px), (502.5, 397.25));
}

#[test]
fn vicons_lens_corrects_in_pixels() {
    let text =
        VICON.replace("ViconRadial2 502.5 397.25 0 0 0", "ViconRadial2 512.5 397.25 3e-8 -2e-14 0");
    let rig = read_text("session.xcp", &text, &defaults()).unwrap();
    let camera = &rig.cameras[0];
    let pixel = nalgebra::Point2::new(812.5, 397.25);
    let undistorted = camera.undistort(&pixel).unwrap();
    // 300 px right of the centre: 300·(1 + 3e-8·300² − 2e-14·300⁴) further
    let expected_px = 512.5 + 300.0 * (1.0 + 2.7e-3 - 1.62e-4);
    approx::assert_relative_eq!(undistorted.x, expected_px, epsilon = 1e-9);
    check_projection(camera, &camera.pixel_grid(21, 17), &[3.0]).unwrap();
}

#[test]
fn vicon_coefficients_too_large_for_pixels_are_opencvs() {
    let text = VICON.replace("502.5 397.25 0 0 0", "502.5 397.25 -0.05 0.14 0.01");
    let rig = read_text("session.xcp", &text, &defaults()).unwrap();
    let expected = Distortion::brown_conrady(&[-0.05, 0.14, 0.0, 0.0, 0.01]);
    assert_eq!(Some(rig.cameras[0].distortion), expected);
}

#[test]
fn projection_matrices_give_the_two_cameras() {
    let rig = read_text("matrices.txt", MATRICES, &defaults()).unwrap();
    assert_same(&rig, &expected(Distortion::None));
}

#[test]
fn a_projection_matrix_per_file_needs_no_name() {
    let (_, matrices) = MATRICES.split_once("cam1\n").unwrap();
    let (first, second) = matrices.split_once("cam2:\n").unwrap();
    let second = format!("CONTOUR\n640 480\n{second}");
    let folder = folder(&[("1.txt", first), ("2.txt", &second)]);
    let files = [("cam1", "1.txt"), ("cam2", "2.txt")]
        .map(|(name, file)| (name.to_owned(), folder.path().join(file)));
    let mut expected = expected(Distortion::None);
    (expected.cameras[1].width_px, expected.cameras[1].height_px) = (640, 480);
    assert_same(&read_per_camera(&files, &with_sizes()).unwrap(), &expected);
}

#[test]
fn a_projection_matrix_may_stand_on_one_line() {
    let lines: Vec<&str> = MATRICES.lines().collect();
    let one = |name: &str, rows: &[&str]| format!("{name}: {}\n", rows.join(" "));
    let text = format!("800 600\n{}{}", one("cam1", &lines[4..7]), one("cam2", &lines[9..12]));
    let rig = read_text("kitti.txt", &text, &defaults()).unwrap();
    assert_same(&rig, &expected(Distortion::None));
}

#[test]
fn one_file_for_all_cameras_serves_as_file_per_camera() {
    let folder = folder(&[("rig.toml", POSE2SIM)]);
    let path = folder.path().join("rig.toml");
    let files = ["cam1", "cam2"].map(|name| (name.to_owned(), path.clone()));
    let rig = read_per_camera(&files, &defaults()).unwrap();
    assert_same(&rig, &expected(lens()));
}

#[test]
fn four_five_and_eight_coefficients_and_fisheye_are_read() {
    let with = |list: &str| {
        let text = POSE2SIM.replace("[ -0.05, 0.14, 0.0006, -0.0007, 0.01]", list);
        read_text("a.toml", &text, &defaults()).unwrap().cameras[0].distortion
    };
    let brown = |k: &[f64]| Distortion::brown_conrady(k).unwrap();
    assert_eq!(with("[]"), Distortion::None);
    assert_eq!(with("[0.1, 0.2, 3e-3, 4e-3]"), brown(&[0.1, 0.2, 3e-3, 4e-3]));
    let eight = [0.1, 0.2, 3e-3, 4e-3, 0.5, 0.6, 0.7, 0.8];
    assert_eq!(with("[0.1, 0.2, 3e-3, 4e-3, 0.5, 0.6, 0.7, 0.8]"), brown(&eight));
    let text = POSE2SIM.replace("fisheye = false", "fisheye = true").replace(", 0.01]", "]");
    let rig = read_text("a.toml", &text, &defaults()).unwrap();
    let fisheye = Distortion::fisheye(&[-0.05, 0.14, 0.0006, -0.0007]);
    assert_eq!(Some(rig.cameras[0].distortion), fisheye);
}

#[test]
fn the_axis_that_points_up_in_the_file_becomes_z() {
    // the same point in the file's world and in ours
    let file_point = Point3::new(0.3, -0.2, 0.9);
    let turned = [
        (UpAxis::Z, Point3::new(0.3, -0.2, 0.9)),
        (UpAxis::MinusZ, Point3::new(0.3, 0.2, -0.9)),
        (UpAxis::Y, Point3::new(0.3, -0.9, -0.2)),
        (UpAxis::MinusY, Point3::new(0.3, 0.9, 0.2)),
    ];
    let pixel = expected(lens()).cameras[0].project(&file_point).unwrap();
    for (up, world_point) in turned {
        let options = CalibrationOptions { up, ..defaults() };
        let rig = read_text("a.toml", POSE2SIM, &options).unwrap();
        let seen = rig.cameras[0].project(&world_point).unwrap();
        assert!((seen - pixel).norm() < 1e-9, "{up:?}: {seen} for {pixel}");
    }
}

#[test]
fn what_is_written_is_read_back() {
    let mut rig = expected(lens());
    rig.cameras[0].name = "left \"1\"".into();
    rig.cameras[0].intrinsics.skew_px = 0.25;
    let lenses = [
        Distortion::None,
        Distortion::brown_conrady(&LENS[..4]).unwrap(),
        Distortion::brown_conrady(&[0.1, 0.2, 3e-3, 4e-3, 0.0, 0.0, 1e-7, 0.0]).unwrap(),
        Distortion::fisheye(&[0.0; 4]).unwrap(),
        Distortion::RadialCorrection {
            centre_x: 0.01,
            centre_y: -0.02,
            k1: 0.03,
            k2: -0.02,
            k3: 0.0,
        },
    ];
    for distortion in lenses {
        rig.cameras[1].distortion = distortion;
        let back = read_text("a.toml", &write_toml(&rig), &defaults()).unwrap();
        let sorted = select(&back, Path::new("a.toml"), &["left \"1\"", "cam2"]).unwrap();
        assert_same(&sorted, &rig);
        assert_eq!(sorted.cameras[1].distortion, distortion);
    }
}

#[test]
fn a_lens_for_which_opencv_has_no_name_is_not_written_as_one() {
    let correction =
        Distortion::RadialCorrection { centre_x: 0.0, centre_y: 0.0, k1: 0.03, k2: 0.0, k3: 0.0 };
    assert!(!write_toml(&expected(correction)).contains("distortions"));
    assert!(write_toml(&expected(lens())).contains("distortions"));
}

#[test]
fn of_a_folder_the_last_toml_by_name_is_read_and_manifests_are_not() {
    let broken = "not TOML";
    let files = [
        ("Calib_2.toml", broken),
        ("Calib_10.toml", POSE2SIM),
        ("Config.toml", broken),
        ("sequence.toml", broken),
        ("Calib.qca.txt", broken),
    ];
    let folder = folder(&files);
    assert_same(&read(folder.path(), &defaults()).unwrap(), &expected(lens()));
    for name in ["Calib_2.toml", "Calib_10.toml"] {
        fs::remove_file(folder.path().join(name)).unwrap();
    }
    fs::write(folder.path().join("Calib.qca.txt"), QUALISYS).unwrap();
    assert_same(&read(folder.path(), &defaults()).unwrap(), &expected(lens()));
}

#[test]
fn a_byte_order_mark_is_passed_over() {
    for (name, text) in [("a.toml", POSE2SIM), ("a.qca.txt", QUALISYS)] {
        let rig = read_text(name, &format!("\u{feff}{text}"), &defaults()).unwrap();
        assert_same(&rig, &expected(lens()));
    }
}

#[test]
fn the_cameras_of_a_manifest_come_in_its_order() {
    let rig = expected(lens());
    let chosen = select(&rig, Path::new("a.toml"), &["cam2", "cam1"]).unwrap();
    assert_eq!(chosen.names().collect::<Vec<_>>(), ["cam2", "cam1"]);
}
