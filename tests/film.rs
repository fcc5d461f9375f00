//! Photographs of a person before clutter: what they show is what is said to be true.

use std::path::Path;

use maquette::body::metaball::Field;
use maquette::camera::CameraId;
use maquette::image::{Mask, luma};
use maquette::io::model;
use maquette::io::recording::{Recording, filmed};
use maquette::render;
use maquette::silhouette::FrameIndex;
use maquette::synth::{Film, FilmRecipe, Shot};

fn small(seed: u64, noise_sd: f32) -> Film {
    let body = model::load("walker-metaballs", Path::new("")).expect("shipped");
    let recipe =
        FilmRecipe { seed, frames: 12, fps: 5.0, width_px: 160, noise_sd, ..FilmRecipe::default() };
    recipe.film(&body).expect("a body with feet and skin")
}

fn overlap(one: &Mask, other: &Mask) -> f64 {
    let (mut both, mut either) = (0.0, 0.0);
    for y in 0..one.height() {
        for (a, b) in one.row(y).iter().zip(other.row(y)) {
            both += f64::from(a & b);
            either += f64::from(a | b);
        }
    }
    both / either
}

#[test]
fn a_seed_is_a_recording_and_frames_can_be_taken_in_any_order() {
    let (film, again, other) = (small(1, 2.0), small(1, 2.0), small(2, 2.0));
    let shot = |film: &Film, frame| -> Shot {
        let studio = film.studio(CameraId(1)).expect("a camera");
        studio.shot(FrameIndex(frame)).expect("a frame")
    };
    assert_eq!(shot(&film, 7), shot(&again, 7));
    assert_ne!(shot(&film, 7).picture, shot(&other, 7).picture);
    assert_ne!(shot(&film, 7).picture, shot(&film, 8).picture);
    let studio = film.studio(CameraId(1)).expect("a camera");
    assert!(studio.shot(FrameIndex(12)).is_none());
    assert!(film.studio(CameraId(3)).is_none());
}

#[test]
fn the_mask_is_where_the_body_is_that_the_truth_tells() {
    for seed in [1, 2] {
        let film = small(seed, 2.0);
        for (id, camera) in film.synthetic.rig.iter() {
            let studio = film.studio(id).expect("a camera");
            for frame in [0, 5, 11] {
                let shot = studio.shot(FrameIndex(frame)).expect("a frame");
                let body = film.synthetic.posed(FrameIndex(frame)).expect("a frame");
                let cast = render::silhouette(camera, &Field::from_body(&body));
                let overlap = overlap(&shot.mask, &cast);
                assert!(overlap > 0.85, "seed {seed} frame {frame}: {overlap}");
                let edge = (0..120).any(|y| shot.mask.is_foreground(0, y));
                assert!(!edge, "the person leaves the picture");
            }
        }
    }
}

/// Where the person is and where they are not, neighbouring pixels differ alike, or one could be told from the other.
#[test]
fn the_background_has_edges_as_strong_as_the_person() {
    for seed in [1, 2, 3] {
        let film = small(seed, 0.0);
        let studio = film.studio(CameraId(1)).expect("a camera");
        let shot = studio.shot(FrameIndex(3)).expect("a frame");
        let grey = luma(&shot.picture);
        let (mut sums, mut counts) = ([0.0; 2], [0.0; 2]);
        for y in 0..grey.height() {
            for x in 1..grey.width() {
                let side = usize::from(shot.mask.is_foreground(x, y));
                if shot.mask.is_foreground(x - 1, y) == (side == 1) {
                    sums[side] += f64::from(grey.row(y)[x].abs_diff(grey.row(y)[x - 1]));
                    counts[side] += 1.0;
                }
            }
        }
        let [room, person] = [sums[0] / counts[0], sums[1] / counts[1]];
        assert!(room > 0.5 * person, "seed {seed}: {room} and {person}");
    }
}

#[test]
fn the_background_changes_and_not_by_noise_alone() {
    let film = small(1, 0.0);
    let studio = film.studio(CameraId(1)).expect("a camera");
    let [first, last] = [0, 11].map(|f| studio.shot(FrameIndex(f)).expect("a frame"));
    let (mut changed, mut all) = (0, 0);
    for y in 0..first.picture.height() {
        for x in 0..first.picture.width() {
            let is_person = first.mask.is_foreground(x, y) || last.mask.is_foreground(x, y);
            let (a, b) = (first.picture.row(y)[x], last.picture.row(y)[x]);
            let differs = a.iter().zip(b).any(|(a, b)| a.abs_diff(b) > 4);
            all += usize::from(!is_person);
            changed += usize::from(!is_person && differs);
        }
    }
    assert!(changed * 10 > all, "{changed} of {all}");
}

#[test]
fn a_recording_of_photographs_is_read_like_any_other_and_tells_no_mask() {
    let film = small(1, 2.0);
    let place = tempfile::tempdir().expect("a folder");
    let folder = place.path().join("film");
    filmed::write(&film, &folder).expect("written");
    let footage = Recording::open(&folder).and_then(|found| found.footage()).expect("read");
    assert_eq!(footage.frames().len(), 12);
    for (read, made) in footage.rig.cameras.iter().zip(&film.synthetic.rig.cameras) {
        let off = read.projection() - made.projection();
        assert!(read.name == made.name && off.norm() < 1e-9);
    }
    let mut sets = footage.frame_sets(5..=5);
    let (_, pictures) = sets.next().expect("a frame");
    let read = pictures[2].as_ref().expect("a picture");
    let shot = film.studio(CameraId(2)).and_then(|s| s.shot(FrameIndex(5)));
    let made = shot.expect("a frame").picture;
    let off: f64 = luma(read)
        .values()
        .iter()
        .zip(luma(&made).values())
        .map(|(a, b)| f64::from(a.abs_diff(*b)))
        .sum();
    let off = off / read.values().len() as f64;
    assert!(off < 4.0, "{off}");
    assert!(
        Recording::open(&folder).and_then(|found| found.observations()).is_err(),
        "it has no masks"
    );
    assert!(folder.join("truth/masks/left/000011.png").is_file());
    assert!(filmed::write(&film, &folder).is_err(), "it is written over");
}
