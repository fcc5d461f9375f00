//! What a recording lacks, made of its pictures and kept in OUT.

use super::arguments::FitArguments;
use crate::error::{CliError, one_line};
use crate::stereo::{Method, Settings};
use crate::{complain, segment};
use maquette::io::folder::segmented::{Extras, QUALITY};
use maquette::io::folder::stereo;
use maquette::io::folder::{Existing, OutFolder};
use maquette::io::recording::ObservationFiles;
use maquette::io::recording::footage::Footage;
use maquette::pipeline::span;

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
    let (_, notes) = segment::masks(footage, range, out, Extras::default(), progress)?;
    tell(&notes, arguments);
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
    let (out, progress) = (&arguments.out, arguments.quiet.progress());
    let settings = Settings::of(method);
    let frames = footage.frames();
    let frames = arguments.frames.unwrap_or_default().select(&frames)?;
    let found = crate::stereo::measure((footage, Some(masks)), frames, out, &settings, progress)?;
    tell(&found.notes, arguments);
    Ok(())
}

pub(super) fn tell(notes: &[String], arguments: &FitArguments) {
    for note in notes.iter().filter(|_| !arguments.quiet.is_on()) {
        complain("note", &one_line(note));
    }
}
