//! A synthetic recording on disk is read like any other, and says the truth.

use std::fs;
use std::path::Path;

use maquette::camera::{CameraId, check_projection};
use maquette::io::model;
use maquette::io::points::trc;
use maquette::io::recording::Recording;
use maquette::io::recording::synthetic::{SyntheticError, trajectories, write};
use maquette::silhouette::{FrameIndex, SilhouetteOptions};
use maquette::synth::{Ring, StereoPair, Synthetic, sample_walker};
use nalgebra::Point3;

fn sample() -> Synthetic {
    let walker = model::load("walker-metaballs", Path::new("")).expect("shipped models are right");
    sample_walker(&walker, 1).expect("it has feet")
}

/// Three frames in two small cameras.
fn small() -> Synthetic {
    let mut synthetic = sample();
    synthetic.motions.truncate(3);
    let ring =
        Ring { cameras: 2, width_px: 160, height_px: 120, focal_px: 165.0, ..Ring::default() };
    synthetic.rig = ring.regular();
    synthetic.stereo = Some(StereoPair::default());
    synthetic
}

#[test]
fn what_is_written_is_read_as_a_recording() {
    let (synthetic, place) = (small(), tempfile::tempdir().unwrap());
    let folder = place.path().join("deep/walk");
    write(&synthetic, &folder).unwrap();
    let recording = Recording::open(&folder).and_then(|found| found.observations()).unwrap();
    assert!((recording.fps - 50.0).abs() < 1e-12 && recording.missing.is_empty());
    let frames: Vec<_> = (0..3).map(FrameIndex).collect();
    assert_eq!(recording.frames, frames);
    assert_eq!(recording.rig.names().collect::<Vec<_>>(), ["cam_01", "cam_02"]);
    let pixels = [Point3::new(0.1, 0.2, 1.0)];
    for (read, made) in recording.rig.cameras.iter().zip(&synthetic.rig.cameras) {
        let difference = read.project(&pixels[0]).unwrap() - made.project(&pixels[0]).unwrap();
        assert!(difference.norm() < 1e-9);
        check_projection(read, &read.pixel_grid(3, 3), &[2.0]).unwrap();
    }
    let observed = recording.load_frame(1, &SilhouetteOptions::default()).unwrap();
    assert_eq!(observed.views.len(), 2, "{:?}", observed.rejected);
    let cloud = |camera| synthetic.cloud(FrameIndex(1), CameraId(camera)).unwrap();
    assert_eq!(observed.points, [cloud(0), cloud(1)].concat());
    assert!(recording.notes.is_empty() && observed.points.len() > 50);
}

#[test]
fn the_truth_beside_it_is_where_the_joints_are() {
    let (synthetic, place) = (small(), tempfile::tempdir().unwrap());
    write(&synthetic, place.path()).unwrap();
    let path = place.path().join("truth.trc");
    let read = trc::read_trc(&fs::read_to_string(&path).unwrap(), &path).unwrap();
    let made = trajectories(&synthetic);
    assert_eq!((read.names, read.frames.len()), (made.names, 3));
    for (a, b) in read.frames.iter().flatten().zip(made.frames.iter().flatten()) {
        assert!((a.unwrap() - b.unwrap()).norm() < 1e-6);
    }
    let text = fs::read_to_string(place.path().join("truth.json")).unwrap();
    let truth: serde_json::Value = serde_json::from_str(&text).unwrap();
    let knee = truth["angles_deg"]["knee_flexion_r"][2].as_f64().unwrap();
    let joint = synthetic.model.joint("knee_flexion_r").unwrap();
    approx::assert_relative_eq!(
        knee.to_radians(),
        synthetic.motions[2].angles[joint.0],
        epsilon = 1e-12
    );
    let points = synthetic.points(FrameIndex(0)).unwrap();
    let at = |name| points[synthetic.model.point(name).unwrap()];
    let thigh = truth["lengths_m"]["thigh"].as_f64().unwrap();
    approx::assert_relative_eq!(thigh, (at("RHip") - at("RKnee")).norm(), epsilon = 1e-12);
}

#[test]
fn a_folder_that_is_not_empty_is_left_alone() {
    let place = tempfile::tempdir().unwrap();
    fs::write(place.path().join("mine.txt"), "mine").unwrap();
    let error = write(&small(), place.path()).unwrap_err();
    assert!(matches!(error, SyntheticError::NotEmpty { .. }), "{error}");
    assert_eq!(fs::read_dir(place.path()).unwrap().count(), 1);
}

#[test]
fn a_place_that_cannot_be_written_is_named() {
    let place = tempfile::tempdir().unwrap();
    let file = place.path().join("file");
    fs::write(&file, "").unwrap();
    let error = write(&small(), &file.join("walk")).unwrap_err();
    assert!(error.to_string().contains("cannot be written"), "{error}");
}

/// The sample that lies in the repository is still what the code makes. Another machine's arithmetic may move a border pixel.
#[test]
fn the_sample_recording_is_the_one_of_seed_one() {
    let synthetic = sample();
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/sequences/walker");
    let recording = Recording::open(&folder).and_then(|found| found.observations()).unwrap();
    assert_eq!(recording.frames.len(), synthetic.frames());
    assert_eq!(recording.rig.cameras.len(), 6);
    for (frame, camera) in [(0, 0), (17, 3), (40, 5)] {
        let (frame, camera) = (FrameIndex(frame), CameraId(camera));
        let file = image::open(recording.mask_path(camera, frame).unwrap()).unwrap().to_luma8();
        let mask = synthetic.mask(frame, camera).unwrap();
        let differs = |(x, y, p): (u32, u32, &image::Luma<u8>)| {
            mask.is_foreground(x as usize, y as usize) != (p.0[0] > 127)
        };
        let different = file.enumerate_pixels().filter(|p| differs(*p)).count();
        assert!(different < 10, "{frame} {camera}: {different} pixels differ");
    }
    let path = folder.join("truth.trc");
    let truth = trc::read_trc(&fs::read_to_string(&path).unwrap(), &path).unwrap();
    for (a, b) in
        truth.frames.iter().flatten().zip(trajectories(&synthetic).frames.iter().flatten())
    {
        assert!((a.unwrap() - b.unwrap()).norm() < 1e-5);
    }
}
