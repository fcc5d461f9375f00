//! The rendered man before three cameras 20 cm apart.

use std::path::Path;
use std::time::Instant;

use experiments::run::Run;
use maquette::camera::CameraId;
use maquette::image::luma;
use maquette::io::recording::Recording;
use maquette::silhouette::FrameIndex;
use maquette::stereo::StereoView;
use maquette::stereo::matching::{MatchOptions, match_surface};
use maquette::stereo::tracking::{
    FilterOptions, FrameViews, TrackOptions, Tracker, Trajectory, filter_trajectories,
};
use nalgebra::Unit;

use crate::Fault;
use crate::mesh::Mesh;

/// Frames after which tracks are compared with the true paths.
const TRACKED_FRAMES: usize = 10;
/// Tracks begin in these frames.
const FIRST_FRAMES: [usize; 3] = [0, 14, 28];
/// A track on its place is no farther from it, mm.
const ON_PLACE_MM: f64 = 15.0;

/// Centre, left and right of every frame, with the masks.
pub(crate) fn triplets(folder: &Path, last: usize) -> Result<Vec<FrameViews>, Fault> {
    let footage = Recording::open(folder).and_then(|found| found.footage())?;
    let recording = Recording::open(folder).and_then(|found| found.observations())?;
    let mut all = Vec::new();
    for (frame, mut pictures) in footage.frame_sets(0..=last) {
        let mut shown = FrameViews { views: Vec::new(), masks: Vec::new() };
        for camera in [1, 0, 2] {
            let picture = pictures[camera].take().ok_or("no picture")?;
            shown
                .views
                .push(StereoView::undistorted(&footage.rig.cameras[camera], &luma(&picture))?);
            shown.masks.push(recording.load_mask(CameraId(camera), FrameIndex(frame.0))?);
        }
        all.push(shown);
    }
    Ok(all)
}

/// Points of all frames, and tracks, against the true surface.
pub(crate) fn measure(run: &mut Run, folder: &Path) -> Result<(), Fault> {
    let frames = triplets(folder, 39)?;
    points(run, folder, &frames)?;
    tracks(run, folder, &frames)
}

fn tracks(run: &mut Run, folder: &Path, frames: &[FrameViews]) -> Result<(), Fault> {
    let mut counts = [0usize; 5];
    for first in FIRST_FRAMES {
        let [centre, left, right] = &frames[first].views[..] else {
            return Err("three cameras expected".into());
        };
        let mask = frames[first].masks[0].as_ref();
        let found = match_surface(centre, &[left, right], mask, &[], &MatchOptions::default())?;
        let start = Instant::now();
        let mut tracker =
            Tracker::start(first, frames[first].clone(), &found.points, TrackOptions::default())?;
        for next in &frames[first + 1..=first + TRACKED_FRAMES] {
            tracker.advance(next.clone())?;
        }
        let seconds = start.elapsed().as_secs_f64() / TRACKED_FRAMES as f64;
        let all = tracker.finish(25.0);
        let filtered = filter_trajectories(&all, &FilterOptions::default());
        let is_truncated = |(i, t): &&(usize, Trajectory)| t.points.len() < all[*i].points.len();
        let truncated = filtered.iter().filter(is_truncated).count();
        let removed = all.len() - filtered.len();
        let filtered: Vec<Trajectory> = filtered.into_iter().map(|(_, t)| t).collect();
        let raw = on_place(folder, first, &all)?;
        let good = on_place(folder, first, &filtered)?;
        run.say(&format!(
            "tracks from frame {first}: {} begun, {} followed for {TRACKED_FRAMES} frames, {} of them on their place; after the filters {} and {} ({} truncated, {} removed); {seconds:.2} s a frame",
            found.points.len(), raw.0, raw.1, good.0, good.1, truncated, removed
        ));
        for (count, here) in
            counts.iter_mut().zip([found.points.len(), raw.0, raw.1, good.0, good.1])
        {
            *count += here;
        }
    }
    let [begun, followed, _, kept, _] = counts;
    run.number("tracks_on_place_unfiltered", counts[2] as f64 / followed as f64);
    run.number("tracks_on_place", counts[4] as f64 / kept as f64);
    run.number("tracks_kept", kept as f64 / begun as f64);
    run.say(&format!(
        "tracks: on their place {:.1} %, unfiltered {:.1} %",
        100.0 * counts[4] as f64 / kept as f64,
        100.0 * counts[2] as f64 / followed as f64
    ));
    Ok(())
}

/// Trajectories that last, and those whose last point is on the place of the surface where the first one was.
fn on_place(
    folder: &Path,
    first: usize,
    trajectories: &[Trajectory],
) -> Result<(usize, usize), Fault> {
    let mesh = |frame: usize| Mesh::read(&folder.join(format!("surface/{frame:06}.ply")));
    let (before, after) = (mesh(first)?, mesh(first + TRACKED_FRAMES)?);
    let (mut lasting, mut right) = (0, 0);
    for trajectory in trajectories {
        let Some(end) = trajectory.at(first + TRACKED_FRAMES) else {
            continue;
        };
        lasting += 1;
        let place = before.nearest(&trajectory.points[0].position_world).map(|found| found.1);
        let off = place.map(|place| 1000.0 * (after.at(&place) - end.position_world).norm());
        right += usize::from(off.is_some_and(|off| off <= ON_PLACE_MM));
    }
    Ok((lasting, right))
}

fn points(run: &mut Run, folder: &Path, frames: &[FrameViews]) -> Result<(), Fault> {
    let options = MatchOptions { spacing_px: 1, ..MatchOptions::default() };
    let (mut off, mut ratios, mut least) = (Vec::new(), Vec::new(), usize::MAX);
    for (i, shown) in frames.iter().enumerate().step_by(13) {
        let mesh = Mesh::read(&folder.join(format!("surface/{i:06}.ply")))?;
        let start = Instant::now();
        let [centre, left, right] = &shown.views[..] else {
            return Err("three cameras expected".into());
        };
        let found = match_surface(centre, &[left, right], shown.masks[0].as_ref(), &[], &options)?;
        let seconds = start.elapsed().as_secs_f64();
        let mut here = Vec::new();
        for point in &found.points {
            let distance = mesh.nearest(&point.point.position_world).map_or(0.06, |found| found.0);
            let place = point.point.position_world;
            let ray = Unit::new_normalize(place - centre.camera.centre_world());
            here.push(1000.0 * distance);
            if let Some(sigma) = point.point.spread.along(&ray) {
                ratios.push(distance / sigma);
            }
        }
        least = least.min(here.len());
        let (middle, most) = quantiles(&mut here);
        run.say(&format!(
            "frame {i}: {} points of {} pixels ({} without texture), {} seeds, median {middle:.2} mm, 95 % {most:.1} mm, {seconds:.1} s",
            found.points.len(), found.points.len() + found.unmatched, found.without_texture, found.seeds
        ));
        off.append(&mut here);
    }
    let (middle, most) = quantiles(&mut off);
    run.number("person_median_mm", middle);
    run.number("person_95_percent_mm", most);
    run.number("person_least_points", least as f64);
    let (ratio, ratio_95) = quantiles(&mut ratios);
    run.number("person_distance_over_sigma_median", ratio);
    run.number("person_distance_over_sigma_95_percent", ratio_95);
    run.say(&format!(
        "all: median {middle:.2} mm, 95 % {most:.1} mm; over sigma {ratio:.2} and {ratio_95:.1}"
    ));
    Ok(())
}

/// Median and 95 %.
pub(crate) fn quantiles(values: &mut [f64]) -> (f64, f64) {
    values.sort_by(f64::total_cmp);
    let at = |share: f64| {
        values.get((share * values.len() as f64) as usize).copied().unwrap_or(f64::NAN)
    };
    (at(0.5), at(0.95))
}
