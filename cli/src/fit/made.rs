//! What a recording lacks, made of its pictures and kept in OUT.

use super::arguments::FitArguments;
use crate::error::CliError;
use crate::segment;
use crate::stereo::{Method, write_surface};
use maquette::io::folder::segmented::{Extras, QUALITY};
use maquette::io::folder::stereo::{self, StereoExtras, StereoFolder};
use maquette::io::folder::{Existing, OutFolder};
use maquette::io::recording::ObservationFiles;
use maquette::io::recording::footage::Footage;
use maquette::pipeline::span;
use maquette::pipeline::stereo::StereoOptions;

/// Whether an earlier run that is continued has finished what it writes this table after.
fn is_kept(arguments: &FitArguments, table: &str) -> bool {
    arguments.existing() == Existing::Resume && arguments.out.join(table).is_file()
}

/// Makes the masks of the frames to be fitted.
pub(super) fn cut(footage: &Footage, arguments: &FitArguments) -> Result<(), CliError> {
    if is_kept(arguments, QUALITY) {
        return Ok(());
    }
    let (out, progress) = (&arguments.out, arguments.quiet.progress());
    let frames = footage.frames();
    let range = span(arguments.frames.unwrap_or_default().select(&frames)?);
    OutFolder::open(out)?;
    let (_, notes) = segment::masks(footage, range, out, Extras::default(), &progress)?;
    arguments.quiet.print_notes(&notes);
    Ok(())
}

/// Measures the points of the frames to be fitted, where the masks show the person.
pub(super) fn measure(
    footage: &Footage,
    masks: &ObservationFiles,
    method: Method,
    arguments: &FitArguments,
) -> Result<(), CliError> {
    if is_kept(arguments, stereo::TABLE) {
        return Ok(());
    }
    let frames = footage.frames();
    let frames = arguments.frames.unwrap_or_default().select(&frames)?;
    let options = StereoOptions {
        method: method.into(),
        ..StereoOptions::default()
    };
    options.choose_cameras(&footage.rig)?;
    let folder = StereoFolder::open(&arguments.out, footage.up, StereoExtras::default())?;
    let progress = arguments.quiet.progress();
    let found = write_surface(footage, Some(masks), frames, &options, folder, &progress)?;
    arguments.quiet.print_notes(&found.notes);
    Ok(())
}
