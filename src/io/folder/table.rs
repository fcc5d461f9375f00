//! Tables as CSV: a row for each record, under the names of its fields.

use std::io;

use serde::Serialize;

use super::{OutError, OutFolder};

/// Ends the run that was begun with this mark by writing it, a table; without rows it has no heading either.
///
/// # Errors
/// [`OutError::Write`].
pub(super) fn finish<Row: Serialize>(
    out: &OutFolder,
    mark: &str,
    rows: &[Row],
) -> Result<(), OutError> {
    let encoded = || -> Result<Vec<u8>, csv::Error> {
        let mut writer = csv::Writer::from_writer(Vec::new());
        for row in rows {
            writer.serialize(row)?;
        }
        writer.into_inner().map_err(|e| e.into_error().into())
    };
    let bytes = encoded().map_err(io::Error::other);
    out.finish(mark, bytes)
}
