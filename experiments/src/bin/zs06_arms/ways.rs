//! Four ways from silhouettes to the motion of the arms.

use std::time::Instant;

use experiments::metrics::trajectories;
use maquette::body::{BodyModel, Motion, Shape};
use maquette::camera::Rig;
use maquette::inference::Evidence;
use maquette::inference::joint::{Joint, JointOptions, joint_optimum};
use maquette::inference::propagate::Sequence;
use maquette::inference::search::{Hypothesis, Journal, NoJournal, SearchOptions, Trial, search};
use maquette::inference::sequence::SequenceState;
use maquette::io::trc::Trajectories;
use maquette::likelihood::{LikelihoodOptions, Measure};
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

/// The hypothesis of one keyframe, for a search that is to follow no other.
struct Only<'a>(&'a Hypothesis);

impl Journal for Only<'_> {
    fn kept_keyframe(&self, keyframe: usize) -> Option<Vec<Hypothesis>> {
        let is_it = keyframe == self.0.keyframe;
        Some(if is_it {
            vec![self.0.clone()]
        } else {
            Vec::new()
        })
    }
}

impl Scene<'_> {
    pub(crate) fn ways(&self) -> Option<Vec<Way>> {
        let (ellipses, metaballs) = (
            self.evidence(Measure::Ellipses),
            self.evidence(Measure::Metaballs),
        );
        // frame by frame
        let started = Instant::now();
        let found = search(&ellipses, self.sequence(), &options(), &NoJournal)?;
        let winner = &found.trials[found.winner];
        let tracked = self.tracked("ellipses", "ellipses, frame by frame", winner, started);
        let started = Instant::now();
        let again = search(
            &metaballs,
            self.sequence(),
            &options(),
            &Only(&winner.hypothesis),
        )?;
        let same = |t: &&Trial| t.finished() && t.hypothesis.shape == winner.hypothesis.shape;
        let followed = again.trials.iter().find(same)?;
        let soft = self.tracked("metaballs", "metaballs, frame by frame", followed, started);
        // all frames at once
        let joint = [
            ("joint_ellipses", "ellipses, joint optimum", &ellipses),
            ("joint_metaballs", "metaballs, joint optimum", &metaballs),
        ];
        let joint = joint.map(|(name, title, evidence)| self.joint(name, title, evidence, winner));
        Some([tracked, soft].into_iter().chain(joint).collect())
    }

    fn evidence(&self, measure: Measure) -> Evidence<'_> {
        Evidence::new(self.model, self.rig, LikelihoodOptions::default(), measure)
    }

    fn sequence(&self) -> Sequence<'_> {
        Sequence {
            frames: &self.frames,
            fps: self.fps,
        }
    }

    fn tracked(
        &self,
        name: &'static str,
        title: &'static str,
        trial: &Trial,
        started: Instant,
    ) -> Way {
        Way {
            name,
            title,
            fit: self.trajectories(&trial.hypothesis.shape, &motions(trial)),
            elbow_sd_deg: Vec::new(),
            seconds: started.elapsed().as_secs_f64(),
        }
    }

    fn joint(
        &self,
        name: &'static str,
        title: &'static str,
        evidence: &Evidence<'_>,
        winner: &Trial,
    ) -> Way {
        let started = Instant::now();
        let start = SequenceState {
            shape: winner.hypothesis.shape.clone(),
            motions: motions(winner),
        };
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

    fn elbow_sd_deg(&self, joint: &Joint) -> Vec<[f64; 2]> {
        let elbows = ["elbow_flexion_r", "elbow_flexion_l"].map(|name| self.model.joint(name));
        let frames = joint.uncertainty.iter().flat_map(|u| &u.frames);
        let sd = |sd: f64| sd.to_degrees();
        frames
            .map(|f| elbows.map(|e| e.map_or(f64::NAN, |e| sd(f.angles_sd[e.0]))))
            .collect()
    }

    fn trajectories(&self, shape: &Shape, motions: &[Motion]) -> Trajectories {
        trajectories(self.model, shape, motions, self.fps)
    }
}

fn motions(trial: &Trial) -> Vec<Motion> {
    let fits = trial.frames.iter().flatten();
    fits.map(|f| f.motion.clone()).collect()
}

/// As published: every 20th frame a keyframe.
fn options() -> SearchOptions {
    SearchOptions {
        keyframe_every: 20,
        ..SearchOptions::default()
    }
}
