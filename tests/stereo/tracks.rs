//! Points of a wall that moves are followed; what is false is filtered.

use maquette::stereo::matching::{MatchOptions, match_surface};
use maquette::stereo::tracking::{
    FilterOptions, FrameViews, TrackOptions, Tracker, Trajectory, filter_trajectories,
};
use maquette::stereo::{CloudPoint, Spread};
use nalgebra::{Point3, Vector3};

use crate::scene::{Wall, three};

const FPS: f64 = 25.0;

fn shown(shift: Vector3<f64>) -> FrameViews {
    let wall = Wall { shift };
    let [left, middle, right] = three();
    FrameViews {
        views: [middle, left, right].map(|c| wall.view(&c)).to_vec(),
        masks: vec![None; 3],
    }
}

#[test]
fn points_of_a_moving_wall_keep_their_place_on_it_and_have_its_velocity() {
    let step = Vector3::new(0.02, 0.01, -0.015);
    let first = shown(Vector3::zeros());
    let options = MatchOptions { spacing_px: 5, least_region: 0, ..MatchOptions::default() };
    let [middle, left, right] = &first.views[..] else { panic!("three views") };
    let found = match_surface(middle, &[left, right], None, &[], &options).unwrap();
    let mut tracker =
        Tracker::start(7, first.clone(), &found.points, TrackOptions::default()).unwrap();
    for frame in 1..=4 {
        tracker.advance(shown(step * f64::from(frame))).unwrap();
    }
    assert!(
        tracker.followed() * 2 > found.points.len(),
        "{} of {}",
        tracker.followed(),
        found.points.len()
    );
    let trajectories = tracker.finish(FPS);
    let filtered = filter_trajectories(
        &trajectories,
        &FilterOptions { neighbourhood: 0.2, ..FilterOptions::default() },
    );
    let lasting: Vec<&Trajectory> =
        filtered.iter().map(|(_, t)| t).filter(|t| t.points.len() == 5).collect();
    assert!(lasting.len() > 50, "{}", lasting.len());
    let mut off: Vec<f64> = lasting
        .iter()
        .map(|t| {
            (t.at(11).unwrap().position_world - t.points[0].position_world - step * 4.0).norm()
        })
        .collect();
    off.sort_by(f64::total_cmp);
    assert!(off[off.len() / 2] < 0.01, "{}", off[off.len() / 2]);
}

/// A trajectory along x, with an extra place from `from` on.
#[test]
fn a_point_that_a_small_patch_loses_is_followed_by_a_larger_one() {
    let first = shown(Vector3::zeros());
    let options = MatchOptions { spacing_px: 10, least_region: 0, ..MatchOptions::default() };
    let [middle, left, right] = &first.views[..] else { panic!("three views") };
    let found = match_surface(middle, &[left, right], None, &[], &options).unwrap();
    let followed = |larger_radius_px| {
        let options = TrackOptions { radius_px: 2, larger_radius_px, ..TrackOptions::default() };
        let mut tracker = Tracker::start(0, first.clone(), &found.points, options).unwrap();
        tracker.advance(shown(Vector3::new(0.02, 0.0, 0.0))).unwrap();
        tracker.followed()
    };
    let (small, larger) = (followed(2), followed(6));
    assert!(larger > small, "{small} and {larger}");
}

fn path(y: f64, speed: f64, from: usize, extra: f64) -> Trajectory {
    let point = |i: usize| CloudPoint {
        position_world: Point3::new(
            speed * i as f64 / FPS + if i >= from { extra } else { 0.0 },
            y,
            0.0,
        ),
        spread: Spread::Unknown,
    };
    Trajectory::new(0, &(0..8).map(point).collect::<Vec<_>>(), FPS)
}

#[test]
fn a_jump_is_truncated_and_a_point_that_moves_alone_is_removed() {
    let mut trajectories: Vec<Trajectory> =
        (0..12).map(|i| path(0.01 * i as f64, 1.0, 99, 0.0)).collect();
    // faster than a body
    trajectories.push(path(0.05, 1.0, 6, 1.0));
    // other than its neighbours
    trajectories.push(path(0.055, -1.0, 99, 0.0));
    let filtered = filter_trajectories(&trajectories, &FilterOptions::default());
    assert!(filtered.iter().map(|(index, _)| *index).eq(0..13));
    let lengths: Vec<usize> = filtered.iter().map(|(_, t)| t.points.len()).collect();
    assert!((3..6).contains(&lengths[12]) && lengths[..12] == [8; 12], "{lengths:?}");
}

#[test]
fn a_point_without_neighbours_is_not_believed_unless_none_are_asked_for() {
    let alone = [path(0.0, 1.0, 99, 0.0)];
    assert_eq!(filter_trajectories(&alone, &FilterOptions::default()).len(), 0);
    let options = FilterOptions { least_neighbours: 0, ..FilterOptions::default() };
    assert_eq!(filter_trajectories(&alone, &options).len(), 1);
    assert_eq!(filter_trajectories(&[], &options).len(), 0);
}

#[test]
fn another_number_of_cameras_than_before_is_refused() {
    let mut tracker =
        Tracker::start(0, shown(Vector3::zeros()), &[], TrackOptions::default()).unwrap();
    let mut fewer = shown(Vector3::zeros());
    fewer.views.pop();
    let message = tracker.advance(fewer).unwrap_err().to_string();
    assert!(message.contains("1 images beside the template: expected 2"), "{message}");
}
