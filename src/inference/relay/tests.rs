use std::path::Path;

use super::*;
use crate::camera::CameraId;
use crate::inference::Sequence;
use crate::inference::hypothesis::{Hypothesis, Origin};
use crate::inference::propagate::TrackOptions;
use crate::inference::start::StartOptions;
use crate::io::model;
use crate::likelihood::{LikelihoodOptions, Measure};
use crate::silhouette::{FrameIndex, FrameObservations, SilhouetteOptions, extract};
use crate::synth::{Recipe, Ring, Synthetic};

const FRAMES: usize = 14;
/// From this frame on the winner has lost a shank.
const LOST_FROM: usize = 8;
/// How far its knee is bent too much, radians.
const BENT: f64 = 1.5;

fn walker() -> (Synthetic, Vec<FrameObservations>) {
    let person = model::load("walker-metaballs", Path::new("")).unwrap();
    let ring = Ring { width_px: 320, height_px: 240, focal_px: 250.0, ..Ring::default() };
    let recipe = Recipe { frames: Some(FRAMES), fps: 25.0, ring, ..Recipe::default() };
    let walker = recipe.walker(&person).unwrap();
    let shown = |number: usize| {
        let mut seen = FrameObservations::nothing(FrameIndex(number));
        for (id, camera) in walker.rig.iter() {
            let mask = walker.mask(seen.frame, id).unwrap();
            let silhouette = extract(&mask, camera, &SilhouetteOptions::default());
            seen.views.extend(silhouette.ok().map(|s| -> (CameraId, _) { (id, s) }));
        }
        seen
    };
    let frames = (0..FRAMES).map(shown).collect();
    (walker, frames)
}

/// A trial of the true shape from its first frame, of some motions.
fn trial(tracking: &Tracking<'_>, motions: Vec<Option<Motion>>) -> Trial {
    let Tracking { evidence, sequence, shape, .. } = *tracking;
    let Evidence { model, pose_prior, .. } = evidence;
    let fit = |(i, motion): (usize, Option<Motion>)| {
        let terms = evidence.terms(&sequence.frames[i], Detail::Fine);
        let posterior = FramePosterior { model, shape, pose_prior, step: None, terms: &terms };
        Some(solve(&posterior, motion?, 0))
    };
    let hypothesis = Hypothesis {
        origin: Origin::Keyframe(0),
        keyframe: 0,
        shape: shape.clone(),
        motion: motions.iter().flatten().next().unwrap().clone(),
        keyframe_cost: 0.0,
    };
    let mut trial = Trial {
        hypothesis,
        shape_cost: 0.0,
        frames: motions.into_iter().enumerate().map(fit).collect(),
    };
    if let Some(own) = trial.frames.iter().map(Option::as_ref).collect::<Option<Vec<_>>>() {
        let choices = Choices { tracking, own, others: BTreeMap::new() };
        trial.frames = choices.with_steps(choices.most_probable(), 0);
    }
    trial
}

#[test]
fn a_lost_shank_is_found_in_another_hypothesis_and_from_the_poses_of_other_frames() {
    let (walker, frames) = walker();
    let options = LikelihoodOptions::default();
    let evidence = Evidence::new(&walker.model, &walker.rig, options, Measure::Metaballs);
    let tracking = Tracking {
        evidence: &evidence,
        sequence: Sequence { frames: &frames, fps: walker.fps },
        shape: &walker.shape,
        options: &TrackOptions::default(),
        start: &StartOptions::default(),
    };
    let knee = walker.model.joints.iter().position(|j| j.name == "knee_flexion_r").unwrap();
    let lost = |(i, motion): (usize, &Motion)| {
        let mut motion = motion.clone();
        motion.angles[knee] += if i < LOST_FROM { 0.0 } else { BENT };
        Some(motion)
    };
    let winner = trial(&tracking, walker.motions.iter().enumerate().map(lost).collect());
    let beyond = |(i, motion): (usize, &Motion)| (i >= LOST_FROM).then(|| motion.clone());
    let other = trial(&tracking, walker.motions.iter().enumerate().map(beyond).collect());

    for trials in [vec![winner.clone(), other], vec![winner.clone()]] {
        let found = relayed(&tracking, &trials, 0).expect("the shank is lost");
        assert!(found.energy() < 0.7 * winner.energy(), "{} {}", found.energy(), winner.energy());
        for (i, (fit, truth)) in found.frames.iter().flatten().zip(&walker.motions).enumerate() {
            let off = fit.motion.angles[knee] - truth.angles[knee];
            assert!(off.abs() < 0.15, "frame {i}: {off}");
        }
    }

    let right = trial(&tracking, walker.motions.iter().cloned().map(Some).collect());
    assert!(relayed(&tracking, &[right], 0).is_none(), "nothing is lost");
}
