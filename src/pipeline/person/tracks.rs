//! People over time: the places of consecutive frames that are one person's.

use std::collections::BTreeMap;

use nalgebra::Point3;

/// Nobody moves faster, m/s: a runner.
const FASTEST: f64 = 5.0;
/// The middle of what is seen of a person jumps by as much from one frame to the next, as parts of them come and go, m.
const JUMP_M: f64 = 0.3;
/// Who is not seen for so long is somebody new, s.
const MEMORY_S: f64 = 1.0;

/// Where a person was seen last.
struct Last {
    time_s: f64,
    place: Point3<f64>,
}

/// For each person, of each frame in which they are seen, which of its places is theirs.
pub(in crate::pipeline) fn tracks(
    places: &[Vec<Point3<f64>>],
    times_s: &[f64],
) -> Vec<BTreeMap<usize, usize>> {
    let mut tracks: Vec<BTreeMap<usize, usize>> = Vec::new();
    let mut lasts: Vec<Last> = Vec::new();
    for (frame, (places, time_s)) in places.iter().zip(times_s).enumerate() {
        // nearest first
        let mut pairs: Vec<(f64, usize, usize)> = Vec::new();
        for (track, last) in lasts.iter().enumerate() {
            let passed_s = time_s - last.time_s;
            let reach_m = JUMP_M + FASTEST * passed_s;
            let off = places.iter().map(|place| (place - last.place).norm());
            let near = off.enumerate().filter(|(_, off)| passed_s <= MEMORY_S && *off < reach_m);
            pairs.extend(near.map(|(place, off)| (off, track, place)));
        }
        pairs.sort_by(|a, b| a.0.total_cmp(&b.0));

        let mut track_of: Vec<Option<usize>> = vec![None; places.len()];
        for (_, track, at) in pairs {
            if track_of[at].is_none() && !track_of.contains(&Some(track)) {
                track_of[at] = Some(track);
            }
        }
        for (at, place) in places.iter().enumerate() {
            let track = track_of[at].unwrap_or(tracks.len());
            let last = Last { time_s: *time_s, place: *place };
            if track == tracks.len() {
                tracks.push(BTreeMap::new());
                lasts.push(last);
            } else {
                lasts[track] = last;
            }
            tracks[track].insert(frame, at);
        }
    }
    tracks
}
