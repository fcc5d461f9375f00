//! One simulated recording, fitted, and how far every number is from its truth.

use experiments::walker::observe;
use maquette::body::{BodyModel, Posed};
use maquette::inference::propagate::Sequence;
use maquette::inference::search::NoJournal;
use maquette::pipeline::{FitOptions, fit, rest_lengths_m};
use maquette::synth::{Recipe, Ring, SegmentationErrors};
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
    person: &BodyModel,
    seed: u64,
) -> Option<Vec<Deviation>> {
    let recipe = Recipe {
        seed,
        frames: Some(FRAMES),
        fps: 30.0,
        ring: Ring {
            cameras: 5,
            ..Ring::default()
        },
        errors: Some(SegmentationErrors::MILD),
        stereo: None,
    };
    let truth = recipe.walker(person).ok()?;
    let observations = observe(&truth);
    let sequence = Sequence {
        frames: &observations,
        fps: truth.fps,
    };
    let found = fit(
        body,
        &truth.rig,
        sequence,
        &FitOptions::default(),
        &NoJournal,
    )
    .ok()?;
    let mut deviations = Vec::new();
    let mut add = |kind, name: &str, error: f64, sd: f64| {
        deviations.push(Deviation {
            kind,
            name: name.to_owned(),
            z: error / sd,
            sd,
        });
    };
    // lengths
    let uncertainty = found.uncertainty.as_ref()?;
    let true_lengths = rest_lengths_m(person, &truth.shape);
    for (i, (name, _, _)) in body.lengths.iter().enumerate() {
        let Some(j) = person.lengths.iter().position(|l| l.0 == *name) else {
            continue;
        };
        add(
            Kind::Length,
            name,
            found.lengths_m[i] - true_lengths[j],
            uncertainty.lengths_sd_m[i],
        );
    }
    for frame in found.frames.iter().step_by(EVERY) {
        let sd = frame.uncertainty.as_ref()?;
        let motion = &truth.motions[frame.frame.0];
        // angles
        for (i, joint) in body.joints.iter().enumerate() {
            let Some(j) = person.joint(&joint.name) else {
                continue;
            };
            add(
                Kind::Angle,
                &joint.name,
                frame.fit.motion.angles[i] - motion.angles[j.0],
                sd.angles_sd[i],
            );
        }
        // joint centres
        let points = Posed::new(person, &truth.shape, motion).points();
        for (i, point) in body.points.iter().enumerate() {
            let Some(j) = person.point(&point.name) else {
                continue;
            };
            let error: Vector3<f64> = frame.points_world[i] - points[j];
            for k in 0..3 {
                add(
                    Kind::Joint,
                    &point.name,
                    error[k],
                    sd.points[i][(k, k)].sqrt(),
                );
            }
        }
    }
    Some(deviations)
}
