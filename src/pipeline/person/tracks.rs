//! People over time: the groups of consecutive frames that are one person.

use std::collections::BTreeMap;

use nalgebra::Point3;

use super::groups::Group;

/// Nobody moves faster, m/s: a runner.
const FASTEST: f64 = 5.0;
/// The middle of a person's joints jumps by as much from one frame to the next, as some of them come and go, m.
const JUMP_M: f64 = 0.3;
/// Who is not seen for so long is somebody new, s.
const MEMORY_S: f64 = 1.0;

/// Where a person was seen last.
struct Last {
    time_s: f64,
    place: Point3<f64>,
}

/// The group of each frame in which a person is seen, for each person.
pub(super) fn tracks(groups: &[Vec<Group>], times_s: &[f64]) -> Vec<BTreeMap<usize, usize>> {
    let mut tracks: Vec<BTreeMap<usize, usize>> = Vec::new();
    let mut lasts: Vec<Last> = Vec::new();
    for (frame, (groups, time_s)) in groups.iter().zip(times_s).enumerate() {
        let places: Vec<Point3<f64>> = groups.iter().map(|group| group.joints.middle()).collect();

        // nearest first
        let mut pairs: Vec<(f64, usize, usize)> = Vec::new();
        for (track, last) in lasts.iter().enumerate() {
            let passed_s = time_s - last.time_s;
            let reach_m = JUMP_M + FASTEST * passed_s;
            let off = places.iter().map(|place| (place - last.place).norm());
            let near = off.enumerate().filter(|(_, off)| passed_s <= MEMORY_S && *off < reach_m);
            pairs.extend(near.map(|(group, off)| (off, track, group)));
        }
        pairs.sort_by(|a, b| a.0.total_cmp(&b.0));

        let mut track_of: Vec<Option<usize>> = vec![None; groups.len()];
        for (_, track, group) in pairs {
            if track_of[group].is_none() && !track_of.contains(&Some(track)) {
                track_of[group] = Some(track);
            }
        }
        for (group, place) in places.into_iter().enumerate() {
            let track = track_of[group].unwrap_or(tracks.len());
            let last = Last { time_s: *time_s, place };
            if track == tracks.len() {
                tracks.push(BTreeMap::new());
                lasts.push(last);
            } else {
                lasts[track] = last;
            }
            tracks[track].insert(frame, group);
        }
    }
    tracks
}
