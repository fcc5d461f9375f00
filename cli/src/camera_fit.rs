//! What `calibrate` and `sync` take that fit a recording for its cameras.

use std::path::{Path, PathBuf};

use clap::Args;
use maquette::FitOptions;
use maquette::io::folder::Existing;
use maquette::pipeline::FrameRange;

use super::error::CliError;

/// How a recording is fitted for its cameras.
#[derive(Debug, Args)]
pub(super) struct CameraFitArguments {
    /// Frames per second; overrides sequence.toml
    #[arg(long, value_name = "HZ", allow_negative_numbers = true)]
    pub(super) fps: Option<f64>,
    /// Body model: a shipped one (see `maquette models`) or a .toml file [default: that of sequence.toml, or human-metaballs]
    #[arg(long, value_name = "NAME|FILE")]
    body: Option<String>,
    /// Only these frames, first and last included [default: all]
    #[arg(long, value_name = "FIRST:LAST")]
    frames: Option<FrameRange>,
    /// Replace files that stand there
    #[arg(long)]
    overwrite: bool,
}

impl CameraFitArguments {
    /// What to do with files that stand there.
    pub(super) fn existing(&self) -> Existing {
        match self.overwrite {
            true => Existing::Overwrite,
            false => Existing::Refuse,
        }
    }

    /// The options of the fit.
    pub(super) fn options(&self) -> FitOptions {
        FitOptions {
            body: self.body.clone(),
            frames: self.frames.unwrap_or_default(),
            ..FitOptions::default()
        }
    }
}

/// Whether files may be written: none of them stands there, or they may be replaced.
pub(super) fn check_free(files: &[PathBuf], existing: Existing) -> Result<(), CliError> {
    let standing = files.iter().find(|path| path.exists());
    match standing {
        Some(path) if existing == Existing::Refuse => Err(CliError::Arguments(format!(
            "{}: this file stands already: give --overwrite to replace it, or another --out",
            path.display()
        ))),
        _ => check_folders(files),
    }
}

/// Whether the folders are there that files are written into.
fn check_folders(files: &[PathBuf]) -> Result<(), CliError> {
    let folder = |path: &PathBuf| path.parent().map(Path::to_path_buf).unwrap_or_default();
    let is_lacking = |folder: &PathBuf| !folder.as_os_str().is_empty() && !folder.is_dir();
    match files.iter().map(folder).find(is_lacking) {
        Some(folder) => Err(CliError::Arguments(format!(
            "{}: no such folder: expected one to write into",
            folder.display()
        ))),
        None => Ok(()),
    }
}
