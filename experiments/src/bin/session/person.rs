//! One simulated person's trials, alone and together.

use std::time::Instant;

use experiments::individual::individual;
use experiments::metrics::rms;
use experiments::walker::observe;
use maquette::body::BodyModel;
use maquette::inference::Sequence;
use maquette::inference::search::NoJournal;
use maquette::math::stats::mean;
use maquette::pipeline::{
    EstimateOptions, Fit, NoProgress, SessionTrial, disagreements, fit, fit_session,
};
use maquette::silhouette::FrameObservations;
use maquette::synth::{Make, Recipe, Ring, SegmentationErrors, Synthetic};

/// Trials of a person.
const TRIALS: u64 = 5;

/// What was found of a person.
pub(crate) struct Found {
    /// Per cent by which each length is off: trial by trial, length by length.
    alone: Vec<Vec<f64>>,
    /// The same of all trials together.
    together: Vec<f64>,
    /// The same in standard deviations.
    pub(crate) alone_z: Vec<f64>,
    pub(crate) together_z: Vec<f64>,
    /// Time of the session over that of a fit of each trial.
    pub(crate) times: f64,
    /// Trials that were named although they are of this person.
    pub(crate) wrongly_named: usize,
    /// 1 if the trial of another person was not named, or others with it.
    pub(crate) others_missed: usize,
}

impl Found {
    /// RMS over trials and lengths.
    pub(crate) fn alone_pct(&self) -> f64 {
        rms(self.alone.iter().flatten().copied())
    }

    /// RMS over lengths.
    pub(crate) fn together_pct(&self) -> f64 {
        rms(self.together.iter().copied())
    }

    /// RMS over lengths of the mean over trials.
    pub(crate) fn common_pct(&self) -> f64 {
        let of = |i: usize| mean(self.alone.iter().map(|trial| trial[i])).unwrap_or(f64::NAN);
        rms((0..self.together.len()).map(of))
    }
}

/// A trial as it was filmed.
struct Filmed {
    truth: Synthetic,
    observed: Vec<FrameObservations>,
}

impl Filmed {
    fn new(recipe: &Recipe, body: &BodyModel, walker: &BodyModel) -> Option<Self> {
        let truth = recipe.walker(&individual(recipe, body, walker)?).ok()?;
        let observed = observe(&truth);
        Some(Self { truth, observed })
    }

    fn sequence(&self) -> Sequence<'_> {
        Sequence { frames: &self.observed, fps: self.truth.fps }
    }

    fn fit(&self, body: &BodyModel, options: &EstimateOptions) -> Option<Fit> {
        fit(body, &self.truth.rig, self.sequence(), options, &NoJournal).ok()
    }
}

/// `None` if a trial could not be fitted.
pub(crate) fn found(
    body: &BodyModel,
    walker: &BodyModel,
    make: Make,
    seed: u64,
    frames: usize,
) -> Option<Found> {
    let recipe = |seed, trial| Recipe {
        seed,
        trial,
        make,
        frames: Some(frames),
        fps: 30.0,
        ring: Ring { cameras: 5, ..Ring::default() },
        errors: Some(SegmentationErrors::MILD),
        stereo: None,
        ..Recipe::default()
    };
    let film = |seed, trial| Filmed::new(&recipe(seed, trial), body, walker);
    let filmed: Vec<Filmed> = (0..TRIALS).map(|trial| film(seed, trial)).collect::<Option<_>>()?;
    let options = EstimateOptions::default();
    let fit_all = |options: &EstimateOptions| -> Option<Vec<Fit>> {
        filmed.iter().map(|trial| trial.fit(body, options)).collect()
    };

    // each trial as `maquette fit` fits it
    let start = Instant::now();
    let single = fit_all(&options)?;
    let single_s = start.elapsed().as_secs_f64();

    // and as `maquette session` does
    let start = Instant::now();
    let options = options.of_trial_alone();
    let search = options.search.of_trial(TRIALS as usize, frames);
    let options = EstimateOptions { search, ..options };
    let fits = fit_all(&options)?;
    let trials: Vec<SessionTrial<'_>> =
        filmed.iter().zip(&fits).map(|(trial, fit)| session_trial(trial, fit, &options)).collect();
    let together = fit_session(body, &trials, &NoProgress).ok()?;
    let times = start.elapsed().as_secs_f64() / single_s;

    // somebody else in the place of the last trial
    let other = film(seed + 50, 0)?;
    let other_fit = other.fit(body, &options)?;
    let mut mixed = trials.clone();
    mixed.pop();
    mixed.push(session_trial(&other, &other_fit, &options));
    let named: Vec<usize> = disagreements(body, &mixed).iter().map(|odd| odd.trial).collect();

    let off = |fit: &Fit| deviations(body, &filmed[0].truth, fit);
    let (together, together_z) = off(together.fits.first()?)?;
    let alone: Vec<(Vec<f64>, Vec<f64>)> = single.iter().map(off).collect::<Option<_>>()?;
    Some(Found {
        alone_z: alone.iter().flat_map(|(_, z)| z.clone()).collect(),
        alone: alone.into_iter().map(|(pct, _)| pct).collect(),
        together,
        together_z,
        times,
        wrongly_named: disagreements(body, &trials).len(),
        others_missed: usize::from(named != [TRIALS as usize - 1]),
    })
}

fn session_trial<'a>(
    trial: &'a Filmed,
    fit: &Fit,
    options: &'a EstimateOptions,
) -> SessionTrial<'a> {
    SessionTrial {
        name: "trial",
        rig: &trial.truth.rig,
        sequence: trial.sequence(),
        options,
        alone: fit.into(),
    }
}

/// By how much each length is off, per cent of it and in standard deviations.
fn deviations(body: &BodyModel, truth: &Synthetic, fit: &Fit) -> Option<(Vec<f64>, Vec<f64>)> {
    let uncertainty = fit.uncertainty.as_ref()?;
    let true_m = truth.model.rest_lengths_m(&truth.shape);
    let of = |(i, (name, ..)): (usize, &(String, usize, usize))| {
        let j = truth.model.lengths.iter().position(|length| length.0 == *name)?;
        let off = fit.lengths_m[i] - true_m[j];
        Some((100.0 * off / true_m[j], off / uncertainty.lengths_sd_m[i]))
    };
    Some(body.lengths.iter().enumerate().filter_map(of).unzip())
}
