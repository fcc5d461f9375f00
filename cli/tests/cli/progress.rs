//! What is told of a run while it runs.

use std::sync::Mutex;

use maquette::workflow::FitFolder;
use maquette::{FitOptions, Recording};

use maquette::io::folder::Existing;
use maquette::pipeline::Progress;

use crate::arm::{Arm, FRAMES};

/// A stage: its name, the steps announced, the steps done, whether it has ended.
type Stage = (&'static str, usize, usize, bool);

/// Writes down every stage.
#[derive(Default)]
struct Written(Mutex<Vec<Stage>>);

impl Written {
    fn last(&self, change: impl FnOnce(&mut Stage)) {
        change(self.0.lock().expect("a list").last_mut().expect("a stage"));
    }
}

impl Progress for Written {
    fn begin(&self, stage: &'static str, steps: usize) {
        self.0.lock().expect("a list").push((stage, steps, 0, false));
    }
    fn advance(&self, steps: usize) {
        self.last(|(name, _, done, ended)| {
            assert!(!*ended, "{name} has ended");
            *done += steps;
        });
    }
    fn end(&self) {
        self.last(|(.., ended)| *ended = true);
    }
}

#[test]
fn every_part_of_a_fit_is_a_stage_and_each_reaches_its_end() {
    let arm = Arm::new();
    let recording = Recording::open(arm.recording()).expect("a recording").with_fps(Some(10.0));
    let mut options = FitOptions { body: Some("arm-2d".into()), ..FitOptions::default() };
    options.estimate.search.keyframe_every = Some(2);
    let path = arm.out("out");
    let folder = FitFolder { path: &path, existing: Existing::Refuse, overlays: false };
    let written = Written::default();
    recording.fit_into(folder, &options, &written).expect("a fit");

    let stages = written.0.into_inner().expect("a list");
    let (joint, others): (Vec<Stage>, Vec<Stage>) =
        stages.iter().partition(|(name, ..)| *name == "joint optimum");
    let names: Vec<&str> = others.iter().map(|(name, ..)| *name).collect();
    assert_eq!(names, ["reading masks", "keyframes", "hypotheses", "checks"]);
    for (name, steps, done, ended) in others {
        assert!(ended && done == steps && steps > 0, "{name}: {done} of {steps}");
    }
    assert_eq!(stages[0].1, FRAMES);

    // it ends when the cost no longer falls: after its first linearisation, a step and the last one at the earliest
    assert!(!joint.is_empty());
    for (_, most, done, ended) in joint {
        assert!(ended && (3..=most).contains(&done), "{done} of {most}");
    }
    assert_eq!(stages.last().map(|(name, ..)| *name), Some("checks"));
}
