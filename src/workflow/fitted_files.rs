//! What a finished fit was fitted to.

use std::path::Path;

use super::Error;
use crate::io::recording::footage::Footage;
use crate::io::recording::{DerivedFiles, ObservationFiles, Recording};
use crate::io::result::ResultFile;

/// What the body was fitted to; where masks or points were made of pictures, those of the fit's folder, and the pictures.
pub(super) fn fitted_files(
    result: Option<&ResultFile>,
    recording: &Recording,
    out: &Path,
) -> Result<(ObservationFiles, Option<Footage>), Error> {
    let inputs = result.map_or(&[][..], |result| &result.inputs);
    let has = |start: &str| inputs.iter().any(|input| input.input.starts_with(start));
    if !has("pictures of ") {
        return Ok((recording.observations()?, None));
    }
    let footage = recording.footage()?;
    let files = recording.with_derived(DerivedFiles {
        footage: &footage,
        folder: out,
        has_masks: has("masks of ") && out.join("masks").is_dir(),
        has_points: has("points") && out.join("points").is_dir(),
    })?;
    Ok((files, Some(footage)))
}
