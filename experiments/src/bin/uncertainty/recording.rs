//! One simulated recording, fitted, and how far every number is from its truth.

use experiments::walker::observe;
use maquette::body::{BodyModel, Posed, Shape};
use maquette::inference::propagate::Sequence;
use maquette::inference::search::NoJournal;
use maquette::pipeline::{Fit, FitOptions, FittedFrame, fit, rest_lengths_m};
use maquette::synth::{Recipe, Ring, SegmentationErrors, Synthetic, draw_centres, move_centres};
use nalgebra::{DVector, Vector3};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

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

/// Random stream of the joints' centres; the recipe's own are lower.
const CENTRES: u64 = 4;

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
    let truth = recipe.walker(&individual(&recipe, body, person)?).ok()?;
    let observations = observe(&truth);
    let sequence = Sequence {
        frames: &observations,
        fps: truth.fps,
    };
    let options = FitOptions::default();
    let found = fit(body, &truth.rig, sequence, &options, &NoJournal).ok()?;
    let mut deviations = of_lengths(body, &truth, &found)?;
    for frame in found.frames.iter().step_by(EVERY) {
        deviations.extend(of_frame(body, &truth, frame)?);
    }
    Some(deviations)
}

/// Where publications have joints and points of `walker-metaballs` that was drawn without them, from where it has them, forwards and
/// upwards, metres: elbow .38 of its depth from the back (it is .50), C7/T1 66 mm ahead of the skin behind it (59), C0/C1 15 mm
/// behind the middle of the head (27), shoulder 43 mm below its top (54), tip of the big toe 18 mm above the sole (28), at 1.70 m
/// (docs/anthropometry.md, section 6).
const PUBLISHED_M: [(&str, Axis, f64); 5] = [
    ("forearm_r", FORWARDS, -0.010),
    ("neck", FORWARDS, 0.0075),
    ("head", FORWARDS, 0.013),
    ("upper_arm_r", UPWARDS, 0.011),
    ("RBigToe", UPWARDS, -0.010),
];

/// Of the part.
type Axis = usize;
const FORWARDS: Axis = 0;
const UPWARDS: Axis = 2;

/// The person of this recipe with the joints' centres elsewhere in the flesh, as far as publications leave that open.
///
/// One draw for all frames. `body` holds the standard deviations; its places are not the person's.
fn individual(recipe: &Recipe, body: &BodyModel, person: &BodyModel) -> Option<BodyModel> {
    let shape = recipe.walker(person).ok()?.shape;
    let mut rng = ChaCha8Rng::seed_from_u64(recipe.seed);
    rng.set_stream(CENTRES);
    let published = PUBLISHED_M
        .iter()
        .fold(person.clone(), |person, (name, axis, by_m)| {
            moved(person, &shape, name, *axis, *by_m)
        });
    Some(draw_centres(&published, &shape, body, &mut rng))
}

/// The person with one part's joint, or one point, elsewhere in the flesh, and its mirror image's.
fn moved(mut person: BodyModel, shape: &Shape, name: &str, axis: Axis, by_m: f64) -> BodyModel {
    let parts = person.parts.iter_mut().map(|p| (&p.name, &mut p.sd_m));
    let points = person.points.iter_mut().map(|p| (&p.name, &mut p.sd_m));
    for (one, sd_m) in parts.chain(points) {
        sd_m.fill(0.0);
        if one == name {
            sd_m[axis] = by_m.abs();
        }
    }
    move_centres(&person, shape, &DVector::from_element(1, by_m.signum()))
}

fn deviation(kind: Kind, name: &str, error: f64, sd: f64) -> Deviation {
    Deviation {
        kind,
        name: name.to_owned(),
        z: error / sd,
        sd,
    }
}

fn of_lengths(body: &BodyModel, truth: &Synthetic, found: &Fit) -> Option<Vec<Deviation>> {
    let uncertainty = found.uncertainty.as_ref()?;
    let true_lengths = rest_lengths_m(&truth.model, &truth.shape);
    let lengths = body.lengths.iter().enumerate();
    let of = |(i, (name, _, _)): (usize, &(String, usize, usize))| {
        let j = truth.model.lengths.iter().position(|l| l.0 == *name)?;
        let error = found.lengths_m[i] - true_lengths[j];
        Some(deviation(
            Kind::Length,
            name,
            error,
            uncertainty.lengths_sd_m[i],
        ))
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
