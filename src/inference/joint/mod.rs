//! The joint optimum: every motion and the shape at once, and how sure each number is.
//!
//! ZS06 (§ on the model, before eq. 1) call the optimum of all of θ "technically intractable". With the shape as border, the Gauss–Newton
//! matrix of eq. 1 is block-tridiagonal (block-pentadiagonal with constant velocity), and a step is one pass
//! forwards and one backwards: O(n). Algorithm 1's winner is its start.
//!
//! With a detailed body ([`BodyModel::detailed`](crate::body::BodyModel::detailed)) s also says where the joints lie in the flesh
//! and how far the surface lies outside the model's. Where cameras are not trusted, their places, focal lengths and clocks are unknowns too
//! ([`CameraPrior`]). How much the data count ([`Noise`], [`Contrasts`]), how far surfaces lie outside (`spread`) and how motions accelerate
//! (`accelerations.rs`) are estimated by turns with the optimum: first in some rounds of a few steps before a part of the border points, then
//! before all of them until E no longer falls ([`Rounds`]). The covariance follows from the last optimum's matrix and from what of the residuals
//! stays from frame to frame (`repeated_error.rs`).

mod options;

use std::ops::Range;

use nalgebra::DVector;

pub use options::{Differences, JointOptions, Rounds};

use super::camera_offset::CameraOffset;
use super::camera_prior::CameraPrior;
use super::contrasts::{Contrasts, Leverages};
use super::covariance::Uncertainty;
use super::frame::FrameFit;
use super::instant::{times_s, trials};
use super::looks::ClearLooks;
use super::motion_prior::MotionPrior;
use super::noise::{DataWeights, Noise};
use super::prior::ShapePrior;
use super::repeated_error::RepeatedError;
use super::sequence_posterior::SequencePosterior;
use super::sequence_state::SequenceState;
use super::spread::with_spreads;
use super::{Evidence, Look, Sequence, SequenceTerms};
use crate::body::Shape;
use crate::solver::{BorderedChain, Options, Problem, Report, Solution, levenberg_marquardt};

/// The joint optimum.
#[derive(Debug, Clone)]
pub struct JointOptimum {
    /// s.
    pub shape: Shape,
    /// m₁..ₙ and what each costs.
    pub frames: Vec<FrameFit>,
    /// By how much each camera is off, in the order of the rig; empty where they were trusted.
    pub cameras: Vec<CameraOffset>,
    /// How the residuals err.
    pub noise: Noise,
    /// p(m₁..ₙ), with accelerations as they are in this recording.
    pub motion_prior: MotionPrior,
    /// How sure they are; `None` where the matrix is singular.
    pub uncertainty: Option<Uncertainty>,
    /// How the optimisation went.
    pub report: Report,
}

impl JointOptimum {
    /// Of a body that has only the first so many coefficients of s.
    #[must_use]
    pub fn of_first(mut self, coefficients: usize) -> Self {
        self.shape = self.shape.first(coefficients);
        if let Some(uncertainty) = &mut self.uncertainty {
            let all = &mut uncertainty.shape.covariance;
            *all = all.view((0, 0), (coefficients, coefficients)).into_owned();
        }
        self
    }

    /// What it says of one of the trials that it is of: of some frames and some cameras.
    #[must_use]
    pub fn of_trial(&self, frames: Range<usize>, cameras: Range<usize>) -> Self {
        let part = |uncertainty: &Uncertainty| Uncertainty {
            shape: uncertainty.shape.clone(),
            frames: uncertainty.frames[frames.clone()].to_vec(),
            cameras: uncertainty.of_cameras(cameras.clone()),
        };
        let known = cameras.start..cameras.end.min(self.cameras.len());
        Self {
            shape: self.shape.clone(),
            frames: self.frames[frames.clone()].to_vec(),
            cameras: self.cameras.get(known).map(<[_]>::to_vec).unwrap_or_default(),
            noise: self.noise,
            motion_prior: self.motion_prior.clone(),
            uncertainty: self.uncertainty.as_ref().map(part),
            report: self.report.clone(),
        }
    }

    /// s and m₁..ₙ.
    pub fn state(&self) -> SequenceState {
        SequenceState {
            shape: self.shape.clone(),
            motions: self.frames.iter().map(|f| f.motion.clone()).collect(),
            cameras: self.cameras.clone(),
        }
    }
}

/// The fraction of E below which a step's decrease ends the optimisation.
///
/// Under its own posterior, E of n frames of m components has a standard deviation of √(nm/2), 65 for 200 frames of a
/// body, and E itself is about a thousand: this fraction of it is two units. Lines of sight that come to touch another summit of
/// a limb's field make E jump by a tenth of that.
const TOLERANCE: f64 = 2e-3;
/// The same of the rounds before the last, whose optimum is only where the noise is estimated anew.
const ROUGHLY: f64 = 1e-2;
/// The first λ of a round.
const DAMPING: f64 = 1e-4;

/// The joint optimum of a sequence before cameras that are trusted, from a first shape and motion.
pub fn joint_optimum(
    evidence: &Evidence<'_>,
    sequence: Sequence<'_>,
    start: SequenceState,
    options: &JointOptions,
) -> JointOptimum {
    let terms = evidence.sequence_terms(sequence, CameraPrior::trusting());
    joint_optimum_from_terms(evidence, &terms, &sequence.intervals_s(), start, options, &|| {})
}

/// The joint optimum of what each frame shows; `seconds[i]` lie between frames i − 1 and i, infinitely many where another trial
/// begins ([`chain`](super::chain)): trials share s, and the cameras that `terms` says are the same. `step` is called
/// [`JointOptions::most_steps`] times at most, the last time when all is done.
pub fn joint_optimum_from_terms<'a>(
    evidence: &Evidence<'_>,
    terms: &SequenceTerms<'a>,
    seconds: &[f64],
    start: SequenceState,
    options: &JointOptions,
    step: &dyn Fn(),
) -> JointOptimum {
    let model = evidence.model;
    let motion_prior = MotionPrior::new(model, options.motion_model);
    let priors = Priors { shape: evidence.shape_prior.clone(), motion: motion_prior.clone() };
    let search = Search {
        evidence,
        seconds,
        motion_prior,
        camera_prior: &terms.camera_prior,
        differences: options.differences,
        step,
    };
    let mut state = start.detailed(model);
    state.cameras.resize(terms.camera_prior.cameras(), CameraOffset::none());

    // how the residuals err, the optimum, how far surfaces lie outside and how motions accelerate, by turns
    let mut from = Approached { state, priors, leverages: Leverages::new() };
    for &max_iterations in options.rounds.approach() {
        let solver = Options { max_iterations, damping: DAMPING, relative_decrease: ROUGHLY };
        let round = search.round(&terms.thinned, from, &solver);
        from = search.approached(round);
    }

    let solver = Options {
        max_iterations: options.iterations,
        damping: DAMPING,
        relative_decrease: TOLERANCE,
    };
    let looks = options.rounds.last(terms);
    let round = search.round(looks, from, &solver);
    let uncertainty = search.uncertainty(&round);
    let Round { noise, priors, solution, .. } = round;
    let frames = search.frame_fits(looks, &priors, &solution.state);
    step();
    JointOptimum {
        frames,
        noise,
        motion_prior: priors.motion,
        uncertainty,
        cameras: solution.state.cameras,
        shape: solution.state.shape,
        report: solution.report,
    }
}

/// What the rounds have in common.
struct Search<'a, 'b> {
    evidence: &'a Evidence<'b>,
    seconds: &'a [f64],
    /// With the published densities of accelerations.
    motion_prior: MotionPrior,
    camera_prior: &'a CameraPrior,
    differences: Differences,
    step: &'a dyn Fn(),
}

/// What is known before any data but for their scales, which the recording tells.
struct Priors {
    /// p(s) with surfaces that lie as far outside as they do.
    shape: ShapePrior,
    /// p(m₁..ₙ) with accelerations as they are.
    motion: MotionPrior,
}

/// What the rounds before have found.
struct Approached {
    state: SequenceState,
    priors: Priors,
    /// How far the state follows the contrasts.
    leverages: Leverages,
}

/// An optimum, and the noise with which it was sought.
struct Round<'l> {
    /// What it looked at.
    looks: Vec<Vec<Look<'l>>>,
    noise: Noise,
    /// ν: how many independent observations that is.
    independent: f64,
    priors: Priors,
    contrasts: Contrasts,
    solution: Solution<SequenceState, BorderedChain>,
}

impl Search<'_, '_> {
    /// The optimum with residuals that err as they do at its start, of what tells there what it shows.
    fn round<'l>(
        &self,
        looks: &'l [Vec<Look<'_>>],
        from: Approached,
        solver: &Options,
    ) -> Round<'l> {
        let Approached { state: start, priors, leverages } = from;
        let whole = self.within(looks, &start);
        let none = Contrasts::none(looks.len());
        let of_all = self.posterior(&whole, &priors, &none);
        let clear = ClearLooks::new(&whole, &of_all.bodies(&start));
        let noise = Noise::from_residuals(&clear.residuals);

        let looks = self.within(&clear.looks, &start);
        let mut posterior = self.posterior(&looks, &priors, &none);
        posterior.weights = noise.weights();
        let motion_prior = priors.motion.beside(noise.staying_share(), self.seconds);
        posterior.motion_prior = &motion_prior;
        // a fold looks alike to cameras side by side
        let (model, of_lines) = (self.evidence.model, posterior.weights.outlines);
        let contrasts = match self.differences {
            Differences::Counted => Contrasts::new(model, &whole, &start, &leverages, of_lines),
            Differences::LeftOut => none.clone(),
        };
        posterior.contrasts = &contrasts;

        let counted = Counted { problem: &posterior, step: self.step };
        let solution = levenberg_marquardt(&counted, start, solver);
        let independent = noise.independent(&clear.residuals);
        Round { looks: clear.looks, noise, independent, priors, contrasts, solution }
    }

    /// How sure an optimum is.
    fn uncertainty(&self, round: &Round<'_>) -> Option<Uncertainty> {
        let Round { looks, noise, independent, priors, contrasts, solution } = round;
        let looks = self.within(looks, &solution.state);
        let posterior = self.posterior(&looks, priors, contrasts);
        let error = RepeatedError::new(&posterior, solution, noise, *independent)?;
        Uncertainty::new(self.evidence.model, &solution.state, self.camera_prior, &error)
    }

    /// The motion of each frame and what it costs, data once.
    fn frame_fits(
        &self,
        looks: &[Vec<Look<'_>>],
        priors: &Priors,
        state: &SequenceState,
    ) -> Vec<FrameFit> {
        let looks = self.within(looks, state);
        let none = Contrasts::none(looks.len());
        self.posterior(&looks, priors, &none).frame_fits(state)
    }

    /// The posterior of looks, of data and motions that count once.
    fn posterior<'p>(
        &'p self,
        looks: &'p [Vec<&'p Look<'p>>],
        priors: &'p Priors,
        contrasts: &'p Contrasts,
    ) -> SequencePosterior<'p> {
        let Evidence { model, rig, .. } = self.evidence;
        SequencePosterior {
            model,
            rig,
            camera_prior: self.camera_prior,
            shape_prior: &priors.shape,
            motion_prior: &priors.motion,
            seconds: self.seconds,
            looks,
            weights: DataWeights::all(1.0),
            contrasts,
        }
    }

    /// The looks at moments of the recording: what a late camera shows after its end is not compared.
    fn within<'l, 'f>(
        &self,
        looks: &'l [Vec<Look<'f>>],
        state: &SequenceState,
    ) -> Vec<Vec<&'l Look<'f>>> {
        let (times_s, trials) = (times_s(self.seconds), trials(self.seconds));
        let half_s = 0.5 * self.seconds.iter().copied().fold(f64::INFINITY, f64::min);
        let of_frame = |(i, looks): (usize, &'l Vec<Look<'f>>)| {
            let (time_s, last_s) = (times_s[i], times_s[trials[i].end - 1]);
            let whole = -half_s..=last_s + half_s;
            let is_within = |look: &&Look<'_>| {
                let offset = look.camera.and_then(|camera| state.cameras.get(camera));
                whole.contains(&(time_s + offset.map_or(0.0, |offset| offset.ahead_s)))
            };
            looks.iter().filter(is_within).collect()
        };
        looks.iter().enumerate().map(of_frame).collect()
    }

    /// From where the next round starts.
    fn approached(&self, round: Round<'_>) -> Approached {
        let model = self.evidence.model;
        let Solution { state, model: chain, linearized_at, .. } = round.solution;
        let with_spreads = |covariance| {
            ShapePrior::from_statistics(&with_spreads(model, &state.shape, &covariance))
        };
        let shape_prior = chain.shared_covariance().map(with_spreads);
        let used = round.priors.motion.beside(round.noise.staying_share(), self.seconds);
        let moves = (linearized_at.motions.as_slice(), self.seconds);
        Approached {
            priors: Priors {
                shape: shape_prior.unwrap_or_else(|| self.evidence.shape_prior.clone()),
                motion: self.motion_prior.with_accelerations_of(&used, moves, &chain),
            },
            leverages: round.contrasts.leverages(model, &state, &chain),
            state,
        }
    }
}

/// A problem that tells of each linearisation.
struct Counted<'a, P> {
    problem: &'a P,
    step: &'a dyn Fn(),
}

impl<P: Problem> Problem for Counted<'_, P> {
    type State = P::State;
    type Model = P::Model;

    fn empty_model(&self) -> P::Model {
        self.problem.empty_model()
    }

    fn cost(&self, x: &P::State) -> f64 {
        self.problem.cost(x)
    }

    fn linearize(&self, x: &P::State, model: &mut P::Model) -> f64 {
        let cost = self.problem.linearize(x, model);
        (self.step)();
        cost
    }

    fn retract(&self, x: &P::State, delta: &DVector<f64>) -> P::State {
        self.problem.retract(x, delta)
    }
}
