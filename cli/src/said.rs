//! What a command has to say of what it found.

use std::path::PathBuf;

use serde_json::Value;

use super::switches::{Output, print_notes};

/// The summary of what was found and written, for a person and as JSON, and what a person should know beside it.
#[derive(Debug)]
pub(super) struct Said {
    pub(super) text: String,
    /// What `--json` prints.
    pub(super) json: Value,
    pub(super) notes: Vec<String>,
}

impl Said {
    /// Prints the notes, and the summary as it was asked for.
    pub(super) fn print(self, output: Output) {
        print_notes(&self.notes);
        output.summarise(|| self.text, || self.json);
    }
}

/// The files that were written.
pub(super) fn in_a_line(written: &[PathBuf]) -> String {
    let files: Vec<String> = written.iter().map(|path| path.display().to_string()).collect();
    files.join(", ")
}
