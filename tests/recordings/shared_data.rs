//! The shared recordings, where they are present.

use std::path::{Path, PathBuf};

use maquette::io::recording::{Note, Recording};
use maquette::silhouette::SilhouetteOptions;

use crate::tiny::{load, open};

/// A set of the shared data; `None`, with a line, where it is absent.
#[allow(clippy::print_stderr, reason = "a skipped test says so")]
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
        assert_eq!((recording.rig.cameras.len(), recording.frames.len()), (7, 79));
        assert!(recording.missing.is_empty() && recording.notes.is_empty());
        for position in (0..79).step_by(13) {
            let frame =
                recording.load_frame(position, &SilhouetteOptions::default()).expect("a frame");
            assert_eq!(frame.views.len(), 7);
            let bytes: usize =
                frame.views.iter().map(|(_, silhouette)| silhouette.heap_bytes()).sum();
            assert!(bytes < 2_000_000, "{bytes}");
        }
    }
}

#[test]
fn noise_moves_silhouettes_by_little() {
    let (Some(clean), Some(noisy)) = (shared("walk7"), shared("walk7-noisy")) else {
        return;
    };
    let (clean, noisy) = (load(&clean, 42).expect("a frame"), load(&noisy, 42).expect("a frame"));
    for ((_, clean), (_, noisy)) in clean.views.iter().zip(&noisy.views) {
        approx::assert_relative_eq!(clean.bounds.0, noisy.bounds.0, epsilon = 6.0);
        approx::assert_relative_eq!(clean.bounds.1, noisy.bounds.1, epsilon = 6.0);
        let grid = clean.overlap_grid(noisy.bounds);
        let overlap = clean.overlap(&grid, f64::INFINITY, |_, _, pixel| noisy.contains(pixel));
        assert!(overlap.iou() > 0.85, "{overlap:?}");
    }
}

#[test]
fn a_recording_with_video_and_masks_says_that_the_video_is_not_used() {
    let Some(folder) = shared("balance") else {
        return;
    };
    let recording =
        Recording::open(&folder).and_then(|found| found.observations()).expect("a recording");
    assert_eq!((recording.fps, recording.frames.len()), (60.0, 100));
    assert_eq!(recording.notes, [Note::Ignored { keys: vec!["video"] }]);
    let frame = recording.load_frame(50, &SilhouetteOptions::default()).expect("a frame");
    assert_eq!(frame.views.len(), 4);
}
