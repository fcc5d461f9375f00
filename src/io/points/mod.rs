//! Point clouds: PLY, XYZ and CSV in, PLY out.
//!
//! | file         | holds                                                                        |
//! |--------------|------------------------------------------------------------------------------|
//! | `columns.rs` | which numbers of a point a file has, and the point they make                 |
//! | `ply.rs`     | PLY, ascii and binary                                                        |
//! | `text.rs`    | XYZ (numbers with blanks between) and CSV (with a header)                    |
//! | `write.rs`   | PLY, binary                                                                  |
//!
//! A file's points are read unchanged: the recording knows their unit and their world.

mod columns;
mod error;
mod ply;
mod text;
pub mod trc;
mod write;

use std::path::Path;

use crate::io::input;
use crate::stereo::Cloud;

pub use error::CloudError;
pub use write::ply as write_ply;

/// Larger files are refused before they are read.
const MOST_BYTES: u64 = 1 << 28;

/// What the name of a file says it holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Ply,
    Xyz,
    Csv,
}

impl Kind {
    fn from_name(path: &Path) -> Option<Self> {
        let extension = path.extension()?.to_str()?.to_lowercase();
        match extension.as_str() {
            "ply" => Some(Self::Ply),
            "xyz" | "txt" => Some(Self::Xyz),
            "csv" => Some(Self::Csv),
            _ => None,
        }
    }
}

/// Whether a file's name is that of a point cloud.
pub(crate) fn is_cloud(path: &Path) -> bool {
    Kind::from_name(path).is_some()
}

/// The usable points of a file, and how many are not.
///
/// # Errors
/// [`CloudError`] with the line or the byte where there is one.
pub fn read(path: &Path) -> Result<Cloud, CloudError> {
    let unreadable = |source| CloudError::Read { path: path.into(), source };
    parse(&input::read(path, MOST_BYTES).map_err(unreadable)?, path)
}

/// [`read`] for bytes in memory; the name in `path` tells their format. No bytes are no points.
///
/// # Errors
/// As [`read`].
pub fn parse(bytes: &[u8], path: &Path) -> Result<Cloud, CloudError> {
    let kind = Kind::from_name(path).ok_or_else(|| CloudError::Kind { path: path.into() })?;
    if bytes.is_empty() {
        return Ok(Cloud::default());
    }
    match kind {
        Kind::Ply => ply::parse(bytes, path),
        Kind::Xyz => text::parse_xyz(bytes, path),
        Kind::Csv => text::parse_csv(bytes, path),
    }
}
