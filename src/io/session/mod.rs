//! A session of trials: who walked in which recordings, and what was found.
//!
//! | file          | holds                                                        |
//! |---------------|--------------------------------------------------------------|
//! | `manifest.rs` | [`SessionManifest`]: `session.toml`, written by a person      |
//! | `person.rs`   | [`Person`]: whom both files name                              |
//! | `listed.rs`   | the trials of folders that are no session yet                 |
//! | `file.rs`     | [`SessionFile`]: `session.json`, written by the program        |

mod file;
mod listed;
mod manifest;
mod person;

use std::path::PathBuf;

pub use file::{DisagreementPart, SESSION, SessionFile, SessionLength, TrialPart};
pub use listed::session_of;
pub use manifest::{SessionManifest, TrialEntry};
pub use person::{Date, Person};

/// Why a session cannot be read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SessionFileError {
    /// A file that cannot be read.
    #[error("{}: cannot be read: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// A `session.toml` that is wrong.
    #[error("{}:{line}: {message}", path.display())]
    Manifest {
        /// The file.
        path: PathBuf,
        /// The line, from 1.
        line: usize,
        /// What is wrong with it.
        message: String,
    },
    /// A `session.toml` that names nothing to fit.
    #[error("{}: no trials: expected [[trial]] with recording = \"folder\", once for each", path.display())]
    NoTrials {
        /// The file.
        path: PathBuf,
    },
    /// A `session.toml` that names no walk.
    #[error("{}: every trial is a standing one: expected a walk as well", path.display())]
    NoWalks {
        /// The file.
        path: PathBuf,
    },
    /// A folder without recordings.
    #[error(
        "{}: no recordings there: expected session.toml, or folders that each hold masks, videos, images or a sequence.toml",
        path.display()
    )]
    NoRecordings {
        /// The folder.
        path: PathBuf,
    },
    /// A session among several folders.
    #[error("{}: one of several folders is a session of its own: name the trials of all and their conditions in one session.toml, and give that alone", path.display())]
    OneOfSeveral {
        /// Its file.
        path: PathBuf,
    },
    /// Two trials of one name.
    #[error("two trials are named {name}: {} and {}; give them names in a session.toml", first.display(), second.display())]
    SameName {
        /// The name.
        name: String,
        /// A recording.
        first: PathBuf,
        /// Another.
        second: PathBuf,
    },
    /// A `session.json` that is none.
    #[error("{}: not a session of `maquette session`: {message}", path.display())]
    Session {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        message: String,
    },
    /// A session of other fields than this program knows.
    #[error("{}: version {found} of the format; this program reads version {expected}: make the session again", path.display())]
    Version {
        /// The file.
        path: PathBuf,
        /// Its version.
        found: u32,
        /// The one that is read.
        expected: u32,
    },
}
