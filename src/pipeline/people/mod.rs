//! Several people in masks: who they are, and what of the masks is each one's.
//!
//! # Model
//! Person p has shape s_p and motion m_p. A mask of all of them is the union of what each covers, so its border is where the nearest of all
//! outlines is, min_p d_p(x) = 0, d_p the signed distance to the outline of person p. Whose a border point x is, is hidden; given the
//! bodies, with Student's t of scale σ for how borders lie about outlines,
//!
//! r_p(x) = t_ν(d_p(x)/σ) / Σ_q t_ν(d_q(x)/σ).
//!
//! That is the E step of a mixture; the M step is a fit of each body alone to the border points, each weighted by its r_p. Outside, a
//! body must not stick out of the union. Inside the union, pixels that lie deepest in another's outline are unknown to this person, who
//! may be hidden there. So each person has [observations](FrameObservations) of their own, and the fit is that of one person.
//!
//! # Start
//! 1. The voxels that the masks of a frame leave, seen from above, have a peak for each person (`standing.rs`).
//! 2. Peaks of consecutive frames are one person if nobody had to run faster than 5 m/s for it (`person/tracks.rs`). Who is there for less
//!    than [`LEAST_SHARE`] of the frames is nobody. Where two who were apart before and after have one peak, each voxel is the nearer's.
//! 3. Each one's share of the masks is what only their voxels show; to it a body is fitted, by Algorithm 1 with few keyframes.
//! 4. These bodies give r; σ is 1.48 times the median of min_p |d_p|. To whom no body can be fitted, whose body covers their share less than a fit must, or lies within another's
//!    body, is nobody: a thing, or a leg far ahead of its trunk. The others are fitted anew. Nobody is several whom one body explains as well (`bodies.rs`).
//!
//! Masks with a value for each person need none of this: a value is a person in all cameras ([`by_labels`]).
//!
//! # Who is measured
//! The one who is in view longest; of several, the one who crosses the room; of several, the smallest: beside a child walks a parent.

mod bodies;
mod room;
mod share;
mod standing;

pub use share::by_labels;

use std::collections::BTreeMap;

use nalgebra::Point3;
use rayon::prelude::*;

use self::bodies::Bodies;
use self::room::Room;
use self::standing::Standing;
use super::diagnosis::WithoutRods;
use super::person::tracks;
use super::{EstimateOptions, FitError, Progress};
use crate::body::BodyModel;
use crate::camera::Rig;
use crate::inference::Sequence;
use crate::inference::hull::{has_depth, lines_of_sight};
use crate::math::stats::median;
use crate::silhouette::FrameObservations;

/// Who is in view for less than this share of the frames is nobody.
pub const LEAST_SHARE: f64 = 0.2;
/// Two people are in view equally long, or walk equally far, from this ratio on.
const EQUAL: f64 = 0.8;
/// Before they are first seen, and after they are last seen, people are expected for so long, on the line of so long, s.
const REACH_S: f64 = 0.6;
const STEADY_S: f64 = 0.2;

/// One person over time: what they fill in each frame.
struct Track {
    /// Position of the frame → the person of that frame.
    frames: BTreeMap<usize, Standing>,
}

/// Each person's share of a sequence of masks, the one who is measured first, without detections and points; empty if the masks show one
/// person, or if nothing tells. At most `most` are looked for.
///
/// # Errors
/// As [`fit`](super::fit).
pub fn people(
    model: &BodyModel,
    rig: &Rig,
    sequence: Sequence<'_>,
    options: &EstimateOptions,
    most: Option<usize>,
    progress: &dyn Progress,
) -> Result<Vec<Vec<FrameObservations>>, FitError> {
    let may_tell = |frame: &FrameObservations| has_depth(&lines_of_sight(rig, frame));
    if most == Some(1) || !sequence.frames.iter().any(may_tell) {
        return Ok(Vec::new());
    }
    let without_rods = WithoutRods::new(rig, sequence.frames.into());
    let standing = Sequence { frames: &without_rods.frames, ..sequence };
    let Some(room) = Room::new(rig, standing.frames) else { return Ok(Vec::new()) };

    // 1., 2. who stands where, and who they are
    let mut tracks = tracked(&room, rig, standing, most);
    while tracks.len() > 1 {
        // 3. a body of each
        let shares = of_everybody(sequence, tracks.len(), |i, frame| {
            let voxels = tracks.iter().map(|track| track.frames.get(&i));
            let voxels: Vec<_> = voxels.map(|own| own.map(|s| s.voxels.as_slice())).collect();
            share::by_voxels(&room, rig, frame, &voxels)
        });
        let bodies = match Bodies::fitted(model, rig, sequence.fps, options, &shares, progress) {
            Ok(bodies) => bodies,
            Err(nobody) => {
                remove(nobody, &room, &mut tracks);
                continue;
            }
        };

        // 4. whose the borders are, and who is nobody
        let shares = bodies.shares(rig, sequence, &tracks);
        match bodies.nobody(rig, options, &shares, &tracks)? {
            Some(nobody) => remove(nobody, &room, &mut tracks),
            None if bodies.explain_more_than_one(rig, sequence, &tracks, options, progress)? => {
                return Ok(measured_first(&tracks, shares));
            }
            None => break,
        }
    }
    Ok(Vec::new())
}

/// Takes one for nobody: what they filled is the others'.
fn remove(nobody: usize, room: &Room, tracks: &mut Vec<Track>) {
    let nobody = tracks.remove(nobody);
    nobody.give(room, tracks);
}

/// The shares of everybody in all frames, person by person.
fn of_everybody(
    sequence: Sequence<'_>,
    people: usize,
    shares: impl Fn(usize, &FrameObservations) -> Vec<FrameObservations> + Sync,
) -> Vec<Vec<FrameObservations>> {
    let frames = sequence.frames.par_iter().enumerate();
    let frames: Vec<Vec<FrameObservations>> = frames.map(|(i, frame)| shares(i, frame)).collect();
    let mut all: Vec<Vec<FrameObservations>> = vec![Vec::new(); people];
    for frame in frames {
        for (own, share) in all.iter_mut().zip(frame) {
            own.push(share);
        }
    }
    all
}

/// The people of a sequence, the one who is measured first.
fn tracked(room: &Room, rig: &Rig, sequence: Sequence<'_>, most: Option<usize>) -> Vec<Track> {
    let frames = sequence.frames.par_iter();
    let standing: Vec<Vec<Standing>> =
        frames.map(|frame| standing::standing(room, rig, frame)).collect();
    let places: Vec<Vec<Point3<f64>>> =
        standing.iter().map(|people| people.iter().map(|p| p.place).collect()).collect();
    let times_s: Vec<f64> =
        sequence.frames.iter().map(|f| f.frame.0 as f64 / sequence.fps).collect();
    let shown = sequence.frames.iter().filter(|frame| frame.views.len() >= 2).count();

    let mut found = tracks(&places, &times_s);
    found.retain(|track| track.len() as f64 >= LEAST_SHARE * shown as f64);
    found.sort_by_key(|track| std::cmp::Reverse(track.len()));
    found.truncate(most.unwrap_or(usize::MAX));
    let of_track = |track: &BTreeMap<usize, usize>| Track {
        frames: track.iter().map(|(i, at)| (*i, standing[*i][*at].clone())).collect(),
    };
    let mut people: Vec<Track> = found.iter().map(of_track).collect();
    if people.len() > 1 {
        part_merged(room, &mut people, &standing, &times_s);
    }
    people
}

/// Where one who is in view about a frame has no place of their own in it, but is somewhere in what is seen, parts the voxels of all by who is
/// nearer.
fn part_merged(room: &Room, people: &mut [Track], standing: &[Vec<Standing>], times_s: &[f64]) {
    let seen: Vec<BTreeMap<usize, Point3<f64>>> = people.iter().map(Track::places).collect();
    for (i, of_frame) in standing.iter().enumerate() {
        let shown: Vec<usize> = of_frame.iter().flat_map(|s| s.voxels.iter().copied()).collect();
        let place = |seen: &BTreeMap<usize, Point3<f64>>| {
            let place = expected(seen, times_s, i)?;
            standing::is_filled(room, &shown, &place).then_some(place)
        };
        let places: Vec<Option<Point3<f64>>> = seen.iter().map(place).collect();
        let is_merged = |person: usize| places[person].is_some() && !seen[person].contains_key(&i);
        if !(0..people.len()).any(is_merged) {
            continue;
        }

        let mut voxels: Vec<Vec<usize>> = vec![Vec::new(); people.len()];
        for voxel in shown {
            let there = places.iter().enumerate();
            let there = there.filter_map(|(person, place)| Some((person, (*place)?)));
            let person = standing::nearest(room, voxel, there);
            person.into_iter().for_each(|person| voxels[person].push(voxel));
        }
        for (track, voxels) in people.iter_mut().zip(voxels) {
            if !voxels.is_empty() {
                track.frames.insert(i, Standing::new(room, voxels));
            }
        }
    }
}

/// Where a person is in a frame: seen there, between where they were before and after, or on from where they were within [`REACH_S`].
fn expected(
    seen: &BTreeMap<usize, Point3<f64>>,
    times_s: &[f64],
    frame: usize,
) -> Option<Point3<f64>> {
    let along = |(i, a): (&usize, &Point3<f64>), (j, b): (&usize, &Point3<f64>)| {
        let part = (times_s[frame] - times_s[*i]) / (times_s[*j] - times_s[*i]);
        if i == j { *a } else { a + (b - a) * part }
    };
    let apart_s = |i: usize, j: usize| (times_s[i] - times_s[j]).abs();
    let (before, after) = (seen.range(..=frame).next_back(), seen.range(frame..).next());
    match (before, after) {
        (Some(before), Some(after)) => Some(along(before, after)),
        (None, Some(first)) if apart_s(frame, *first.0) <= REACH_S => {
            let steady = seen.iter().take_while(|(i, _)| apart_s(**i, *first.0) < STEADY_S);
            steady.last().map(|later| along(first, later))
        }
        (Some(last), None) if apart_s(frame, *last.0) <= REACH_S => {
            let steady = seen.iter().rev().take_while(|(i, _)| apart_s(**i, *last.0) < STEADY_S);
            steady.last().map(|earlier| along(earlier, last))
        }
        _ => None,
    }
}

impl Track {
    fn places(&self) -> BTreeMap<usize, Point3<f64>> {
        self.frames.iter().map(|(frame, standing)| (*frame, standing.place)).collect()
    }

    fn presence(&self) -> Presence {
        let ends = self.frames.values().next().zip(self.frames.values().next_back());
        let heights = self.frames.values().map(|standing| standing.height_m);
        Presence {
            frames: self.frames.len(),
            path_m: ends.map_or(0.0, |(first, last)| (last.place - first.place).xy().norm()),
            height_m: median(&mut heights.collect()).unwrap_or(0.0),
        }
    }

    /// Gives all that they fill to the nearest of others.
    fn give(self, room: &Room, others: &mut [Self]) {
        for (frame, standing) in self.frames {
            let mut there: Vec<&mut Standing> =
                others.iter_mut().filter_map(|other| other.frames.get_mut(&frame)).collect();
            standing.voxels.into_iter().for_each(|voxel| standing::give(room, voxel, &mut there));
        }
    }
}

/// The shares of the one who is measured before those of the others.
fn measured_first(
    people: &[Track],
    mut shares: Vec<Vec<FrameObservations>>,
) -> Vec<Vec<FrameObservations>> {
    let measured = measured(&people.iter().map(Track::presence).collect::<Vec<_>>());
    shares[..=measured].rotate_right(1);
    shares
}

/// What tells who is measured.
pub(super) struct Presence {
    /// In how many frames they are seen.
    pub(super) frames: usize,
    /// How far they walk, from one end of the recording to the other.
    pub(super) path_m: f64,
    pub(super) height_m: f64,
}

/// Who of several people is measured; 0 of nobody.
pub(super) fn measured(people: &[Presence]) -> usize {
    let mut rest: Vec<usize> = (0..people.len()).collect();
    let mut keep = |value: fn(&Presence) -> f64| {
        let most = rest.iter().map(|p| value(&people[*p])).fold(0.0, f64::max);
        rest.retain(|p| value(&people[*p]) >= EQUAL * most);
    };
    keep(|presence| presence.frames as f64);
    keep(|presence| presence.path_m);
    let height = |p: &usize| people[*p].height_m;
    rest.into_iter().min_by(|a, b| height(a).total_cmp(&height(b))).unwrap_or(0)
}

#[cfg(test)]
mod tests;
