//! A bar for each stage, with the time left, on standard error; where that is no terminal, a line from time to time.

use std::fmt::Write;
use std::io::IsTerminal;
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

use indicatif::{HumanDuration, ProgressBar, ProgressState, ProgressStyle};

use super::complain;
use super::error::one_line;
use maquette::pipeline::Progress;

/// A stage that takes longer is told of, and from then on from time to time.
const FIRST: Duration = Duration::from_secs(3);
const EVERY: Duration = Duration::from_secs(10);

/// The bar of the current stage. Where standard error is no terminal it is not seen, and lines are written instead.
#[derive(Debug)]
pub(super) struct Bars {
    is_shown: bool,
    current: Mutex<ProgressBar>,
    speaker: Mutex<Option<Speaker>>,
}

impl Progress for Bars {
    fn begin(&self, stage: &'static str, steps: usize) {
        let bar = self.bar(stage, steps);
        bar.reset_eta();
        if !bar.is_hidden() {
            // its clock goes on while a step takes long
            bar.enable_steady_tick(Duration::from_millis(250));
        }
        if self.is_shown && !std::io::stderr().is_terminal() {
            let print = |line: &str| complain("progress", line);
            self.speak(Some(Speaker::start(stage, bar.clone(), [FIRST, EVERY], print)));
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
        self.speak(None);
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
        let current = Mutex::new(ProgressBar::hidden());
        Self { is_shown: false, current, speaker: Mutex::default() }
    }

    /// Replaces whoever tells of the stage.
    fn speak(&self, speaker: Option<Speaker>) {
        let mut current = self.speaker.lock().unwrap_or_else(PoisonError::into_inner);
        *current = speaker;
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

/// A thread that tells how far a stage is, until it is dropped.
#[derive(Debug)]
struct Speaker {
    /// Without it the thread ends.
    ends: Option<Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

impl Speaker {
    /// Tells of a stage after the first of these times, and then each time the second has gone by.
    fn start(
        stage: &'static str,
        bar: ProgressBar,
        [first, every]: [Duration; 2],
        print: impl Fn(&str) + Send + 'static,
    ) -> Self {
        let (ends, ended) = channel::<()>();
        let thread = std::thread::spawn(move || {
            let mut wait = first;
            while ended.recv_timeout(wait) == Err(RecvTimeoutError::Timeout) {
                print(&line(stage, bar.position(), bar.length().unwrap_or(0)));
                wait = every;
            }
        });
        Self { ends: Some(ends), thread: Some(thread) }
    }
}

impl Drop for Speaker {
    fn drop(&mut self) {
        self.ends = None;
        if let Some(thread) = self.thread.take() {
            // what it could not print is no fault
            let _ = thread.join();
        }
    }
}

/// How far a stage is; all of its steps may be done before what follows from them.
fn line(stage: &str, done: u64, steps: u64) -> String {
    match done < steps {
        true => format!("{stage}: {done} of {steps}"),
        false => format!("{stage}: all {steps} done, finishing"),
    }
}

/// The time left; nothing until it can be estimated.
fn write_left(state: &ProgressState, text: &mut dyn Write) {
    if state.pos() > 0 {
        // a bar that cannot be written is no fault
        let _ = write!(text, "{:#} left", HumanDuration(state.eta()));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stage_that_takes_long_is_told_of_again_and_again_until_it_ends() {
        let (told, lines) = channel();
        let bar = ProgressBar::hidden();
        bar.set_length(40);
        bar.inc(7);
        let print = move |line: &str| {
            let _ = told.send(line.to_owned());
        };
        let speaker = Speaker::start("masks", bar, [Duration::from_millis(1); 2], print);
        assert_eq!(lines.recv().as_deref(), Ok("masks: 7 of 40"));
        assert!(lines.recv().is_ok());
        drop(speaker);
        // the thread has ended, and with it the channel
        assert_eq!(lines.iter().filter(|line| line != "masks: 7 of 40").count(), 0);
    }

    #[test]
    fn a_stage_of_which_all_is_done_is_not_said_to_have_nothing_left() {
        assert_eq!(line("hypotheses", 40, 40), "hypotheses: all 40 done, finishing");
    }
}
