//! What is written is read back, in every format that is written.

use std::fs;
use std::path::Path;

use crate::calibration_samples::*;
use maquette::camera::{Camera, Distortion, Rig, UpAxis};
use maquette::io::calibration::{
    CalibrationOptions, CalibrationWriteError, CameraEstimate, Refined, Unit, read,
    read_per_camera, write,
};

/// Writes a rig under a name into a new folder, and gives the names of the files.
fn written(folder: &Path, name: &str, rig: &Rig, options: &CalibrationOptions) -> Vec<String> {
    let files = write(rig, &folder.join(name), options, &[]).expect("it can be written and read");
    let name = |path: &Path| {
        path.file_name().expect("it can be written and read").to_string_lossy().into_owned()
    };
    files
        .iter()
        .for_each(|file| fs::write(&file.path, &file.text).expect("it can be written and read"));
    files.iter().map(|file| name(&file.path)).collect()
}

fn back(name: &str, rig: &Rig, options: &CalibrationOptions) -> Rig {
    let folder = tempfile::tempdir().expect("it can be written and read");
    written(folder.path(), name, rig, options);
    read(&folder.path().join(name), options).expect("it can be written and read")
}

/// Nearer than printing with every digit can leave.
fn assert_equal(read: &Rig, expected: &Rig) {
    assert_same(read, expected);
    for (a, b) in read.cameras.iter().zip(&expected.cameras) {
        let moved = (a.centre_world() - b.centre_world()).norm();
        let turned = a.camera_from_world.rotation.angle_to(&b.camera_from_world.rotation);
        let matrices = (a.intrinsics.matrix() - b.intrinsics.matrix()).amax();
        // the angle of two rotations is no surer than the root of rounding
        assert!(moved < 1e-9 && turned < 1e-7 && matrices < 1e-9, "{moved} {turned} {matrices}");
    }
}

const NAMES: [&str; 4] = ["rig.toml", "extri.yml", "rig.yml", "rig.xml"];

#[test]
fn every_format_gives_the_same_rig_in_every_world_and_unit() {
    for up in [UpAxis::Z, UpAxis::MinusZ, UpAxis::Y, UpAxis::MinusY] {
        for unit in [None, Some(Unit::Metre), Some(Unit::Millimetre)] {
            let options = CalibrationOptions { unit, up, ..CalibrationOptions::default() };
            for name in NAMES {
                let rig = expected(lens());
                assert_equal(&back(name, &rig, &options), &rig);
            }
        }
    }
}

#[test]
fn qualisys_is_in_millimetres_whatever_unit_is_asked_for() {
    for up in [UpAxis::Z, UpAxis::Y] {
        let own = CalibrationOptions { up, ..CalibrationOptions::default() };
        let asked = CalibrationOptions { unit: Some(Unit::Metre), ..own.clone() };
        let (rig, folder) = (expected(lens()), tempfile::tempdir().unwrap());
        written(folder.path(), "rig.qca.txt", &rig, &asked);
        assert_equal(&read(&folder.path().join("rig.qca.txt"), &own).unwrap(), &rig);
    }
}

#[test]
fn each_camera_may_have_a_file_of_its_own() {
    for ending in ["yml", "xml"] {
        let (rig, options) = (expected(lens()), CalibrationOptions::default());
        let folder = tempfile::tempdir().unwrap();
        let names = written(folder.path(), &format!("{{camera}}.{ending}"), &rig, &options);
        assert_eq!(names, [format!("cam1.{ending}"), format!("cam2.{ending}")]);
        let files = ["cam1", "cam2"]
            .map(|name| (name.to_owned(), folder.path().join(format!("{name}.{ending}"))));
        assert_equal(&read_per_camera(&files, &options).unwrap(), &rig);
    }
}

#[test]
fn every_lens_is_written_or_refused_with_the_cameras_name() {
    let rational = Distortion::brown_conrady(&[0.1, 0.2, 3e-3, 4e-3, 0.0, 0.0, 1e-7, 0.0]).unwrap();
    let fisheye = Distortion::fisheye(&[0.1, 0.0, -0.02, 0.0]).unwrap();
    let correction =
        Distortion::RadialCorrection { centre_x: 0.1, centre_y: 0.0, k1: 0.1, k2: 0.0, k3: 0.0 };
    for (lens, in_opencv, in_qualisys) in [
        (Distortion::None, true, true),
        (rational, true, false),
        (fisheye, true, false),
        (correction, false, false),
    ] {
        let rig = expected(lens);
        for name in NAMES.into_iter().chain(["rig.qca.txt", "{camera}.xml"]) {
            let options = CalibrationOptions::default();
            let is_held = match name {
                "rig.toml" => true,
                "rig.qca.txt" => in_qualisys,
                _ => in_opencv,
            };
            match write(&rig, Path::new(name), &options, &[]) {
                Ok(_) if name.starts_with('{') => assert!(is_held, "{name}"),
                Ok(_) => {
                    assert!(is_held, "{name}");
                    assert_eq!(back(name, &rig, &options).cameras[1].distortion, lens, "{name}");
                }
                Err(fault) => {
                    assert!(!is_held, "{name}: {fault}");
                    assert!(fault.to_string().starts_with(&format!("{name}: camera cam1: ")));
                }
            }
        }
    }
}

#[test]
fn a_name_that_is_no_key_is_refused_where_it_would_be_one() {
    let mut rig = expected(lens());
    rig.cameras[1].name = "left \"<&1".into();
    let options = CalibrationOptions::default();
    for name in ["intri.yml", "rig.xml", "{camera}.yml"] {
        let fault = write(&rig, Path::new(name), &options, &[]).unwrap_err();
        assert!(matches!(fault, CalibrationWriteError::Name { .. }), "{fault}");
    }
    for name in ["rig.toml", "rig.qca.txt"] {
        let read = back(name, &rig, &options);
        assert!(read.by_name("left \"<&1").is_some(), "{name}");
    }
    let fault = write(&rig, Path::new("rig.xcp"), &options, &[]).unwrap_err();
    assert!(matches!(fault, CalibrationWriteError::UnknownFormat { .. }), "{fault}");
}

#[test]
fn standard_deviations_stand_in_the_metadata_and_are_no_camera() {
    let rig = expected(lens());
    let refined = |camera: &Camera| {
        CameraEstimate::Refined(Refined {
            camera: camera.name.clone(),
            turn_deg: [0.1, 0.2, 0.3],
            turn_sd_deg: [0.01; 3],
            displacement_m: [0.001, 0.0, 0.0],
            displacement_sd_m: [0.002; 3],
            zoom: 1.01,
            zoom_sd: 0.002,
        })
    };
    let mut known: Vec<CameraEstimate> = rig.cameras.iter().map(refined).collect();
    let camera = rig.cameras[0].name.clone();
    known.push(CameraEstimate::Placed { camera, turn_sd_deg: 0.25, place_sd_m: 0.004 });
    let path = Path::new("rig.toml");
    let files = write(&rig, path, &CalibrationOptions::default(), &known).unwrap();
    let text = &files[0].text;
    assert!(text.contains("[metadata.refined.cam2]\nturn_deg = [ 0.1, 0.2, 0.3]"), "{text}");
    assert!(text.contains("\nzoom = 1.01\nzoom_sd = 0.002\n"), "{text}");
    let placed = "turn_sd_deg = 0.25\nplace_sd_m = 0.004\n";
    assert!(text.contains("[metadata.placed.") && text.ends_with(placed), "{text}");
    assert_same(&read_text("rig.toml", text, &CalibrationOptions::default()).unwrap(), &rig);
}
