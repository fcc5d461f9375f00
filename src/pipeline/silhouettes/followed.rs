//! What moves in a recording, thing by thing: each is followed through the frames.

use std::cmp::Reverse;
use std::collections::BTreeMap;

use nalgebra::Vector2;

use super::moving::Thing;
use super::pieces::{LEAST_OF_LARGEST, MOST_THINGS};
use super::staying::REACH_M;
use crate::silhouette::{FrameIndex, FrameObservations};

/// What is seen in every frame of each thing that moves, the one that is seen most first; nothing in a frame in which it is not seen.
///
/// A thing goes on as the nearest one of the next frame, no farther than a body reaches. Things of less than [`LEAST_OF_LARGEST`] of
/// the points of the first are left out. Where nothing moves, there is one thing that is never seen.
pub(super) fn followed(frames: Vec<(FrameIndex, Vec<Thing>)>) -> Vec<Vec<FrameObservations>> {
    let numbers: Vec<FrameIndex> = frames.iter().map(|(frame, _)| *frame).collect();
    let mut tracks: Vec<Track> = Vec::new();
    for (frame, mut things) in frames {
        tracks.sort_by_key(|track| Reverse(track.size));
        for track in &mut tracks {
            if let Some(next) = track.next(&things, frame) {
                track.take(things.swap_remove(next), frame);
            }
        }
        tracks.extend(things.into_iter().map(|thing| Track::new(thing, frame)));
    }

    tracks.sort_by_key(|track| Reverse(track.size));
    let most = tracks.first().map_or(0, |track| track.size);
    tracks.retain(|track| track.size as f64 >= LEAST_OF_LARGEST * most as f64);
    tracks.truncate(MOST_THINGS);
    if tracks.is_empty() {
        return vec![numbers.into_iter().map(FrameObservations::nothing).collect()];
    }
    tracks.into_iter().map(|track| track.observed_in(&numbers)).collect()
}

/// A thing in the frames so far.
#[derive(Debug)]
struct Track {
    /// Where and when it was seen last.
    place: Vector2<f64>,
    last: FrameIndex,
    /// How many points of it were seen in all frames.
    size: usize,
    observed: BTreeMap<FrameIndex, FrameObservations>,
}

impl Track {
    fn new(thing: Thing, frame: FrameIndex) -> Self {
        let observed = BTreeMap::from([(frame, thing.observed)]);
        Self { place: thing.place, last: frame, size: thing.size, observed }
    }

    /// Which of the things of a later frame it is.
    fn next(&self, things: &[Thing], frame: FrameIndex) -> Option<usize> {
        let reach = REACH_M * (frame.0 - self.last.0) as f64;
        let far = |i: &usize| (things[*i].place - self.place).norm();
        let near = (0..things.len()).filter(|i| far(i) < reach);
        near.min_by(|a, b| far(a).total_cmp(&far(b)))
    }

    fn take(&mut self, thing: Thing, frame: FrameIndex) {
        self.observed.insert(frame, thing.observed);
        (self.place, self.last) = (thing.place, frame);
        self.size += thing.size;
    }

    fn observed_in(mut self, frames: &[FrameIndex]) -> Vec<FrameObservations> {
        let mut seen = |frame: &FrameIndex| self.observed.remove(frame);
        frames.iter().map(|f| seen(f).unwrap_or_else(|| FrameObservations::nothing(*f))).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A thing at a place, with as many points.
    fn thing(x: f64, size: usize) -> Thing {
        Thing {
            place: Vector2::new(x, 0.0),
            size,
            observed: FrameObservations::nothing(FrameIndex(size)),
        }
    }

    #[test]
    fn two_things_that_pass_each_other_are_two_and_specks_are_none() {
        // one stays, one comes from afar, and grows as it does; now and then there is a speck
        let frames = (0..10).map(|i| {
            let mut things =
                vec![thing(0.1 * (i % 2) as f64, 100), thing(5.0 - 0.4 * i as f64, 150 + i)];
            things.extend((i == 4).then(|| thing(-3.0, 30)));
            (FrameIndex(i), if i == 7 { Vec::new() } else { things })
        });
        let found = followed(frames.collect());
        let sizes =
            |track: &[FrameObservations]| track.iter().map(|o| o.frame.0).collect::<Vec<_>>();
        assert_eq!(found.len(), 2);
        assert_eq!(sizes(&found[0]), [150, 151, 152, 153, 154, 155, 156, 7, 158, 159]);
        assert_eq!(sizes(&found[1]), [100, 100, 100, 100, 100, 100, 100, 7, 100, 100]);
        let nothing = followed(vec![(FrameIndex(3), Vec::new())]);
        assert!(nothing.len() == 1 && nothing[0].len() == 1 && !nothing[0][0].is_observed());
    }
}
