//! Tables as CSV: a row for each record, under the names of its fields.

use std::io;
use std::path::Path;

use serde::Serialize;

use super::out_folder::{OutError, write_atomically};

/// Writes a table; without rows it has no heading either.
///
/// # Errors
/// [`OutError::Write`].
pub(super) fn write<Row: Serialize>(path: &Path, rows: &[Row]) -> Result<(), OutError> {
    let encoded = || -> Result<Vec<u8>, csv::Error> {
        let mut writer = csv::Writer::from_writer(Vec::new());
        for row in rows {
            writer.serialize(row)?;
        }
        writer.into_inner().map_err(|e| e.into_error().into())
    };
    let bytes = encoded().map_err(|fault| OutError::write(path, io::Error::other(fault)))?;
    write_atomically(path, &bytes)
}
