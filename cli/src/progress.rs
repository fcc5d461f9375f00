//! A bar for each stage, with the time left, on standard error.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use indicatif::{HumanDuration, ProgressBar, ProgressState, ProgressStyle};

use super::complain;
use super::error::one_line;
use maquette::inference::search::{Hypothesis, Journal, Trial};
use maquette::pipeline::Progress;

/// The bar of the current stage. Where standard error is no terminal none is ever seen.
#[derive(Debug)]
pub(super) struct Bars {
    is_shown: bool,
    current: Mutex<ProgressBar>,
}

impl Progress for Bars {
    fn begin(&self, stage: &'static str, steps: usize) {
        *self.current() = self.bar(stage, steps);
    }

    fn advance(&self, steps: usize) {
        self.current().inc(steps as u64);
    }

    fn end(&self) {
        self.current().finish_and_clear();
    }

    fn note(&self, line: &str) {
        if self.is_shown {
            self.current().suspend(|| complain("note", &one_line(line)));
        }
    }
}

impl Bars {
    /// Bars that are seen.
    pub(super) fn shown() -> Self {
        Self {
            is_shown: true,
            ..Self::hidden()
        }
    }

    /// Bars that never are.
    pub(super) fn hidden() -> Self {
        Self {
            is_shown: false,
            current: Mutex::new(ProgressBar::hidden()),
        }
    }

    fn current(&self) -> MutexGuard<'_, ProgressBar> {
        self.current.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The bar of a stage of `steps` steps, to be seen at once.
    fn bar(&self, stage: &'static str, steps: usize) -> ProgressBar {
        let bar = self.bar_for_later(stage);
        bar.set_length(steps as u64);
        show(&bar);
        bar
    }

    /// The bar of a stage that has not begun.
    fn bar_for_later(&self, stage: &'static str) -> ProgressBar {
        if !self.is_shown {
            return ProgressBar::hidden();
        }
        let bar = ProgressBar::new(0).with_prefix(stage);
        match ProgressStyle::with_template("{prefix:<14} {bar:32} {pos:>6}/{len:<6} {left}") {
            Ok(style) => bar.with_style(style.progress_chars("━╸ ").with_key("left", write_left)),
            Err(_) => bar,
        }
    }
}

/// Shows a bar, and keeps its clock going while a step takes long.
fn show(bar: &ProgressBar) {
    bar.reset_eta();
    if !bar.is_hidden() {
        bar.enable_steady_tick(Duration::from_millis(250));
    }
}

/// The time left; nothing until something is known of it.
fn write_left(state: &ProgressState, text: &mut dyn Write) {
    if state.pos() > 0 {
        // a bar that cannot be written is no fault
        let _ = write!(text, "{:#} left", HumanDuration(state.eta()));
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
        bars: &Bars,
        keyframes: usize,
        frames: usize,
    ) -> Self {
        Self {
            journal,
            keyframes: bars.bar("keyframes", keyframes),
            trials: bars.bar_for_later("hypotheses"),
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
        self.advance(self.frames.saturating_sub(before));
    }

    /// Moves the bar, which grows where one hypothesis more is tried than were announced.
    fn advance(&self, frames: usize) {
        let after = self.trials.position() + frames as u64;
        if self.trials.length().is_some_and(|length| after > length) {
            self.trials.inc_length(self.frames as u64);
        }
        self.trials.inc(frames as u64);
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
        show(&self.trials);
    }

    fn advanced(&self, index: usize, frames: usize) {
        self.journal.advanced(index, frames);
        let mut fitted = self.fitted.lock().unwrap_or_else(PoisonError::into_inner);
        *fitted.entry(index).or_default() += frames;
        self.advance(frames);
    }
}
