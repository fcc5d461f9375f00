//! What went wrong, in one line.

use maquette::io::folder::OutError;
use maquette::io::folder::pdf::PdfError;
use maquette::io::gait::NormError;
use maquette::io::model::ModelFileError;
use maquette::io::recording::RecordingError;
use maquette::io::recording::synthetic::SyntheticError;
use maquette::io::result::ResultError;
use maquette::pipeline::stereo::StereoError;
use maquette::pipeline::{FitError, FrameRangeError};
use maquette::synth::{FilmError, WalkError};

/// Why a command could not be carried out.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CliError {
    /// Arguments that make no sense.
    #[error("{0}")]
    Arguments(String),
    /// What the library says.
    #[error(transparent)]
    Library(Box<maquette::Error>),
    /// The threads.
    #[error("--threads {threads}: {source}")]
    Threads {
        /// As asked for.
        threads: usize,
        /// Why not.
        source: rayon::ThreadPoolBuildError,
    },
    /// A body that cannot walk.
    #[error(transparent)]
    Walk(#[from] WalkError),
    /// A synthetic recording of photographs.
    #[error(transparent)]
    Film(#[from] FilmError),
    /// A synthetic recording that cannot be written.
    #[error(transparent)]
    Synthetic(#[from] SyntheticError),
}

impl CliError {
    /// Arguments that clap refuses.
    pub(super) fn arguments(fault: &clap::Error) -> Self {
        Self::Arguments(arguments_message(fault))
    }

    /// What went wrong, in one line that can be read.
    pub fn line(&self) -> String {
        one_line(&self.to_string())
    }

    /// 3 for a result that is not to be used, 2 for what could not be done.
    pub(super) fn exit_code(&self) -> u8 {
        match self {
            Self::Library(fault) if matches!(**fault, maquette::Error::Unusable(_)) => 3,
            _ => 2,
        }
    }
}

/// Whatever the library's own calls fail with is its error.
macro_rules! from_library {
    ($($fault:ty),*) => {
        $(impl From<$fault> for CliError {
            fn from(fault: $fault) -> Self {
                maquette::Error::from(fault).into()
            }
        })*
    };
}

from_library!(
    FitError,
    FrameRangeError,
    ModelFileError,
    NormError,
    OutError,
    PdfError,
    RecordingError,
    ResultError,
    StereoError
);

impl From<maquette::Error> for CliError {
    fn from(fault: maquette::Error) -> Self {
        Self::Library(Box::new(fault))
    }
}

/// What clap says about arguments, without usage and hints to help, in one line.
fn arguments_message(fault: &clap::Error) -> String {
    let text = fault.render().to_string();
    let lines: Vec<&str> = text
        .lines()
        .map(str::trim)
        .take_while(|line| !line.starts_with("Usage:") && !line.starts_with("For more information"))
        .filter(|line| !line.is_empty() && !line.starts_with("tip: to pass"))
        .collect();
    let (first, rest) = lines.split_first().unwrap_or((&"", &[]));
    let first = first.trim_start_matches("error: ");
    let rest = rest.join(", ");
    match (rest.as_str(), first.ends_with(':')) {
        ("", _) => format!("{first} (--help says more)"),
        (rest, true) => format!("{first} {rest}"),
        (rest, false) => format!("{first}; {rest}"),
    }
}

/// A text in one line that can be read, whatever file names or parsers have put into it.
pub(super) fn one_line(text: &str) -> String {
    let lines = text.lines().map(str::trim).filter(|line| !line.is_empty());
    let joined = lines.collect::<Vec<_>>().join(", ");
    let text = printable(&joined);
    let count = text.chars().count();
    if count <= MOST_CHARACTERS {
        return text;
    }
    // what is wrong stands at the beginning, what to do at the end
    let kept = MOST_CHARACTERS / 2;
    let first: String = text.chars().take(kept).collect();
    let last: String = text.chars().skip(count - kept).collect();
    format!("{first} … {last}")
}

/// The most characters of a line.
const MOST_CHARACTERS: usize = 1000;

/// A text whose control characters are spelt out, so that no file's name or content commands the terminal.
pub(super) fn printable(text: &str) -> String {
    let mut printable = String::with_capacity(text.len());
    for c in text.chars() {
        match c.is_control() && c != '\n' {
            true => printable.extend(c.escape_default()),
            false => printable.push(c),
        }
    }
    printable
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_text_of_several_lines_becomes_one() {
        assert_eq!(one_line("a: b\n  |\n  ^ c\r\n\n"), "a: b, |, ^ c");
        assert_eq!(one_line("odd\u{1b}[31mname"), "odd\\u{1b}[31mname");
    }

    #[test]
    fn a_line_of_a_whole_file_is_cut_in_the_middle() {
        let line =
            one_line(&format!("rec/calibration.toml:1: {}: what to do", "7".repeat(20_000_000)));
        assert!(line.starts_with("rec/calibration.toml:1: 777") && line.ends_with("7: what to do"));
        assert!(line.chars().count() < 1010);
    }
}
