//! One simulated recording, fitted, and how far every number is from its truth.

use experiments::individual::individual;
use experiments::walker::observe;
use maquette::body::{BodyModel, Posed};
use maquette::inference::Sequence;
use maquette::inference::search::NoJournal;
use maquette::pipeline::{EstimateOptions, Fit, FittedFrame, fit};
use maquette::synth::{Make, Recipe, Ring, SegmentationErrors, Synthetic};
use nalgebra::Vector3;

/// What a number is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    /// An angle in one frame, or a component of the root's rotation.
    Angle,
    /// A coordinate of a joint centre in one frame.
    Joint,
    /// A length of the body.
    Length,
}

/// How far an estimate is from the truth, in its standard deviations.
#[derive(Debug, Clone)]
pub(crate) struct Deviation {
    pub(crate) kind: Kind,
    pub(crate) name: String,
    pub(crate) z: f64,
    /// Its standard deviation, m or rad.
    pub(crate) sd: f64,
}

/// Frames of a recording, and how many of them lie between two that are looked at.
const FRAMES: usize = 40;
const EVERY: usize = 5;

/// |z| below which a standard normal lies with a probability.
pub(crate) fn quantile(probability: f64) -> f64 {
    use statrs::distribution::{ContinuousCDF, Normal};
    Normal::standard().inverse_cdf(0.5 + 0.5 * probability)
}

/// `None` if nothing could be fitted.
pub(crate) fn deviations(
    body: &BodyModel,
    walker: &BodyModel,
    make: Make,
    seed: u64,
) -> Option<Vec<Deviation>> {
    let recipe = Recipe {
        seed,
        make,
        frames: Some(FRAMES),
        fps: 30.0,
        ring: Ring { cameras: 5, ..Ring::default() },
        errors: Some(SegmentationErrors::MILD),
        stereo: None,
        ..Recipe::default()
    };
    let truth = recipe.walker(&individual(&recipe, body, walker)?).ok()?;
    let observations = observe(&truth);
    let sequence = Sequence { frames: &observations, fps: truth.fps };
    let options = EstimateOptions::default();
    let found = fit(body, &truth.rig, sequence, &options, &NoJournal).ok()?;
    let mut deviations = of_lengths(body, &truth, &found)?;
    for frame in found.frames.iter().step_by(EVERY) {
        deviations.extend(of_frame(body, &truth, frame)?);
    }
    Some(deviations)
}

fn deviation(kind: Kind, name: &str, error: f64, sd: f64) -> Deviation {
    Deviation { kind, name: name.to_owned(), z: error / sd, sd }
}

fn of_lengths(body: &BodyModel, truth: &Synthetic, found: &Fit) -> Option<Vec<Deviation>> {
    let uncertainty = found.uncertainty.as_ref()?;
    let true_lengths = truth.model.rest_lengths_m(&truth.shape);
    let lengths = body.lengths.iter().enumerate();
    let of = |(i, (name, _, _)): (usize, &(String, usize, usize))| {
        let j = truth.model.lengths.iter().position(|l| l.0 == *name)?;
        let error = found.lengths_m[i] - true_lengths[j];
        Some(deviation(Kind::Length, name, error, uncertainty.lengths_sd_m[i]))
    };
    Some(lengths.filter_map(of).collect())
}

fn of_frame(body: &BodyModel, truth: &Synthetic, frame: &FittedFrame) -> Option<Vec<Deviation>> {
    let sd = frame.uncertainty.as_ref()?;
    let person = &truth.model;
    let motion = &truth.motions[frame.frame.0];
    let mut deviations = Vec::new();
    for (i, joint) in body.joints.iter().enumerate() {
        let Some(j) = person.joint(&joint.name) else {
            continue;
        };
        let error = frame.fit.motion.angles[i] - motion.angles[j.0];
        deviations.push(deviation(Kind::Angle, &joint.name, error, sd.angles_sd[i]));
    }
    let points = Posed::new(person, &truth.shape, motion).points();
    for (i, point) in body.points.iter().enumerate() {
        let Some(j) = person.point(&point.name) else {
            continue;
        };
        let error: Vector3<f64> = frame.points_world[i] - points[j];
        let spread = sd.points[i].diagonal().map(f64::sqrt);
        let each = (0..3).map(|k| deviation(Kind::Joint, &point.name, error[k], spread[k]));
        deviations.extend(each);
    }
    Some(deviations)
}
