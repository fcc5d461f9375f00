//! The recording, the likelihoods, and what Algorithm 1 makes of them.

use std::time::Instant;

use experiments::metrics::{frame_error_mm, offset_errors_mm, only, trajectories};
use maquette::body::{BodyModel, Motion, Shape};
use maquette::camera::Rig;
use maquette::inference::SequenceState;
use maquette::inference::frame::FrameFit;
use maquette::inference::joint::{JointOptions, joint_optimum};
use maquette::inference::search::{NoJournal, Origin, SearchOptions, Trial, search};
use maquette::inference::{Evidence, Sequence};
use maquette::io::points::trc::Trajectories;
use maquette::likelihood::{EllipseDistance, EllipseOptions, Variant};
use maquette::silhouette::FrameObservations;

/// A likelihood by name.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Named {
    pub(crate) name: &'static str,
    pub(crate) likelihood: EllipseOptions,
}

/// From the default to the published likelihood, one thing changed at a time.
pub(crate) fn variants() -> [Named; 6] {
    let outline = EllipseOptions::default();
    let with = |distance| EllipseOptions { distance, ..outline };
    let no_back = EllipseOptions { back_samples: 0, ..outline };
    let nearest = EllipseOptions { variant: Variant::Published, ..no_back };
    let named = |name, likelihood| Named { name, likelihood };
    [
        named("outline", outline),
        named("orthogonal", with(EllipseDistance::Orthogonal)),
        named("radial", with(EllipseDistance::Published)),
        named("no_back", no_back),
        named("nearest", nearest),
        named("published", EllipseOptions::published()),
    ]
}

/// As published, every 20th frame a keyframe.
pub(crate) fn options() -> SearchOptions {
    SearchOptions { keyframe_every: Some(20), ..SearchOptions::default() }
}

/// What is fitted, and the truth.
pub(crate) struct Scene<'a> {
    pub(crate) model: &'a BodyModel,
    pub(crate) rig: &'a Rig,
    pub(crate) frames: Vec<FrameObservations>,
    pub(crate) truth: Trajectories,
    pub(crate) fps: f64,
}

/// What one likelihood makes of the recording.
pub(crate) struct Fit {
    pub(crate) name: &'static str,
    /// The most probable of the keyframes' hypotheses, as published.
    pub(crate) keyframes: Track,
    /// The joint optimum that is reached from it.
    pub(crate) joint: Track,
    /// Keyframes, and how many start within 50 mm of the truth.
    pub(crate) starts: (usize, usize),
    /// Seconds of Algorithm 1, and of the joint optimum.
    pub(crate) seconds: [f64; 2],
}

/// The chosen motion.
pub(crate) struct Track {
    pub(crate) fit: Trajectories,
    /// Frames that the search gave up and searched anew.
    pub(crate) searched_anew: usize,
    pub(crate) losses: Losses,
}

/// Joints farther than 50 mm from where their mean offset puts them.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Losses {
    /// Frames with such a joint.
    pub(crate) frames: usize,
    /// Joints that were lost, once for each time.
    pub(crate) lost: usize,
    /// Those of them that came back before the end.
    pub(crate) recovered: usize,
}

const LOST_MM: f64 = 50.0;
const START_MM: f64 = 50.0;

impl Scene<'_> {
    pub(crate) fn fit(&self, Named { name, likelihood }: Named) -> Option<Fit> {
        let evidence = Evidence::with_ellipses(self.model, self.rig, likelihood);
        let sequence = Sequence { frames: &self.frames, fps: self.fps };
        let started = Instant::now();
        let found = search(&evidence, sequence, &options(), &NoJournal)?;
        let winner = found.trials.get(found.winner)?;
        let searched = started.elapsed().as_secs_f64();
        let tracked = motions(winner.frames.iter().flatten());
        let start = SequenceState::new(winner.hypothesis.shape.clone(), tracked);
        let joint = joint_optimum(&evidence, sequence, start, &JointOptions::default());
        let best = found.trials.iter().filter(|t| t.hypothesis.origin == Origin::Keyframe(0));
        let starts: Vec<f64> = best.filter_map(|t| self.start_error_mm(t)).collect();
        let tracked: Vec<&FrameFit> = winner.frames.iter().flatten().collect();
        Some(Fit {
            name,
            keyframes: self.track(&winner.hypothesis.shape, &tracked),
            joint: self.track(&joint.shape, &joint.frames.iter().collect::<Vec<_>>()),
            starts: (starts.len(), starts.iter().filter(|e| **e <= START_MM).count()),
            seconds: [searched, started.elapsed().as_secs_f64() - searched],
        })
    }

    fn track(&self, shape: &Shape, fits: &[&FrameFit]) -> Track {
        let motions = motions(fits.iter().copied());
        let fit = trajectories(self.model, shape, &motions, self.fps);
        Track {
            losses: Losses::of(&offset_errors_mm(&self.truth, &fit)),
            searched_anew: fits.iter().filter(|f| f.recovered).count(),
            fit,
        }
    }

    /// Mean distance of the limb joints at the keyframe itself.
    fn start_error_mm(&self, trial: &Trial) -> Option<f64> {
        let (shape, motion) = (&trial.hypothesis.shape, trial.hypothesis.motion.clone());
        let start = trajectories(self.model, shape, &[motion], self.fps);
        frame_error_mm(&only(&self.truth, trial.hypothesis.keyframe)?, &start, 0)
    }
}

fn motions<'a>(fits: impl Iterator<Item = &'a FrameFit>) -> Vec<Motion> {
    fits.map(|f| f.motion.clone()).collect()
}

impl Losses {
    fn of(errors_mm: &[Vec<f64>]) -> Self {
        let mut losses = Self::default();
        let mut before: Vec<bool> = errors_mm.first().map_or(Vec::new(), |e| vec![false; e.len()]);
        for frame in errors_mm {
            let now: Vec<bool> = frame.iter().map(|e| *e > LOST_MM).collect();
            losses.frames += usize::from(now.contains(&true));
            for (was, is) in before.iter().zip(&now) {
                losses.lost += usize::from(*is && !was);
                losses.recovered += usize::from(*was && !is);
            }
            before = now;
        }
        losses
    }
}
