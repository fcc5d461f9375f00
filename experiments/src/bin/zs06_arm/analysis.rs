//! Recordings of the arm, and what a likelihood makes of them.

use experiments::arm::{BarArm, Posterior, observe, rig, share_of};
use maquette::body::BodyModel;
use maquette::camera::Rig;
use maquette::inference::search::{NoJournal, Origin, Pruning, Search, SearchOptions, search};
use maquette::inference::{Evidence, Sequence};
use maquette::likelihood::{EllipseDistance, EllipseOptions};
use maquette::silhouette::FrameObservations;
use maquette::solver::Loss;
use maquette::synth::SegmentationErrors;
use rayon::prelude::*;

pub(crate) const ARM: BarArm = BarArm { a: 0.5, radii: [0.1; 3] };
pub(crate) const FRAMES: usize = 6;
pub(crate) const FPS: f64 = 10.0;
/// Cells of the grid of a.
pub(crate) const CELLS: usize = 200;
/// Recordings with other noise; the first is the one that is drawn.
pub(crate) const RECORDINGS: u64 = 100;

/// A ragged border: 2 px over 10 px, 1.4 cm on the arm.
pub(crate) const ERRORS: SegmentationErrors = SegmentationErrors {
    border_sd_px: 2.0,
    correlation_px: 10.0,
    bites: 0.0,
    holes: 0.0,
    specks: 0.0,
    blot_radius_px: (1.0, 2.0),
};

/// A bar against an ellipse of the same length is off by 3 cm (σ_m), to one side for half a metre.
pub(crate) fn likelihoods() -> [(&'static str, EllipseOptions); 4] {
    let of = |options: EllipseOptions, distance| EllipseOptions {
        distance,
        sigma_m: 0.03,
        correlation_m: 0.5,
        blend_m: 0.01,
        loss: Loss::Squared,
        ..options
    };
    let (published, outline) = (EllipseOptions::published(), EllipseOptions::default());
    [
        ("published", of(published, EllipseDistance::Published)),
        ("nearest", of(published, EllipseDistance::Orthogonal)),
        ("outline", of(outline, EllipseDistance::Orthogonal)),
        ("gradient", of(outline, EllipseDistance::Gradient)),
    ]
}

pub(crate) fn options() -> SearchOptions {
    SearchOptions { keyframe_every: Some(1), pruning: Pruning::Off, ..SearchOptions::default() }
}

/// The recordings: the same arm and motion, other noise.
pub(crate) struct Scene<'a> {
    pub(crate) model: &'a BodyModel,
    pub(crate) rig: Rig,
    pub(crate) angles: Vec<f64>,
    pub(crate) recordings: Vec<Vec<FrameObservations>>,
}

/// What one likelihood makes of the recordings.
pub(crate) struct Analysis {
    pub(crate) name: &'static str,
    pub(crate) posterior: Posterior,
    /// Of the first recording.
    pub(crate) found: Search,
    /// Of each recording.
    pub(crate) outcomes: Vec<Outcome>,
}

/// The chosen hypothesis of one recording.
pub(crate) struct Outcome {
    pub(crate) a: f64,
    pub(crate) a_of_first_frame: f64,
    pub(crate) chose_first_frame: bool,
}

impl<'a> Scene<'a> {
    pub(crate) fn new(model: &'a BodyModel, seed: u64) -> Self {
        let rig = rig();
        let angles: Vec<f64> = (0..FRAMES).map(|i| 0.1 * i as f64).collect();
        let recording = |k| observe(&ARM, &angles, &rig, &ERRORS, 1000 * seed + k);
        let recordings = (0..RECORDINGS).into_par_iter().map(recording).collect();
        Self { model, rig, angles, recordings }
    }

    pub(crate) fn analyse(
        &self,
        name: &'static str,
        likelihood: EllipseOptions,
    ) -> Option<Analysis> {
        let evidence = Evidence::with_ellipses(self.model, &self.rig, likelihood);
        let sequence = |frames| Sequence { frames, fps: FPS };
        let searches: Vec<Search> = self
            .recordings
            .par_iter()
            .filter_map(|frames| search(&evidence, sequence(frames), &options(), &NoJournal))
            .collect();
        Some(Analysis {
            name,
            posterior: Posterior::new(&evidence, sequence(self.recordings.first()?), CELLS),
            outcomes: searches.iter().filter_map(Outcome::of).collect(),
            found: searches.into_iter().next()?,
        })
    }
}

impl Outcome {
    pub(crate) fn of(found: &Search) -> Option<Self> {
        let is_first = |origin, keyframe| origin != Origin::Prior && keyframe == 0;
        let mut hypotheses = found.trials.iter().map(|t| &t.hypothesis);
        let winner = &found.trials.get(found.winner)?.hypothesis;
        let first = hypotheses.find(|h| is_first(h.origin, h.keyframe))?;
        Some(Self {
            a: share_of(&winner.shape),
            a_of_first_frame: share_of(&first.shape),
            chose_first_frame: is_first(winner.origin, winner.keyframe),
        })
    }

    /// Whether the chosen a is within 0.05 of the truth.
    pub(crate) fn is_right(&self) -> bool {
        (self.a - ARM.a).abs() <= 0.05
    }
}

impl Analysis {
    /// Normalised sequence posterior of each hypothesis.
    pub(crate) fn probabilities(&self) -> Vec<f64> {
        let best = self.found.trials[self.found.winner].energy();
        let trials = self.found.trials.iter();
        let weights: Vec<f64> = trials.map(|t| (best - t.energy()).exp()).collect();
        let sum: f64 = weights.iter().sum();
        weights.iter().map(|w| w / sum).collect()
    }

    /// φ of the most probable hypothesis, frame by frame.
    pub(crate) fn angles(&self) -> Vec<f64> {
        let fits = self.found.trials[self.found.winner].frames.iter();
        fits.flatten().map(|fit| fit.motion.angles[0]).collect()
    }

    /// RMS error of φ, radians.
    pub(crate) fn angle_error(&self) -> f64 {
        let errors = self.angles().into_iter().enumerate();
        let squares: f64 = errors.map(|(i, phi)| (phi - 0.1 * i as f64).powi(2)).sum();
        (squares / FRAMES as f64).sqrt()
    }

    pub(crate) fn fraction(&self, holds: impl Fn(&Outcome) -> bool) -> f64 {
        self.outcomes.iter().filter(|o| holds(o)).count() as f64 / self.outcomes.len() as f64
    }
}
