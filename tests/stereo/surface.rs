//! Points of the surface of a recording in memory.

use maquette::camera::Rig;
use maquette::image::Picture;
use maquette::pipeline::stereo::{
    StereoError, StereoOptions, SurfaceFrame, SurfaceSummary, measure_surface,
};
use maquette::pipeline::{MemoryPictures, NoProgress, PictureSource};
use maquette::silhouette::FrameIndex;
use nalgebra::Vector3;

use crate::scene::{Wall, three};

/// Four frames of the wall, which moves a centimetre a frame; the first camera has no picture of frame 2.
fn wall() -> MemoryPictures {
    let rig = Rig { cameras: three().to_vec() };
    let frame = |frame: usize| {
        let wall = Wall { shift: Vector3::new(0.01 * frame as f64, 0.0, 0.0) };
        let cameras = rig.cameras.iter().enumerate();
        let picture = |camera| wall.seen_by(camera).map(|grey| [grey; 3]);
        let pictures: Vec<Option<Picture>> =
            cameras.map(|(i, camera)| (frame != 2 || i != 0).then(|| picture(camera))).collect();
        (FrameIndex(frame), pictures)
    };
    MemoryPictures {
        frames: (0..4).map(frame).collect(),
        fps: 25.0,
        rig,
        ..MemoryPictures::default()
    }
}

fn measured(options: &StereoOptions) -> (Vec<SurfaceFrame>, SurfaceSummary) {
    let (pictures, mut frames) = (wall(), Vec::new());
    let all = pictures.frames();
    let summary = measure_surface(&pictures, None, &all, options, &NoProgress, |frame| {
        frames.push(frame);
        Ok::<(), StereoError>(())
    });
    (frames, summary.expect("three cameras side by side"))
}

#[test]
fn every_frame_is_handed_over_and_a_missing_picture_ends_the_tracks() {
    let options = StereoOptions { spacing_px: 6, tracks: true, ..StereoOptions::default() };
    let (frames, summary) = measured(&options);
    assert_eq!(summary.frames, 4);
    assert!(frames[0].points().len() > 50, "{}", frames[0].points().len());
    assert!(frames[2].points().is_empty() && frames[2].surface.is_none());
    assert_eq!(frames[2].reason, "a camera has no picture");
    let note = "1 frame without points, frame 2 first: a camera has no picture";
    assert_eq!(summary.notes, [note]);

    let ended: Vec<usize> = frames.iter().map(|f| f.ended_tracks.len()).collect();
    assert_eq!(ended, [0, 0, 1, 1]);
    assert_eq!(frames[2].ended_tracks[0].first_frame, 0);
    let tracks = frames.iter().flat_map(|f| &f.ended_tracks);
    let trajectories: usize = tracks.map(|tracks| tracks.trajectories.len()).sum();
    assert_eq!(summary.trajectories, Some(trajectories));
}

#[test]
fn what_takes_the_frames_can_stop_the_measurement() {
    let (pictures, mut taken) = (wall(), 0);
    let all = pictures.frames();
    let options = StereoOptions { spacing_px: 6, ..StereoOptions::default() };
    let full = "the disk is full";
    let stopped = measure_surface(&pictures, None, &all, &options, &NoProgress, |_| {
        taken += 1;
        Err::<(), Box<dyn std::error::Error>>(full.into())
    });
    assert_eq!(stopped.unwrap_err().to_string(), full);
    assert_eq!(taken, 1);
}
