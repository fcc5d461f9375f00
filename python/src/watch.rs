//! Work without the interpreter's lock, which tells how far it is and can be stopped.
//!
//! The work runs on a thread of its own. The caller's thread waits for it, passes on what it tells, and looks for signals:
//! Python handles them, and calls what it is given, on the main thread alone. Once a handler or a listener has raised, the
//! work ends at its next step, by unwinding: locks and unfinished files go as they would at its end, and what was kept
//! stays, so that a run can be resumed.

use std::panic::resume_unwind;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::time::Duration;

use maquette::pipeline::Progress;
use maquette_cli::CliError;
use pyo3::prelude::*;
use rayon::ThreadPoolBuilder;

use crate::fault::exception;

/// How long a signal waits to be seen.
const TICK: Duration = Duration::from_millis(50);

/// Who is told: of each stage `progress(stage, done, steps)`, or nobody, and of each note `note(line)`.
pub(crate) type Listeners = (Option<Py<PyAny>>, Py<PyAny>);

/// Does some work, and raises what a listener or a signal's handler has raised, or what the work failed with.
pub(crate) fn watched<T: Send>(
    py: Python<'_>,
    listeners: &Listeners,
    work: impl FnOnce(&dyn Progress) -> Result<T, CliError> + Send,
) -> PyResult<T> {
    let is_stopped = &AtomicBool::new(false);
    py.detach(|| {
        std::thread::scope(|scope| {
            let (told, heard) = channel();
            let teller = Teller { told, is_stopped };
            let working = scope.spawn(move || work(&teller));

            let raised = wait(&heard, listeners, is_stopped);
            match (raised, working.join()) {
                (Some(raised), _) => Err(raised),
                (None, Ok(done)) => done.map_err(exception),
                (None, Err(panic)) => resume_unwind(panic),
            }
        })
    })
}

/// Does some work without the interpreter's lock, on a pool of its own, and raises what it failed with.
pub(crate) fn unlocked<T: Send>(
    py: Python<'_>,
    work: impl FnOnce() -> Result<T, CliError> + Send,
) -> PyResult<T> {
    py.detach(|| in_own_pool(work).map_err(exception))
}

/// Does some work on a pool of its own: a process that is forked has none of the threads of the global one, and would wait
/// for them forever.
pub(crate) fn in_own_pool<T: Send>(
    work: impl FnOnce() -> Result<T, CliError> + Send,
) -> Result<T, CliError> {
    let pool = ThreadPoolBuilder::new().build();
    let pool = pool.map_err(|source| CliError::Threads { threads: 0, source })?;
    pool.install(work)
}

/// Passes on what is heard until the work has ended; what was raised meanwhile stops it.
fn wait(heard: &Receiver<Told>, listeners: &Listeners, is_stopped: &AtomicBool) -> Option<PyErr> {
    let mut raised = None;
    let mut stage = Stage::default();
    loop {
        let first = match heard.recv_timeout(TICK) {
            Ok(told) => Some(told),
            Err(RecvTimeoutError::Timeout) => None,
            Err(RecvTimeoutError::Disconnected) => return raised,
        };
        let all = first.into_iter().chain(heard.try_iter());
        if raised.is_none() {
            let passed_on = Python::attach(|py| {
                py.check_signals()?;
                stage.pass_on(py, all, listeners)
            });
            raised = passed_on.err();
            is_stopped.store(raised.is_some(), Ordering::Relaxed);
        }
    }
}

/// What the work tells.
enum Told {
    Began(&'static str, usize),
    Advanced(usize),
    Noted(String),
}

/// Tells the thread that waits; ends the work once it is to be stopped.
struct Teller<'a> {
    told: Sender<Told>,
    is_stopped: &'a AtomicBool,
}

/// The work was stopped: what its threads unwind with.
struct Stopped;

impl Teller<'_> {
    fn tell(&self, told: Told) {
        if self.is_stopped.load(Ordering::Relaxed) && !std::thread::panicking() {
            resume_unwind(Box::new(Stopped));
        }
        // it is heard as long as the work goes on
        let _ = self.told.send(told);
    }
}

impl Progress for Teller<'_> {
    fn begin(&self, stage: &'static str, steps: usize) {
        self.tell(Told::Began(stage, steps));
    }

    fn advance(&self, steps: usize) {
        self.tell(Told::Advanced(steps));
    }

    fn note(&self, line: &str) {
        self.tell(Told::Noted(line.to_owned()));
    }
}

/// How far the current stage is.
#[derive(Default)]
struct Stage {
    name: &'static str,
    done: usize,
    steps: usize,
}

impl Stage {
    /// Calls the listeners: of a stage once for all that was heard of it at a time.
    fn pass_on(
        &mut self,
        py: Python<'_>,
        all: impl Iterator<Item = Told>,
        (progress, note): &Listeners,
    ) -> PyResult<()> {
        let mut is_news = false;
        for told in all {
            match told {
                Told::Began(name, steps) => {
                    self.report(py, progress.as_ref().filter(|_| is_news))?;
                    *self = Self { name, done: 0, steps };
                    is_news = true;
                }
                Told::Advanced(steps) => {
                    self.done += steps;
                    // a hypothesis more may be tried than was announced
                    self.steps = self.steps.max(self.done);
                    is_news |= steps > 0;
                }
                Told::Noted(line) => drop(note.call1(py, (line,))?),
            }
        }
        self.report(py, progress.as_ref().filter(|_| is_news))
    }

    fn report(&self, py: Python<'_>, progress: Option<&Py<PyAny>>) -> PyResult<()> {
        progress.map_or(Ok(()), |progress| {
            progress.call1(py, (self.name, self.done, self.steps)).map(drop)
        })
    }
}
