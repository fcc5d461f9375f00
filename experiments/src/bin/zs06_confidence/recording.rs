//! One simulated recording, the estimate of each keyframe, and the optimum of all.

use experiments::arm::{BarArm, coefficient_of, observe, rig, share_of};
use maquette::body::{BodyModel, Motion, State};
use maquette::inference::frame::{FramePosterior, KeyframePosterior};
use maquette::inference::{Detail, Evidence};
use maquette::likelihood::{EllipseDistance, EllipseOptions, Term};
use maquette::solver::{Loss, Options, levenberg_marquardt};
use maquette::synth::SegmentationErrors;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Frames of a recording, each a keyframe.
const FRAMES: usize = 12;

const ERRORS: SegmentationErrors = SegmentationErrors {
    border_sd_px: 2.0,
    correlation_px: 10.0,
    bites: 0.0,
    holes: 0.0,
    specks: 0.0,
    blot_radius_px: (1.0, 2.0),
};

/// What one recording gave.
pub(crate) struct Estimates {
    /// a of the arm that was seen.
    pub(crate) truth: f64,
    /// a*ₖ of each keyframe.
    pub(crate) keyframes: Vec<f64>,
    /// ā of all frames together.
    pub(crate) optimum: f64,
}

/// Draws an arm and its poses, observes it, and fits every frame and all of them.
pub(crate) fn estimate(model: &BodyModel, seed: u64) -> Estimates {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let thick = rng.random_range(0.09..0.11);
    let arm = BarArm {
        a: rng.random_range(0.42..0.58),
        radii: [thick, thick * rng.random_range(0.9..1.0), thick * rng.random_range(0.8..0.95)],
    };
    let angles: Vec<f64> = (0..FRAMES).map(|_| rng.random_range(0.4..1.2)).collect();
    let rig = rig();
    let frames = observe(&arm, &angles, &rig, &ERRORS, seed);
    // a bar against an ellipse of the same length is off by 3 cm, to one side for half a metre
    let likelihood = EllipseOptions {
        distance: EllipseDistance::Orthogonal,
        sigma_m: 0.03,
        correlation_m: 0.5,
        blend_m: 0.01,
        loss: Loss::Squared,
        ..EllipseOptions::default()
    };
    let evidence = Evidence::with_ellipses(model, &rig, likelihood);
    let terms: Vec<_> = frames.iter().map(|f| evidence.terms(f, Detail::Fine)).collect();
    let starts: Vec<Motion> = angles.iter().map(|phi| bent(model, phi + 0.05)).collect();
    let keyframes = terms.iter().zip(&starts).map(|(t, s)| keyframe(&evidence, t, s)).collect();
    Estimates { truth: arm.a, keyframes, optimum: optimum(&evidence, &terms, &starts) }
}

fn bent(model: &BodyModel, phi: f64) -> Motion {
    let mut motion = Motion::rest(model);
    motion.angles.fill(phi);
    motion
}

/// a of argmax p(φₖ, a | Zₖ) (eq. 2).
fn keyframe(evidence: &Evidence<'_>, terms: &[Box<dyn Term + '_>], start: &Motion) -> f64 {
    let problem = KeyframePosterior {
        model: evidence.model,
        shape_prior: &evidence.shape_prior,
        pose_prior: &evidence.pose_prior,
        terms,
    };
    let state = State { motion: start.clone(), shape: coefficient_of(0.5) };
    share_of(&levenberg_marquardt(&problem, state, &Options::default()).state.shape)
}

/// ā = argmin of −log p(a) + Σᵢ min over φᵢ, by golden sections about the middle.
fn optimum(evidence: &Evidence<'_>, terms: &[Vec<Box<dyn Term + '_>>], starts: &[Motion]) -> f64 {
    let energy = |a: f64| {
        let shape = coefficient_of(a);
        let frame = |(terms, start): (&Vec<Box<dyn Term + '_>>, &Motion)| {
            let model = evidence.model;
            let pose_prior = &evidence.pose_prior;
            let posterior = FramePosterior { model, shape: &shape, pose_prior, step: None, terms };
            levenberg_marquardt(&posterior, start.clone(), &Options::default()).cost
        };
        evidence.shape_prior.cost(&shape) + terms.iter().zip(starts).map(frame).sum::<f64>()
    };
    let golden = 0.5 * (5.0_f64.sqrt() - 1.0);
    let (mut low, mut high) = (0.35, 0.65);
    let mut inner = [high - golden * (high - low), low + golden * (high - low)];
    let mut values = inner.map(energy);
    while high - low > 2e-4 {
        if values[0] < values[1] {
            high = inner[1];
            inner = [high - golden * (high - low), inner[0]];
            values = [energy(inner[0]), values[0]];
        } else {
            low = inner[0];
            inner = [inner[1], low + golden * (high - low)];
            values = [values[1], energy(inner[1])];
        }
    }
    0.5 * (low + high)
}
