//! The calibrations of the shared data sets, where they are.

use crate::calibration_samples::{assert_same, shared};
use maquette::camera::{Blindness, Camera, Rig, UpAxis, check_projection};
use maquette::io::calibration::{
    CalibrationOptions, Unit, read, read_per_camera, select, write_toml,
};
use nalgebra::Point2;
use std::path::Path;

fn rig(path: &Path) -> Rig {
    read(path, &CalibrationOptions::default()).expect("a sound calibration")
}

fn seated() -> Option<Rig> {
    let folder = shared("seated")?;
    let names = ["cam1", "cam2", "cam3", "cam4"];
    let files = names.map(|name| (name.to_owned(), folder.join(name).join("config.xml")));
    let options = CalibrationOptions {
        unit: Some(Unit::Millimetre),
        up: UpAxis::MinusZ,
        image_sizes_px: names.map(|name| (name.to_owned(), [644, 486])).into(),
        ..CalibrationOptions::default()
    };
    Some(read_per_camera(&files, &options).expect("sound calibrations"))
}

#[test]
fn the_legitimate_rigs_have_a_common_view() {
    let files =
        ["walk7", "balance", "trinocular"].map(|set| shared(&format!("{set}/calibration.toml")));
    let rigs = files.into_iter().flatten().map(|path| rig(&path));
    for rig in rigs.chain(seated()) {
        let view = rig.common_view().unwrap();
        assert!(view.is_complete() && view.has_majority(), "{view:?}");
        // where people stand: no more than 2 m above or below the middle of a body
        assert!((view.point_world.z - 1.0).abs() < 2.0, "{view:?}");
    }
}

#[test]
fn a_camera_turned_round_is_named_in_every_rig() {
    for set in ["walk7", "balance", "trinocular"] {
        let Some(path) = shared(&format!("{set}/calibration.toml")) else {
            continue;
        };
        let whole = rig(&path);
        for (odd, _) in whole.iter() {
            let mut rig = whole.clone();
            let half_turn =
                maquette::math::Rigid3::rotation(nalgebra::Vector3::y() * std::f64::consts::PI);
            let pose = &mut rig.cameras[odd.0].camera_from_world;
            *pose = half_turn * *pose;
            let view = rig.common_view().unwrap();
            assert_eq!(view.blind, [(odd, Blindness::Behind)], "{set}");
            assert!(view.has_majority());
        }
    }
}

#[test]
fn the_cameras_of_the_made_walk_are_as_documented() {
    let Some(path) = shared("walk7/calibration.toml") else {
        return;
    };
    let rig = rig(&path);
    assert_eq!(rig.cameras.len(), 7);
    assert_eq!(rig.cameras[6].name, "cam_07");
    assert!(rig.cameras.iter().all(|c| (c.width_px, c.height_px) == (800, 600)));
    // the folder holds the same calibration
    assert_same(&self::rig(path.parent().unwrap()), &rig);
    let back = read_back(&rig);
    assert_same(&back, &rig);
}

fn read_back(rig: &Rig) -> Rig {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("calibration.toml");
    std::fs::write(&path, write_toml(rig)).expect("a file in it");
    self::rig(&path)
}

#[test]
fn the_qualisys_file_is_what_the_corrected_toml_says() {
    let (Some(qca), Some(toml)) =
        (shared("balance/Calib.qca.txt"), shared("balance/calibration.toml"))
    else {
        return;
    };
    let mut from_qca = rig(&qca);
    for camera in &mut from_qca.cameras {
        camera.name = camera.name.replace("cam", "cam_");
    }
    // the TOML's first two cameras were corrected for their cut videos
    let names = ["cam_03", "cam_04"];
    let [from_qca, from_toml] = [(&from_qca, &qca), (&rig(&toml), &toml)]
        .map(|(rig, path)| select(rig, path, &names).unwrap());
    for (a, b) in from_qca.cameras.iter().zip(&from_toml.cameras) {
        assert_close(a, b);
    }
}

/// To the eight decimals of the TOML's pose.
fn assert_close(a: &Camera, b: &Camera) {
    assert_eq!((a.width_px, a.height_px), (b.width_px, b.height_px));
    assert_eq!(a.distortion, b.distortion, "{}", a.name);
    let matrices = (a.intrinsics.matrix() - b.intrinsics.matrix()).amax();
    assert!(matrices < 1e-6, "{}: K differs by {matrices:e}", a.name);
    let centres = (a.centre_world() - b.centre_world()).norm();
    assert!(centres < 1e-6, "{}: {centres:e} m apart", a.name);
    let turn = a.camera_from_world.rotation.angle_to(&b.camera_from_world.rotation);
    assert!(turn < 1e-6, "{}: turned by {turn:e}", a.name);
}

#[test]
fn real_lenses_round_trip_over_the_whole_image() {
    let balance = shared("balance/calibration.toml").map(|path| rig(&path));
    for camera in balance.iter().flat_map(|rig| &rig.cameras) {
        check_projection(camera, &camera.pixel_grid(41, 41), &[4.0]).unwrap();
    }
}

#[test]
fn the_seated_lenses_round_trip_wherever_their_model_does_not_fold() {
    let Some(rig) = seated() else {
        return;
    };
    for camera in &rig.cameras {
        let grid = camera.pixel_grid(81, 61);
        let seen: Vec<Point2<f64>> =
            grid.iter().copied().filter(|pixel| camera.undistort(pixel).is_some()).collect();
        // the strong barrel folds in the corners: 1.1 % of the fourth camera's image
        assert!(
            seen.len() * 100 >= grid.len() * 98,
            "{}: {} of {}",
            camera.name,
            seen.len(),
            grid.len()
        );
        check_projection(camera, &seen, &[4.0]).unwrap();
    }
}

#[test]
fn the_seated_cameras_stand_above_the_floor() {
    let Some(rig) = seated() else {
        return;
    };
    for camera in &rig.cameras {
        let height = camera.centre_world().z;
        assert!((1.0..4.0).contains(&height), "{}: {height} m", camera.name);
    }
}
