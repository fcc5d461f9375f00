//! Bodies that are fitted coarsely to people, and what they say of who is nobody.
//!
//! A camera that is late carves the trunk out of what the masks leave, and two legs remain: two who fill different room, and cover their
//! shares. But one body covers all of the masks, and the borders lie nearer to it than to both of theirs.

use rayon::prelude::*;

use super::{Track, of_everybody, share};
use crate::body::{BodyModel, Posed};
use crate::camera::Rig;
use crate::inference::search::SearchOptions;
use crate::inference::{Evidence, Sequence};
use crate::math::quadric::Ellipsoid;
use crate::math::stats::{mean, median};
use crate::pipeline::diagnosis::LEAST_OVERLAP;
use crate::pipeline::estimate::Estimate;
use crate::pipeline::fit::estimated;
use crate::pipeline::measures::Measures;
use crate::pipeline::quality::sampled_iou;
use crate::pipeline::{EstimateOptions, FitError, Progress};
use crate::silhouette::FrameObservations;

/// Two bodies do not fill the same room: the share of one's ellipsoids whose middle may lie within another, as both are fitted coarsely.
const MOST_INSIDE: f64 = 0.1;
/// Borders lie nearer to the bodies of several people than to that of one by this factor.
const MUCH_NEARER: f64 = 0.5;
/// Keyframes of the bodies that tell whose the borders are.
const KEYFRAMES: usize = 3;

/// A body that was fitted coarsely to each person.
pub(super) struct Bodies<'a> {
    model: &'a BodyModel,
    people: Vec<Estimate>,
}

impl<'a> Bodies<'a> {
    /// A body for each share; else the position of the first to which none can be fitted, as to a thing that is much smaller.
    pub(super) fn fitted(
        model: &'a BodyModel,
        rig: &Rig,
        fps: f64,
        options: &EstimateOptions,
        shares: &[impl AsRef<[FrameObservations]>],
        progress: &dyn Progress,
    ) -> Result<Self, usize> {
        let body = |frames: &[FrameObservations]| {
            let keyframe_every = Some(frames.len().div_ceil(KEYFRAMES));
            let search = SearchOptions { keyframe_every, ..options.search.clone() };
            let coarse = EstimateOptions { joint: None, search, ..options.clone() };
            estimated(model, rig, Sequence { frames, fps }, &coarse, progress)
        };
        let people = shares.iter().enumerate();
        let people = people.map(|(i, frames)| body(frames.as_ref()).map_err(|_| i));
        Ok(Self { model, people: people.collect::<Result<_, _>>()? })
    }

    /// The body of everybody who is there in a frame.
    fn posed(&self, tracks: &[Track], frame: usize) -> Vec<Option<Posed<'_>>> {
        let people = tracks.iter().zip(&self.people);
        let posed = people.map(|(track, body)| {
            let is_there = track.frames.contains_key(&frame);
            is_there.then(|| Posed::new(self.model, &body.shape, &body.frames[frame].motion))
        });
        posed.collect()
    }

    /// Each person's share of the masks, by these bodies.
    pub(super) fn shares(
        &self,
        rig: &Rig,
        sequence: Sequence<'_>,
        tracks: &[Track],
    ) -> Vec<Vec<FrameObservations>> {
        let frames = sequence.frames.par_iter().enumerate();
        let spread = |(i, frame)| share::spread_m(rig, frame, &self.posed(tracks, i));
        let spread_m = median(&mut frames.filter_map(spread).collect()).unwrap_or(f64::INFINITY);
        of_everybody(sequence, tracks.len(), |i, frame| {
            share::by_bodies(rig, frame, &self.posed(tracks, i), spread_m)
        })
    }

    /// The first of who is nobody, if anybody: whose body covers their share too little, or lies within another's.
    pub(super) fn nobody(
        &self,
        rig: &Rig,
        options: &EstimateOptions,
        shares: &[Vec<FrameObservations>],
        tracks: &[Track],
    ) -> Result<Option<usize>, FitError> {
        let (overlaps, inside) = (self.overlaps(rig, options, shares)?, self.inside_others(tracks));
        let is_somebody = |p: &usize| overlaps[*p] >= LEAST_OVERLAP && inside[*p] <= MOST_INSIDE;
        let nobody = (0..tracks.len()).filter(|person| !is_somebody(person));
        let seen = |person: &usize| overlaps[*person] * tracks[*person].frames.len() as f64;
        Ok(nobody.min_by(|a, b| seen(a).total_cmp(&seen(b))))
    }

    /// Whether these bodies explain the masks better than one that is fitted to all of them: it covers them less than a fit must, or the
    /// borders lie much nearer to these.
    pub(super) fn explain_more_than_one(
        &self,
        rig: &Rig,
        sequence: Sequence<'_>,
        tracks: &[Track],
        options: &EstimateOptions,
        progress: &dyn Progress,
    ) -> Result<bool, FitError> {
        let whole = [sequence.frames];
        let Ok(one) = Self::fitted(self.model, rig, sequence.fps, options, &whole, progress) else {
            return Ok(true);
        };
        if one.overlaps(rig, options, &whole)?.iter().any(|overlap| *overlap < LEAST_OVERLAP) {
            return Ok(true);
        }

        let together = |i: &usize| tracks.iter().filter(|t| t.frames.contains_key(i)).count() > 1;
        let frames: Vec<usize> = (0..sequence.frames.len()).filter(together).collect();
        let several = |i: &usize| share::miss_m(rig, &sequence.frames[*i], &self.posed(tracks, *i));
        let alone = |i: &usize| {
            let motion = &one.people[0].frames[*i].motion;
            let body = Posed::new(self.model, &one.people[0].shape, motion);
            share::miss_m(rig, &sequence.frames[*i], &[Some(body)])
        };
        let several = mean(frames.par_iter().filter_map(several).collect::<Vec<f64>>());
        let alone = mean(frames.par_iter().filter_map(alone).collect::<Vec<f64>>());
        Ok(several.zip(alone).is_none_or(|(several, alone)| several < MUCH_NEARER * alone))
    }

    /// The share of each one's ellipsoids whose middle lies within another's body, on the mean over the frames.
    fn inside_others(&self, tracks: &[Track]) -> Vec<f64> {
        let frames = self.people.iter().map(|body| body.frames.len()).max().unwrap_or(0);
        let mut all: Vec<Vec<f64>> = vec![Vec::new(); tracks.len()];
        for frame in 0..frames {
            let ellipsoids = |body: Posed<'_>| body.ellipsoids();
            let bodies = self.posed(tracks, frame).into_iter();
            let bodies: Vec<_> = bodies.map(|body| body.map(ellipsoids)).collect();
            for (person, own) in bodies.iter().enumerate() {
                let Some(own) = own else { continue };
                let others = bodies.iter().enumerate().filter(|(other, _)| *other != person);
                let others: Vec<&Ellipsoid> =
                    others.flat_map(|(_, body)| body.iter().flatten()).collect();
                let is_inside =
                    |e: &&Ellipsoid| others.iter().any(|other| other.contains(&e.centre));
                let inside = own.iter().filter(is_inside).count();
                all[person].push(inside as f64 / own.len().max(1) as f64);
            }
        }
        all.into_iter().map(|shares| mean(shares).unwrap_or(0.0)).collect()
    }

    /// How well each covers their share.
    fn overlaps(
        &self,
        rig: &Rig,
        options: &EstimateOptions,
        shares: &[impl AsRef<[FrameObservations]>],
    ) -> Result<Vec<f64>, FitError> {
        let measure = Measures::choose(self.model, options.measure)?.search;
        let evidence = Evidence::new(self.model, rig, options.likelihood, measure);
        let overlap = |(body, frames): (&Estimate, &[FrameObservations])| {
            let fits: Vec<_> = body.frames.iter().cloned().map(Some).collect();
            sampled_iou(&evidence, frames, &body.shape, &fits).unwrap_or(0.0)
        };
        Ok(self.people.iter().zip(shares.iter().map(AsRef::as_ref)).map(overlap).collect())
    }
}
