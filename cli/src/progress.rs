//! A bar for each stage, with the time left, on standard error.

use std::fmt::Write;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use indicatif::{HumanDuration, ProgressBar, ProgressState, ProgressStyle};

use super::complain;
use super::error::one_line;
use maquette::pipeline::Progress;

/// The bar of the current stage. Where standard error is no terminal none is ever seen.
#[derive(Debug)]
pub(super) struct Bars {
    is_shown: bool,
    current: Mutex<ProgressBar>,
}

impl Progress for Bars {
    fn begin(&self, stage: &'static str, steps: usize) {
        let bar = self.bar(stage, steps);
        bar.reset_eta();
        if !bar.is_hidden() {
            // its clock goes on while a step takes long
            bar.enable_steady_tick(Duration::from_millis(250));
        }
        *self.current() = bar;
    }

    fn advance(&self, steps: usize) {
        let bar = self.current();
        let after = bar.position() + steps as u64;
        // a hypothesis more may be tried than was announced
        if bar.length().is_some_and(|length| after > length) {
            bar.set_length(after);
        }
        bar.inc(steps as u64);
    }

    fn end(&self) {
        self.current().finish_and_clear();
    }

    fn note(&self, line: &str) {
        self.current().suspend(|| complain("note", &one_line(line)));
    }
}

impl Bars {
    /// Bars that are seen.
    pub(super) fn shown() -> Self {
        Self { is_shown: true, ..Self::hidden() }
    }

    /// Bars that never are.
    pub(super) fn hidden() -> Self {
        Self { is_shown: false, current: Mutex::new(ProgressBar::hidden()) }
    }

    fn current(&self) -> MutexGuard<'_, ProgressBar> {
        self.current.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn bar(&self, stage: &'static str, steps: usize) -> ProgressBar {
        if !self.is_shown {
            return ProgressBar::hidden();
        }
        let bar = ProgressBar::new(steps as u64).with_prefix(stage);
        match ProgressStyle::with_template("{prefix:<14} {bar:32} {pos:>6}/{len:<6} {left}") {
            Ok(style) => bar.with_style(style.progress_chars("━╸ ").with_key("left", write_left)),
            Err(_) => bar,
        }
    }
}

/// The time left; nothing until it can be estimated.
fn write_left(state: &ProgressState, text: &mut dyn Write) {
    if state.pos() > 0 {
        // a bar that cannot be written is no fault
        let _ = write!(text, "{:#} left", HumanDuration(state.eta()));
    }
}
