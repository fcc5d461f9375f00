//! Points of a recording: where they are looked for, and each way for them to be bad.

use std::fs;
use std::path::Path;

use maquette::io::points::write_ply;
use maquette::io::recording::{MOST_POINTS, Note, ObservationFiles};
use maquette::silhouette::{FrameIndex, FrameObservations, SilhouetteOptions};
use maquette::stereo::{CloudPoint, Spread};
use nalgebra::{Matrix3, Point3, Vector3};
use tempfile::TempDir;

use crate::tiny::{assert_complains, load, open, recording, with_manifest, write};

/// A grid of 20 × 20 points over 1 m, around the point that the tiny cameras look at.
fn grid(recording: &ObservationFiles, scale: f64) -> Vec<CloudPoint> {
    let middle = recording.rig.common_view().expect("cameras").point_world;
    let point = |i: i32| {
        let (x, y) = (f64::from(i % 20) / 20.0 - 0.5, f64::from(i / 20) / 20.0 - 0.5);
        CloudPoint {
            position_world: Point3::from((middle + Vector3::new(x, y, 0.1 * x)).coords * scale),
            spread: Spread::Isotropic(0.005 * scale),
        }
    };
    (0..400).map(point).collect()
}

/// A tiny recording of three frames, with points of frame 1.
fn with_points(manifest: &str, scale: f64) -> TempDir {
    let folder = with_manifest(&["a", "b"], manifest);
    let points = grid(&recorded(folder.path()), scale);
    write(folder.path().join("points/000001.ply"), write_ply(&points));
    folder
}

/// The recording without its points.
fn recorded(folder: &Path) -> ObservationFiles {
    let bare = recording(&["a", "b"]);
    assert!(folder.exists());
    open(bare.path()).expect("a recording")
}

fn all(folder: &Path) -> (ObservationFiles, Vec<FrameObservations>) {
    let recording = open(folder).expect("a recording");
    let options = SilhouetteOptions::default();
    let frames = (0..recording.frames.len())
        .map(|i| recording.load_frame(i, &options).expect("a frame"))
        .collect();
    (recording, frames)
}

fn said(notes: &[Note]) -> Vec<String> {
    notes.iter().map(ToString::to_string).collect()
}

#[test]
fn a_folder_of_points_needs_no_manifest_and_is_used_where_it_has_frames() {
    let folder = recording(&["a", "b"]);
    let points = grid(&recorded(folder.path()), 1.0);
    let path = folder.path().join("points");
    write(path.join("cloud_000001.ply"), write_ply(&points));
    write(path.join("readme.md"), "not a cloud");
    let (recording, frames) = all(folder.path());
    assert_eq!(said(&recording.notes), ["points: 1 of 3 frames have points"]);
    let counts: Vec<_> = frames.iter().map(|f| f.points.len()).collect();
    assert_eq!(counts, [0, 400, 0]);
    assert_eq!(frames[1].points, points);
    assert!(recording.notes_on(&frames).is_empty());
    let inputs = recording.checksums().expect("checksums");
    assert_eq!(inputs.last().expect("points").input, "points");
}

#[test]
fn a_frame_that_only_has_points_is_a_frame() {
    let folder = recording(&["a", "b"]);
    let points = grid(&recorded(folder.path()), 1.0);
    write(folder.path().join("points/000007.ply"), write_ply(&points));
    let (recording, frames) = all(folder.path());
    assert_eq!(recording.frames, [0, 1, 2, 7].map(FrameIndex));
    assert!(frames[3].views.is_empty() && frames[3].is_observed());
}

#[test]
fn the_manifest_says_where_the_points_are_and_how_they_turn() {
    let folder = with_points("points = \"points/%06d.ply\"\npoints_unit = \"mm\"\n", 1000.0);
    let truth = grid(&recorded(folder.path()), 1.0);
    let (_, frames) = all(folder.path());
    for (point, true_point) in frames[1].points.iter().zip(&truth) {
        let off = (point.position_world - true_point.position_world).norm();
        assert!(off < 1e-12, "{off}");
        let sigma = point.spread.along(&Vector3::x()).expect("stated");
        assert!((sigma - 0.005).abs() < 1e-12);
    }
    // the points turn with the calibration's world
    let folder = with_points("up = \"-z\"\n", 1.0);
    let (_, frames) = all(folder.path());
    for (point, true_point) in frames[1].points.iter().zip(&truth) {
        let p = true_point.position_world;
        assert!((point.position_world - Point3::new(p.x, -p.y, -p.z)).norm() < 1e-9);
    }
}

#[test]
fn points_that_are_not_there_are_named() {
    for (pattern, part) in [
        ("clouds/%06d.ply", "clouds: the folder cannot be read"),
        ("nowhere", "points: no point cloud (.ply, .xyz, .txt, .csv) at "),
        ("points/%x.ply", "points = \"points/%x.ply\": expected one %d"),
    ] {
        let folder = with_points(&format!("points = \"{pattern}\"\n"), 1.0);
        assert_complains(open(folder.path()), &[part]);
    }
    let folder = with_points("", 1.0);
    write(folder.path().join("points/1.xyz"), "0 0 0\n");
    assert_complains(open(folder.path()), &["points: ", "are both number 1"]);
}

#[test]
fn millimetres_by_mistake_are_refused_with_the_cure() {
    let folder = with_points("", 1000.0);
    assert_complains(
        load(folder.path(), 1),
        &["points/000001.ply: frame 1: ", "write points_unit = \"mm\" in sequence.toml"],
    );
    let folder = with_points("points_unit = \"mm\"\n", 1.0);
    assert_complains(
        load(folder.path(), 1),
        &["frame 1: the points lie within", "write points_unit = \"m\""],
    );
}

#[test]
fn empty_clouds_and_numbers_that_are_none_are_told_once() {
    let folder = with_points("", 1.0);
    let path = folder.path().join("points");
    write(path.join("000000.ply"), "");
    write(path.join("000002.xyz"), "0 0 0.1 0.01\nnan 0 0 0.01\n0 inf 0 0.01\n0 0 0 -1\n");
    let (recording, frames) = all(folder.path());
    let counts: Vec<_> = frames.iter().map(|f| f.points.len()).collect();
    assert_eq!((counts, said(&recording.notes)), (vec![0, 400, 1], Vec::<String>::new()));
    assert_eq!(
        said(&recording.notes_on(&frames)),
        [
            "points: no usable points in frames 0",
            "points: 3 points left out in frames 2: not finite, or a spread that is not positive"
        ]
    );
}

#[test]
fn a_million_points_are_thinned_evenly_and_this_is_told() {
    let folder = recording(&["a", "b"]);
    let some = grid(&recorded(folder.path()), 1.0);
    let million: Vec<CloudPoint> = some.iter().cycle().take(1_000_000).copied().collect();
    write(folder.path().join("points/000000.ply"), write_ply(&million));
    let (recording, frames) = all(folder.path());
    assert_eq!(frames[0].points.len(), MOST_POINTS);
    // each of the 400 places has its share of 12.5
    for place in &some {
        let there = |p: &&CloudPoint| p.position_world == place.position_world;
        let count = frames[0].points.iter().filter(there).count();
        assert!((12..=13).contains(&count), "{count}");
    }
    assert_eq!(
        said(&recording.notes_on(&frames)),
        ["points: up to 1000000 in a frame; thinned evenly to 5000 in frames 0"]
    );
}

#[test]
fn a_cloud_that_cannot_be_read_is_named_with_frame_and_place() {
    let folder = with_points("", 1.0);
    let path = folder.path().join("points/000001.ply");
    let whole = fs::read(&path).expect("a cloud");
    let cut = whole[..whole.len() - 20].to_vec();
    for (bytes, parts) in [
        (cut, ["the header promises 400 of \"vertex\"", "room for 399 at most"]),
        (b"plya\n".to_vec(), ["000001.ply:1: ", "no PLY header"]),
    ] {
        write(path.clone(), bytes);
        assert_complains(load(folder.path(), 1), &parts);
        assert_complains(load(folder.path(), 1), &["frame 1: "]);
    }
}

#[test]
fn a_covariance_turns_with_the_world() {
    let folder = recording(&["a", "b"]);
    let mut points = grid(&recorded(folder.path()), 1.0);
    let covariance = Matrix3::new(4e-4, 1e-5, 0.0, 1e-5, 1e-4, 2e-5, 0.0, 2e-5, 2.25e-4);
    for point in &mut points {
        point.spread = Spread::Full(covariance);
    }
    write(folder.path().join("points/000000.ply"), write_ply(&points));
    write(folder.path().join("sequence.toml"), "up = \"y\"\n");
    let frame = load(folder.path(), 0).expect("a frame");
    let along = |d: Vector3<f64>| frame.points[0].spread.along(&d).expect("stated");
    // up = "y": the file's (x, y, z) is (x, −z, y) here
    for (here, there) in [(Vector3::x(), 0.02), (Vector3::y(), 0.015), (Vector3::z(), 0.01)] {
        assert!((along(here) - there).abs() < 1e-12);
    }
}
