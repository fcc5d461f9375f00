//! Each arm fitted from both sides of its upper arm.

use std::error::Error;

use experiments::held::{ARMS, Arm, ArmError, held};
use experiments::metrics::{only, trajectories};
use experiments::walker;
use maquette::body::{BodyModel, JointId, Motion, Shape};
use maquette::inference::frame::FramePosterior;
use maquette::inference::search::{Hypothesis, Journal, NoJournal, SearchOptions, Trial, search};
use maquette::inference::{Detail, Evidence, Sequence, Terms};
use maquette::io::points::trc::Trajectories;
use maquette::likelihood::{EllipseOptions, LikelihoodOptions, Measure};
use maquette::silhouette::FrameObservations;
use maquette::solver::{Options, levenberg_marquardt};
use maquette::synth::Synthetic;

use crate::conditions::Condition;

/// Every how many held frames arms are fitted.
const EVERY: usize = 8;

/// What silhouettes are compared with.
pub(crate) struct Likelihood {
    pub(crate) name: &'static str,
    pub(crate) title: &'static str,
    measure: Measure,
    ellipses: fn() -> EllipseOptions,
}

pub(crate) const LIKELIHOODS: [Likelihood; 3] = [
    Likelihood {
        name: "published",
        title: "published",
        measure: Measure::Ellipses,
        ellipses: EllipseOptions::published,
    },
    Likelihood {
        name: "outline",
        title: "outline",
        measure: Measure::Ellipses,
        ellipses: EllipseOptions::default,
    },
    Likelihood {
        name: "metaballs",
        title: "metaballs",
        measure: Measure::Metaballs,
        ellipses: EllipseOptions::default,
    },
];

/// One arm in one frame, fitted from both sides.
#[derive(Debug, Clone)]
pub(crate) struct Fit {
    /// Shoulder, elbow and wrist: true, and from the right and from the opposite start.
    pub(crate) arms: [[[f64; 3]; 3]; 3],
    /// Cost of both optima.
    pub(crate) costs: [f64; 2],
    /// Whether each optimum bends to the opposite side.
    pub(crate) opposite: [bool; 2],
}

impl Fit {
    /// The optimum that costs less bends to the opposite side.
    pub(crate) fn prefers_opposite(&self) -> bool {
        let better = usize::from(self.costs[1] < self.costs[0]);
        self.opposite[better]
    }
}

/// How many of some fits do what.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Tally {
    pub(crate) all: usize,
    pub(crate) prefers: usize,
    /// From the right start to an optimum on the right side.
    pub(crate) stays: usize,
}

impl Tally {
    pub(crate) fn of<'a>(fits: impl Iterator<Item = &'a Fit>) -> Self {
        fits.fold(Self::default(), |sum, fit| Self {
            all: sum.all + 1,
            prefers: sum.prefers + usize::from(fit.prefers_opposite()),
            stays: sum.stays + usize::from(!fit.opposite[0]),
        })
    }
}

/// The recordings of one condition.
#[derive(Debug)]
pub(crate) struct Sides {
    /// Of each likelihood, arm by arm in every eighth held frame.
    pub(crate) fits: [Vec<Fit>; 3],
    /// Of each likelihood, how it tracks the arms from one keyframe, with one shape.
    pub(crate) tracks: [Track; 3],
    /// Of the published likelihood and the outline, how Algorithm 1 finds the arms from nothing.
    pub(crate) alone: [Track; 2],
}

/// Frames of a track in which the arms are held.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Track {
    pub(crate) held: usize,
    /// An arm is lost.
    pub(crate) lost: usize,
    /// An arm whose shoulder is in its place bends to the opposite side.
    pub(crate) opposite: usize,
}

impl Track {
    fn and(self, other: &Self) -> Self {
        Self {
            held: self.held + other.held,
            lost: self.lost + other.lost,
            opposite: self.opposite + other.opposite,
        }
    }
}

/// Farther off than this a shoulder is not in its place: the body is turned, metres.
const SHOULDER_M: f64 = 0.15;

/// The hypothesis that a search is to follow.
struct Only<'a>(&'a Hypothesis);

impl Journal for Only<'_> {
    fn kept_keyframe(&self, keyframe: usize) -> Option<Vec<Hypothesis>> {
        Some(if keyframe == self.0.keyframe { vec![self.0.clone()] } else { Vec::new() })
    }
}

/// What is fitted in a recording.
struct Scene<'a> {
    condition: &'a Condition,
    recording: &'a Synthetic,
    frames: Vec<FrameObservations>,
    truth: Trajectories,
}

impl Sides {
    /// Two recordings as one.
    pub(crate) fn and(mut self, other: Self) -> Self {
        for (mine, others) in self.fits.iter_mut().zip(other.fits) {
            mine.extend(others);
        }
        self.tracks = std::array::from_fn(|k| self.tracks[k].and(&other.tracks[k]));
        self.alone = std::array::from_fn(|k| self.alone[k].and(&other.alone[k]));
        self
    }

    pub(crate) fn of(
        model: &BodyModel,
        condition: &Condition,
        seed: u64,
    ) -> Result<Self, Box<dyn Error + Send + Sync>> {
        let recording = condition.holding.recording(seed)?;
        let scene = Scene {
            condition,
            frames: walker::observe(&recording),
            truth: walker::truth(&recording),
            recording: &recording,
        };
        let loose = without_limits(model);
        let found =
            scene.searched(model, &LIKELIHOODS[1], &NoJournal).ok_or("nothing was found")?;
        let tracked = |likelihood: &Likelihood, journal: &dyn Journal| {
            let track = scene.searched(&loose, likelihood, journal);
            track.map_or_else(Track::default, |track| scene.tracked(&loose, &track))
        };
        let only = Only(&found.hypothesis);
        let tracks = LIKELIHOODS.each_ref().map(|likelihood| tracked(likelihood, &only));
        let alone = [0, 1].map(|k| tracked(&LIKELIHOODS[k], &NoJournal));
        let fits = LIKELIHOODS.each_ref().map(|likelihood| scene.fits(&loose, likelihood, &found));
        Ok(Self { fits, tracks, alone })
    }
}

/// The body with arms that turn as they like.
fn without_limits(model: &BodyModel) -> BodyModel {
    let mut loose = model.clone();
    for joint in &mut loose.joints {
        if ["shoulder", "elbow"].iter().any(|of| joint.name.starts_with(of)) {
            joint.limits = (-std::f64::consts::PI, std::f64::consts::PI);
            joint.spread *= 10.0;
        }
    }
    loose
}

impl Scene<'_> {
    fn held(&self) -> impl Iterator<Item = usize> + '_ {
        let frames = self.frames.len();
        (0..frames).filter(move |&f| held(f, frames) >= 0.5)
    }

    fn evidence<'m>(&'m self, model: &'m BodyModel, likelihood: &Likelihood) -> Evidence<'m> {
        let loss = self.condition.loss;
        let ellipses = EllipseOptions { loss, ..(likelihood.ellipses)() };
        let mut options = LikelihoodOptions { ellipses, ..LikelihoodOptions::default() };
        options.rays.loss = loss;
        Evidence::new(model, &self.recording.rig, options, likelihood.measure)
    }

    /// Algorithm 1, every 20th frame a keyframe; the most probable of the hypotheses that the journal wants.
    fn searched(
        &self,
        model: &BodyModel,
        likelihood: &Likelihood,
        journal: &dyn Journal,
    ) -> Option<Trial> {
        let sequence = Sequence { frames: &self.frames, fps: self.recording.fps };
        let options = SearchOptions { keyframe_every: Some(20), ..SearchOptions::default() };
        let found = search(&self.evidence(model, likelihood), sequence, &options, journal)?;
        let is_wanted = |trial: &&Trial| {
            let kept = journal.kept_keyframe(trial.hypothesis.keyframe);
            trial.finished() && kept.is_none_or(|kept| kept.contains(&trial.hypothesis))
        };
        let by_energy = |a: &&Trial, b: &&Trial| a.energy().total_cmp(&b.energy());
        found.trials.iter().filter(is_wanted).min_by(by_energy).cloned()
    }

    /// What becomes of the arms in a track.
    fn tracked(&self, model: &BodyModel, trial: &Trial) -> Track {
        let motions: Vec<Motion> =
            trial.frames.iter().flatten().map(|f| f.motion.clone()).collect();
        let fit = trajectories(model, &trial.hypothesis.shape, &motions, self.recording.fps);
        let mut track = Track::default();
        for frame in self.held() {
            let errors = ARMS.map(|arm| arm.error(&self.truth, &fit, frame));
            let any = |is: fn(&ArmError) -> bool| errors.iter().flatten().any(is);
            track.held += 1;
            track.lost += usize::from(any(ArmError::is_lost));
            track.opposite += usize::from(any(|e| e.wrong_way && e.shoulder_m < SHOULDER_M));
        }
        track
    }

    /// Both arms of every eighth held frame, from where a track has them.
    fn fits(&self, model: &BodyModel, likelihood: &Likelihood, track: &Trial) -> Vec<Fit> {
        let evidence = self.evidence(model, likelihood);
        let shape = &track.hypothesis.shape;
        let mut fits = Vec::new();
        for frame in self.held().step_by(EVERY) {
            let Some(tracked) = track.frames.get(frame).and_then(Option::as_ref) else { continue };
            let terms = evidence.terms(&self.frames[frame], Detail::Thinned);
            let posterior = Posterior { model, shape, evidence: &evidence, terms: &terms };
            for arm in ARMS {
                fits.extend(self.fit(&posterior, arm, frame, &tracked.motion));
            }
        }
        fits
    }

    fn fit(&self, posterior: &Posterior<'_>, arm: Arm, frame: usize, at: &Motion) -> Option<Fit> {
        let elbow = posterior.model.joint(&format!("elbow_flexion_{}", &arm.name[..1]))?;
        let ends = [at.clone(), mirrored(at, elbow)].map(|start| posterior.optimum(start));
        let costs = [ends[0].1, ends[1].1];
        let fitted = ends.map(|(motion, _)| posterior.points(&motion, self.recording.fps));
        let true_frame = only(&self.truth, frame)?;
        let errors =
            [arm.error(&true_frame, &fitted[0], 0)?, arm.error(&true_frame, &fitted[1], 0)?];
        Some(Fit {
            arms: [arm.places(&true_frame)?, arm.places(&fitted[0])?, arm.places(&fitted[1])?],
            costs,
            opposite: errors.map(|e| e.wrong_way),
        })
    }
}

/// The same pose with an elbow bent to the other side.
fn mirrored(motion: &Motion, elbow: JointId) -> Motion {
    let mut motion = motion.clone();
    motion.angles[elbow.0] = -motion.angles[elbow.0];
    motion
}

/// p(m | Z) of one frame, whose shape is given.
struct Posterior<'a> {
    model: &'a BodyModel,
    shape: &'a Shape,
    evidence: &'a Evidence<'a>,
    terms: &'a Terms<'a>,
}

impl Posterior<'_> {
    fn optimum(&self, start: Motion) -> (Motion, f64) {
        let posterior = FramePosterior {
            model: self.model,
            shape: self.shape,
            pose_prior: &self.evidence.pose_prior,
            step: None,
            terms: self.terms,
        };
        let options = Options { max_iterations: 40, relative_decrease: 1e-5, ..Options::default() };
        let solution = levenberg_marquardt(&posterior, start, &options);
        (solution.state, solution.cost)
    }

    fn points(&self, motion: &Motion, fps: f64) -> Trajectories {
        trajectories(self.model, self.shape, std::slice::from_ref(motion), fps)
    }
}
