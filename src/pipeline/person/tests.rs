use nalgebra::{Point3, Vector3};

use super::*;
use crate::camera::Camera;
use crate::silhouette::Keypoint;
use crate::synth::Ring;

const FPS: f64 = 50.0;
const JOINTS: [(&str, [f64; 3]); 8] = [
    ("RHip", [0.0, -0.1, 0.9]),
    ("LHip", [0.0, 0.1, 0.9]),
    ("RKnee", [0.1, -0.1, 0.5]),
    ("LKnee", [-0.1, 0.1, 0.5]),
    ("RAnkle", [0.1, -0.1, 0.1]),
    ("LAnkle", [-0.2, 0.1, 0.1]),
    ("RShoulder", [0.0, -0.2, 1.4]),
    ("LShoulder", [0.0, 0.2, 1.4]),
];

/// A person whose joints are so far from the middle of the room.
fn shown(camera: &Camera, off: Vector3<f64>) -> Vec<Keypoint> {
    let keypoint = |(name, place): &(&'static str, [f64; 3])| {
        let pixel = camera.project_undistorted(&(Point3::from(*place) + off))?;
        Some(Keypoint { name, pixel, confidence: 0.8 })
    };
    JOINTS.iter().filter_map(keypoint).collect()
}

/// One who walks through all frames, a second who is there in some, and as many who stand about as there are `bystanders`.
fn recording(bystanders: usize) -> (Rig, Vec<FramePeople>) {
    let rig = Ring { cameras: 4, ..Ring::default() }.regular();
    let walker = |i: usize| Vector3::new(0.02 * i as f64 - 0.3, 0.0, 0.0);
    let others = |i: usize, k: usize| {
        let angle = k as f64 * 2.4;
        let radius = 0.9 + 0.1 * k as f64;
        let sway = 0.01 * (i as f64).sin();
        Vector3::new(radius * angle.cos() + sway, radius * angle.sin(), 0.0)
    };
    let frame = |i: usize| {
        let people = |camera: &Camera| {
            let mut all: Vec<Vec<Keypoint>> = Vec::new();
            // nobody has the same place in all files
            let beside = (0..bystanders).map(|k| shown(camera, others(i, k)));
            all.extend(beside.filter(|_| !i.is_multiple_of(3)));
            all.insert(i % (all.len() + 1), shown(camera, walker(i)));
            all
        };
        let pictures = rig.iter().map(|(id, camera)| (id, people(camera))).collect();
        FramePeople { frame: FrameIndex(i), pictures }
    };
    let frames = (0..20).map(frame).collect();
    (rig, frames)
}

/// How far the hip of what was found lies from the walker's, px, and how many pictures there are.
fn off_px(rig: &Rig, found: &Person) -> (f64, usize) {
    let mut worst = (0.0_f64, 0);
    for (frame, detections) in &found.detections {
        let walker = Vector3::new(0.02 * frame.0 as f64 - 0.3, 0.0, 0.0);
        for (id, detection) in detections {
            let right = shown(&rig.cameras[id.0], walker)[0].pixel;
            worst.0 = worst.0.max((detection.keypoints[0].pixel - right).norm());
            worst.1 += 1;
        }
    }
    worst
}

/// Who is measured.
fn person(rig: &Rig, frames: &[FramePeople], fps: f64) -> Person {
    detected_people(rig, frames, fps, 1).remove(0)
}

#[test]
fn of_two_who_are_seen_long_enough_the_one_who_walks_comes_first() {
    let (rig, frames) = recording(1);
    let found = detected_people(&rig, &frames, FPS, 4);
    assert_eq!(found.len(), 2);
    assert!(off_px(&rig, &found[0]).0 < 1e-6);
    let (off, pictures) = off_px(&rig, &found[1]);
    assert!(off > 50.0 && pictures == 4 * 13, "{off} px in {pictures} pictures");
}

#[test]
fn the_person_who_is_seen_longest_is_followed_among_two_and_among_twenty() {
    for bystanders in [0, 1, 19] {
        let (rig, frames) = recording(bystanders);
        let found = person(&rig, &frames, FPS);
        let (off, pictures) = off_px(&rig, &found);
        assert!(off < 1e-6 && pictures == 4 * 20, "{bystanders}: {off} px in {pictures} pictures");
        assert_eq!(found.beside.cameras, Vec::<String>::new());
    }
}

#[test]
fn a_frame_that_one_camera_sees_is_added_and_exchanged_legs_do_not_part_a_person() {
    let (rig, mut frames) = recording(1);
    frames[7].pictures.truncate(1);
    for keypoint in frames[9].pictures[2].1.iter_mut().flatten() {
        if !keypoint.name.ends_with("Shoulder") {
            let twin = twin(keypoint.name);
            keypoint.name = JOINTS.iter().find(|(name, _)| *name == twin).unwrap().0;
        }
    }
    let found = person(&rig, &frames, FPS);
    assert_eq!(found.detections[7].1.len(), 1);
    assert_eq!(found.detections[9].1.len(), 4);
    let sizes = found.detections.iter().flat_map(|(_, seen)| seen).map(|(_, d)| d.size_px);
    assert!(sizes.fold(f64::INFINITY, f64::min) > 10.0);
}

#[test]
fn a_camera_that_looks_elsewhere_is_named_and_nobody_is_found_where_no_two_agree() {
    let (mut rig, frames) = recording(0);
    rig.cameras[3].camera_from_world.translation.vector.y += 1.5;
    let found = person(&rig, &frames, FPS);
    assert_eq!(found.beside.cameras, [rig.cameras[3].name.clone()]);
    assert!(found.detections.iter().all(|(_, seen)| seen.len() == 3));

    let alone: Vec<FramePeople> = frames
        .into_iter()
        .map(|frame| FramePeople { pictures: frame.pictures[..1].to_vec(), ..frame })
        .collect();
    let found = person(&rig, &alone, FPS);
    assert!(found.detections.iter().all(|(_, seen)| seen.is_empty()));
    assert_eq!(found.beside.pictures, 20);
}

#[test]
fn detections_of_pictures_of_another_size_are_told_with_their_scale() {
    let (mut rig, frames) = recording(1);
    assert_eq!(other_scale(&rig, &frames), None);
    for scale in [0.5, 4.0 / 3.0, 2.0, 3.0] {
        let told = other_scale(&rig, &smaller(&frames, scale));
        assert_eq!(told, Some(scale));
    }

    // of two cameras, too
    rig.cameras.truncate(2);
    let of_two = |mut frame: FramePeople| {
        frame.pictures.truncate(2);
        frame
    };
    let frames: Vec<FramePeople> = frames.into_iter().map(of_two).collect();
    assert_eq!(other_scale(&rig, &frames), None);
    assert_eq!(other_scale(&rig, &smaller(&frames, 2.0)), Some(2.0));
}

/// What is seen in pictures that are so many times as small.
fn smaller(frames: &[FramePeople], scale: f64) -> Vec<FramePeople> {
    let mut frames = frames.to_vec();
    let people = frames.iter_mut().flat_map(|frame| &mut frame.pictures);
    for keypoint in people.flat_map(|(_, people)| people).flatten() {
        keypoint.pixel /= scale;
    }
    frames
}
