//! What went wrong, in one line.

use maquette::gait::GaitError;
use maquette::io::export::{BvhError, C3dError, GlbError};
use maquette::io::folder::OutError;
use maquette::io::folder::journal::JournalError;
use maquette::io::folder::overlays::OverlayError;
use maquette::io::gait::{GaitInputError, NormError};
use maquette::io::model::ModelFileError;
use maquette::io::recording::RecordingError;
use maquette::io::recording::footage::FootageError;
use maquette::io::recording::synthetic::SyntheticError;
use maquette::io::result::ResultError;
use maquette::pipeline::FitError;
use maquette::pipeline::stereo::StereoError;
use maquette::skin::SkinError;
use maquette::synth::{FilmError, WalkError};

/// Why a command could not be carried out.
#[derive(Debug, thiserror::Error)]
pub(super) enum CliError {
    /// Arguments that make no sense.
    #[error("{0}")]
    Arguments(String),
    /// The recording.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// The pictures.
    #[error(transparent)]
    Frames(Box<FootageError>),
    /// No frame of the recording is in the range asked for.
    #[error(transparent)]
    FrameRange(#[from] maquette::pipeline::FrameRangeError),
    /// No fitted frame is what was asked for.
    #[error("{asked}: no fitted frame has such a number: the result has {first} to {last}")]
    NotFitted {
        /// As asked for.
        asked: String,
        /// First fitted frame.
        first: usize,
        /// Last fitted frame.
        last: usize,
    },
    /// A mesh of no known format.
    #[error("--skin {}: expected a name that ends in .ply or .obj", path.display())]
    MeshFormat {
        /// As asked for.
        path: std::path::PathBuf,
    },
    /// A result that cannot be read.
    #[error(transparent)]
    Result(#[from] ResultError),
    /// A body that has no skin.
    #[error(transparent)]
    Skin(#[from] SkinError),
    /// The body.
    #[error(transparent)]
    Model(#[from] ModelFileError),
    /// What cannot be fitted.
    #[error(transparent)]
    Fit(#[from] FitError),
    /// The result's folder.
    #[error(transparent)]
    Out(#[from] OutError),
    /// A run that cannot be continued.
    #[error(transparent)]
    Journal(#[from] JournalError),
    /// The pictures.
    #[error(transparent)]
    Overlay(#[from] OverlayError),
    /// The threads.
    #[error("--threads {threads}: {source}")]
    Threads {
        /// As asked for.
        threads: usize,
        /// Why not.
        source: rayon::ThreadPoolBuildError,
    },
    /// What cannot be matched.
    #[error(transparent)]
    Stereo(#[from] StereoError),
    /// A body that cannot walk.
    #[error(transparent)]
    Walk(#[from] WalkError),
    /// A synthetic recording of photographs.
    #[error(transparent)]
    Film(#[from] FilmError),
    /// A synthetic recording that cannot be written.
    #[error(transparent)]
    Synthetic(#[from] SyntheticError),
    /// What gait analysis cannot read.
    #[error(transparent)]
    GaitInput(#[from] GaitInputError),
    /// A recording without gait.
    #[error(transparent)]
    Gait(#[from] GaitError),
    /// A C3D that cannot be written.
    #[error(transparent)]
    C3d(#[from] C3dError),
    /// A BVH that cannot be written.
    #[error(transparent)]
    Bvh(#[from] BvhError),
    /// A glTF that cannot be written.
    #[error(transparent)]
    Glb(#[from] GlbError),
    /// Points where a fit is needed.
    #[error("{}: expected the folder of a finished fit, found points without a body", path.display())]
    NoFit {
        /// As asked for.
        path: std::path::PathBuf,
    },
    /// A body that the coordinates of OpenSim do not fit.
    #[error("{}: --format {format}: the body {body} has no part named pelvis", path.display())]
    NoCoordinates {
        /// The fit.
        path: std::path::PathBuf,
        /// As asked for.
        format: &'static str,
        /// The model.
        body: String,
    },
    /// A norm that cannot be used.
    #[error(transparent)]
    Norm(#[from] NormError),
    /// A table that cannot be written.
    #[error("a table cannot be written: {0}")]
    Table(#[from] std::io::Error),
    /// A result that is no JSON.
    #[error("result.json: {0}")]
    Json(#[from] serde_json::Error),
}

impl From<FootageError> for CliError {
    fn from(fault: FootageError) -> Self {
        Self::Frames(Box::new(fault))
    }
}

/// What clap says about arguments, without usage and hints to help, in one line.
pub(super) fn of_arguments(fault: &clap::Error) -> String {
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

/// A text in one line, whatever file names and parsers put into it.
pub(super) fn one_line(text: &str) -> String {
    let lines = text.lines().map(str::trim).filter(|line| !line.is_empty());
    let joined = lines.collect::<Vec<_>>().join(", ");
    let printable = |c: char| if c.is_control() { ' ' } else { c };
    joined.chars().map(printable).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_text_of_several_lines_becomes_one() {
        assert_eq!(one_line("a: b\n  |\n  ^ c\r\n\n"), "a: b, |, ^ c");
        assert_eq!(one_line("odd\u{7}name"), "odd name");
    }
}
