//! The ways from silhouettes to the motion of the arms.

use std::time::Instant;

use experiments::held::ARMS;
use experiments::metrics::trajectories;
use maquette::body::{BodyModel, Motion, Shape};
use maquette::camera::Rig;
use maquette::inference::SequenceState;
use maquette::inference::joint::{JointOptimum, JointOptions, joint_optimum};
use maquette::inference::search::{Hypothesis, Journal, NoJournal, SearchOptions, Trial, search};
use maquette::inference::{Evidence, Sequence};
use maquette::io::points::trc::Trajectories;
use maquette::likelihood::{EllipseOptions, LikelihoodOptions, Measure};
use maquette::math::stats::mean;
use maquette::silhouette::FrameObservations;

/// What is fitted, and the truth.
pub(crate) struct Scene<'a> {
    pub(crate) model: &'a BodyModel,
    pub(crate) rig: &'a Rig,
    pub(crate) frames: Vec<FrameObservations>,
    pub(crate) truth: Trajectories,
    pub(crate) fps: f64,
}

/// One way's result.
pub(crate) struct Way {
    /// As it stands in the names of numbers.
    pub(crate) name: &'static str,
    /// As it stands in tables.
    pub(crate) title: &'static str,
    pub(crate) fit: Trajectories,
    /// Standard deviations of the elbows' flexion, degrees, frame by frame: right, left; only of the joint optimum.
    pub(crate) elbow_sd_deg: Vec<[f64; 2]>,
    pub(crate) seconds: f64,
}

impl Way {
    /// Errors of the elbows' flexion over their standard deviations, root mean square, in the frames that `counts` chooses;
    /// `None` where no standard deviation is stated.
    pub(crate) fn elbow_rms_z(
        &self,
        truth: &Trajectories,
        counts: impl Fn(usize) -> bool,
    ) -> Option<f64> {
        let frames = self.elbow_sd_deg.iter().enumerate().filter(|(frame, _)| counts(*frame));
        let squares = frames.flat_map(|(frame, sd_deg)| {
            let errors = ARMS.into_iter().zip(sd_deg);
            errors.filter_map(move |(arm, sd_deg)| {
                Some((arm.error(truth, &self.fit, frame)?.flexion_deg / sd_deg).powi(2))
            })
        });
        mean(squares).map(f64::sqrt)
    }
}

/// The hypothesis of one keyframe, for a search that is to follow no other.
struct Only<'a>(&'a Hypothesis);

impl Journal for Only<'_> {
    fn kept_keyframe(&self, keyframe: usize) -> Option<Vec<Hypothesis>> {
        let is_it = keyframe == self.0.keyframe;
        Some(if is_it { vec![self.0.clone()] } else { Vec::new() })
    }
}

impl Scene<'_> {
    pub(crate) fn ways(&self) -> Option<Vec<Way>> {
        let outline = self.evidence(Measure::Ellipses, EllipseOptions::default());
        let metaballs = self.evidence(Measure::Metaballs, EllipseOptions::default());
        // frame by frame
        let published = self.evidence(Measure::Ellipses, EllipseOptions::published());
        let published = self.searched("published", "published ellipses", &published, &NoJournal)?;
        let tracked = self.searched("outline", "outline of the ellipses", &outline, &NoJournal)?;
        let (tracked, winner) = tracked;
        let only = Only(&winner.hypothesis);
        let (soft, _) = self.searched("metaballs", "metaballs", &metaballs, &only)?;
        let all = self.evidence(Measure::Both, EllipseOptions::default());
        let (both, _) = self.searched("both", "outline and metaballs", &all, &only)?;
        // all frames at once
        let joint = [
            ("joint_ellipses", "joint optimum, outline", &outline),
            ("joint_metaballs", "joint optimum, metaballs", &metaballs),
            ("joint_both", "joint optimum, outline and metaballs", &all),
        ];
        let joint = joint.map(|(name, title, evidence)| self.joint(name, title, evidence, &winner));
        let tracked = [published.0, tracked, soft, both];
        Some(tracked.into_iter().chain(joint).collect())
    }

    fn evidence(&self, measure: Measure, ellipses: EllipseOptions) -> Evidence<'_> {
        let likelihood = LikelihoodOptions { ellipses, ..LikelihoodOptions::default() };
        Evidence::new(self.model, self.rig, likelihood, measure)
    }

    fn sequence(&self) -> Sequence<'_> {
        Sequence { frames: &self.frames, fps: self.fps }
    }

    /// Algorithm 1, and its winner.
    fn searched(
        &self,
        name: &'static str,
        title: &'static str,
        evidence: &Evidence<'_>,
        journal: &dyn Journal,
    ) -> Option<(Way, Trial)> {
        let started = Instant::now();
        let found = search(evidence, self.sequence(), &options(), journal)?;
        // the mean's trial gives way to the only one that is to be followed
        let is_wanted = |t: &Trial| {
            journal
                .kept_keyframe(t.hypothesis.keyframe)
                .is_none_or(|only| only.contains(&t.hypothesis))
        };
        let wanted = |t: &&Trial| t.finished() && is_wanted(t);
        let by_energy = |a: &&Trial, b: &&Trial| a.energy().total_cmp(&b.energy());
        let winner = found.trials.iter().filter(wanted).min_by(by_energy)?;
        let way = Way {
            name,
            title,
            fit: self.trajectories(&winner.hypothesis.shape, &motions(winner)),
            elbow_sd_deg: Vec::new(),
            seconds: started.elapsed().as_secs_f64(),
        };
        Some((way, winner.clone()))
    }

    fn joint(
        &self,
        name: &'static str,
        title: &'static str,
        evidence: &Evidence<'_>,
        winner: &Trial,
    ) -> Way {
        let started = Instant::now();
        let start = SequenceState::new(winner.hypothesis.shape.clone(), motions(winner));
        let options = JointOptions::default();
        let joint = joint_optimum(evidence, self.sequence(), start, &options);
        let all: Vec<Motion> = joint.frames.iter().map(|f| f.motion.clone()).collect();
        Way {
            name,
            title,
            fit: self.trajectories(&joint.shape, &all),
            elbow_sd_deg: self.elbow_sd_deg(&joint),
            seconds: started.elapsed().as_secs_f64(),
        }
    }

    fn elbow_sd_deg(&self, joint: &JointOptimum) -> Vec<[f64; 2]> {
        let elbows = ["elbow_flexion_r", "elbow_flexion_l"].map(|name| self.model.joint(name));
        let frames = joint.uncertainty.iter().flat_map(|u| &u.frames);
        let sd = |sd: f64| sd.to_degrees();
        frames.map(|f| elbows.map(|e| e.map_or(f64::NAN, |e| sd(f.angles_sd[e.0])))).collect()
    }

    fn trajectories(&self, shape: &Shape, motions: &[Motion]) -> Trajectories {
        trajectories(self.model, shape, motions, self.fps)
    }
}

fn motions(trial: &Trial) -> Vec<Motion> {
    let fits = trial.frames.iter().flatten();
    fits.map(|f| f.motion.clone()).collect()
}

/// As published, every 20th frame a keyframe.
fn options() -> SearchOptions {
    SearchOptions { keyframe_every: Some(20), ..SearchOptions::default() }
}
