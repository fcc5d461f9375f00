//! The progress of Algorithm 1, as its journal hears of it.

use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};

use crate::inference::search::{Hypothesis, Journal, Trial};
use crate::pipeline::Progress;

/// A journal that also tells how far the search is.
pub(super) struct WatchedJournal<'a> {
    journal: &'a dyn Journal,
    pub(super) progress: &'a dyn Progress,
    /// Frames of each hypothesis.
    frames: usize,
    /// Frames fitted so far, by hypothesis.
    fitted: Mutex<BTreeMap<usize, usize>>,
}

impl<'a> WatchedJournal<'a> {
    /// Begins the stage of about `keyframes` keyframes.
    pub(super) fn new(
        journal: &'a dyn Journal,
        progress: &'a dyn Progress,
        keyframes: usize,
        frames: usize,
    ) -> Self {
        progress.begin("keyframes", keyframes);
        Self { journal, progress, frames, fitted: Mutex::default() }
    }

    /// Counts the frames that a finished hypothesis need not visit any more.
    fn close(&self, index: usize) {
        let mut fitted = self.fitted.lock().unwrap_or_else(PoisonError::into_inner);
        let before = fitted.insert(index, self.frames).unwrap_or(0);
        self.progress.advance(self.frames.saturating_sub(before));
    }
}

impl Journal for WatchedJournal<'_> {
    fn kept_keyframe(&self, keyframe: usize) -> Option<Vec<Hypothesis>> {
        let kept = self.journal.kept_keyframe(keyframe);
        self.progress.advance(usize::from(kept.is_some()));
        kept
    }

    fn keep_keyframe(&self, keyframe: usize, hypotheses: &[Hypothesis]) {
        self.journal.keep_keyframe(keyframe, hypotheses);
        self.progress.step();
    }

    fn kept_trial(&self, index: usize) -> Option<Trial> {
        let kept = self.journal.kept_trial(index);
        if kept.is_some() {
            self.close(index);
        }
        kept
    }

    fn keep_trial(&self, index: usize, trial: &Trial) {
        self.journal.keep_trial(index, trial);
        self.close(index);
    }

    fn is_failing(&self) -> bool {
        self.journal.is_failing()
    }

    fn hypotheses(&self, count: usize) {
        self.journal.hypotheses(count);
        self.progress.end();
        self.progress.begin("hypotheses", count * self.frames);
    }

    fn advanced(&self, index: usize, frames: usize) {
        self.journal.advanced(index, frames);
        let mut fitted = self.fitted.lock().unwrap_or_else(PoisonError::into_inner);
        *fitted.entry(index).or_default() += frames;
        self.progress.advance(frames);
    }
}
