//! A bar for each stage, with the time left, on standard error.

use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use indicatif::{ProgressBar, ProgressStyle};

use crate::inference::search::{Hypothesis, Journal, Trial};

/// Whether progress is shown. Where standard error is no terminal it never is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Progress {
    Shown,
    Hidden,
}

impl Progress {
    /// The bar of a stage of `steps` steps.
    pub(super) fn bar(self, stage: &'static str, steps: usize) -> ProgressBar {
        if self == Self::Hidden {
            return ProgressBar::hidden();
        }
        let bar = ProgressBar::new(steps as u64).with_prefix(stage);
        let style =
            ProgressStyle::with_template("{prefix:<14} {bar:32} {pos:>6}/{len:<6} {eta:>4} left");
        if let Ok(style) = style {
            bar.set_style(style.progress_chars("━╸ "));
        }
        if !bar.is_hidden() {
            bar.enable_steady_tick(Duration::from_millis(250));
        }
        bar
    }
}

/// A journal that also moves the bars of the search.
pub(super) struct Watched<'a> {
    journal: &'a dyn Journal,
    keyframes: ProgressBar,
    trials: ProgressBar,
    frames: usize,
    /// Frames fitted so far, by hypothesis.
    fitted: Mutex<BTreeMap<usize, usize>>,
}

impl<'a> Watched<'a> {
    /// Bars for about `keyframes` keyframes and hypotheses of `frames` frames each.
    pub(super) fn new(
        journal: &'a dyn Journal,
        progress: Progress,
        keyframes: usize,
        frames: usize,
    ) -> Self {
        Self {
            journal,
            keyframes: progress.bar("keyframes", keyframes),
            trials: progress.bar("hypotheses", 0),
            frames,
            fitted: Mutex::default(),
        }
    }

    /// Takes the bars away.
    pub(super) fn finish(self) {
        self.keyframes.finish_and_clear();
        self.trials.finish_and_clear();
    }

    /// Moves the bar by the frames that a finished hypothesis need not visit any more.
    fn close(&self, index: usize) {
        let mut fitted = self.fitted.lock().unwrap_or_else(PoisonError::into_inner);
        let before = fitted.insert(index, self.frames).unwrap_or(0);
        self.trials.inc(self.frames.saturating_sub(before) as u64);
    }
}

impl Journal for Watched<'_> {
    fn kept_keyframe(&self, keyframe: usize) -> Option<Vec<Hypothesis>> {
        let kept = self.journal.kept_keyframe(keyframe);
        self.keyframes.inc(u64::from(kept.is_some()));
        kept
    }

    fn keep_keyframe(&self, keyframe: usize, hypotheses: &[Hypothesis]) {
        self.journal.keep_keyframe(keyframe, hypotheses);
        self.keyframes.inc(1);
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

    fn hypotheses(&self, count: usize) {
        self.journal.hypotheses(count);
        self.keyframes.finish_and_clear();
        self.trials.set_length((count * self.frames) as u64);
        self.trials.reset_eta();
    }

    fn advanced(&self, index: usize, frames: usize) {
        self.journal.advanced(index, frames);
        let mut fitted = self.fitted.lock().unwrap_or_else(PoisonError::into_inner);
        *fitted.entry(index).or_default() += frames;
        self.trials.inc(frames as u64);
    }
}
