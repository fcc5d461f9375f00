//! What every command takes that reads the pictures of a recording and writes a folder.

use std::path::{Path, PathBuf};

use clap::Args;
use maquette::Recording;
use maquette::io::folder::check_out;
use maquette::pipeline::FrameRange;

use super::error::CliError;
use super::switches::{Output, Overwrite};

/// Where pictures are read from, which of them, and where to write.
#[derive(Debug, Args)]
pub(super) struct PictureArguments {
    /// Folder with a calibration and videos or images, or a sequence.toml
    recording: PathBuf,
    /// Folder to write into; it must be empty or new
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Frames per second; overrides the recording's
    #[arg(long, value_name = "HZ", allow_negative_numbers = true)]
    fps: Option<f64>,
    /// Only these frames, first and last included [default: all]
    #[arg(long, value_name = "FIRST:LAST")]
    frames: Option<FrameRange>,
    #[command(flatten)]
    overwrite: Overwrite,
    #[command(flatten)]
    pub(super) output: Output,
}

impl PictureArguments {
    /// Opens the recording, if the folder may be written into.
    pub(super) fn open(&self) -> Result<Recording, CliError> {
        check_out(&self.out, self.overwrite.existing())?;
        Ok(Recording::open(&self.recording)?.with_fps(self.fps))
    }

    /// The folder to write into.
    pub(super) fn out(&self) -> &Path {
        &self.out
    }

    /// The frames that are wanted.
    pub(super) fn frames(&self) -> FrameRange {
        self.frames.unwrap_or_default()
    }
}
