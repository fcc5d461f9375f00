//! What an earlier search kept is taken only where it fits, and a journal that fails ends the search.

use std::collections::BTreeMap;
use std::sync::Mutex;

use maquette::inference::Sequence;
use maquette::inference::search::{Hypothesis, Journal, NoJournal, SearchOptions, Trial, search};
use maquette::likelihood::Measure;

use crate::scene::{FPS, Scene};

/// Keeps everything in memory, until it has kept `most` steps.
struct Memory {
    most: usize,
    keyframes: Mutex<BTreeMap<usize, Vec<Hypothesis>>>,
    trials: Mutex<BTreeMap<usize, Trial>>,
}

impl Memory {
    fn of(most: usize) -> Self {
        Self { most, keyframes: Mutex::default(), trials: Mutex::default() }
    }

    fn steps(&self) -> usize {
        self.keyframes.lock().expect("alone").len() + self.trials.lock().expect("alone").len()
    }
}

impl Journal for Memory {
    fn kept_keyframe(&self, keyframe: usize) -> Option<Vec<Hypothesis>> {
        self.keyframes.lock().expect("alone").get(&keyframe).cloned()
    }

    fn keep_keyframe(&self, keyframe: usize, hypotheses: &[Hypothesis]) {
        self.keyframes.lock().expect("alone").insert(keyframe, hypotheses.to_vec());
    }

    fn kept_trial(&self, index: usize) -> Option<Trial> {
        self.trials.lock().expect("alone").get(&index).cloned()
    }

    fn keep_trial(&self, index: usize, trial: &Trial) {
        self.trials.lock().expect("alone").insert(index, trial.clone());
    }

    fn is_failing(&self) -> bool {
        self.steps() >= self.most
    }
}

fn options() -> SearchOptions {
    SearchOptions { keyframe_every: Some(2), ..SearchOptions::default() }
}

#[test]
fn the_journal_of_a_longer_recording_is_not_trusted() {
    let scene = Scene::arm(5);
    let evidence = scene.evidence(Measure::Metaballs);
    let short = Sequence { frames: &scene.frames[..3], fps: FPS };
    let journal = Memory::of(usize::MAX);
    search(&evidence, scene.sequence(), &options(), &journal).expect("found");
    assert!(journal.steps() > 3);

    let after = search(&evidence, short, &options(), &journal).expect("found");
    let alone = search(&evidence, short, &options(), &NoJournal).expect("found");
    assert_eq!(after, alone);
}

#[test]
fn a_search_whose_journal_fails_is_given_up_at_once() {
    let scene = Scene::arm(5);
    let evidence = scene.evidence(Measure::Metaballs);
    let journal = Memory::of(1);
    assert_eq!(search(&evidence, scene.sequence(), &options(), &journal), None);
    // keyframes that were under way are finished, no trial is begun
    assert!((1..=3).contains(&journal.steps()) && journal.trials.lock().expect("alone").is_empty());
}
