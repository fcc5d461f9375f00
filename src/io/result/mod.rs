//! `result.json` and `joints.trc`: what a fit leaves behind.
//!
//! | file         | holds                                                       |
//! |--------------|-------------------------------------------------------------|
//! | `schema.rs`  | [`ResultFile`], field by field                               |
//! | `parts.rs`   | how a fit is written down in it                              |
//! | `layout.rs`  | where its lines break                                        |
//! | `read.rs`    | a result read back                                          |
//! | `joints.rs`  | [`trajectories`]: the points, in Pose2Sim's order            |
//!
//! The same fit gives the same bytes: no clock, no path of this machine.

mod joints;
mod layout;
mod parts;
mod read;
mod schema;

use serde::Serialize;
use serde_json::Serializer;

pub use joints::trajectories;
pub use parts::Provenance;
pub use read::ResultError;
pub use schema::{
    CoefficientPart, FramePart, HypothesisPart, LengthPart, MotionPart, OptionsPart, OriginPart,
    OutcomePart, Program, QualityPart, RecordingPart, RejectedPart, ResultFile, ShapePart,
};

impl ResultFile {
    /// The text of the file. A number that is not finite stands there as `null`.
    ///
    /// # Errors
    /// None that a result can cause; the serialiser's, if it has any.
    pub fn text(&self) -> Result<Vec<u8>, serde_json::Error> {
        let mut bytes = Vec::new();
        self.serialize(&mut Serializer::with_formatter(&mut bytes, layout::Layout::default()))?;
        bytes.push(b'\n');
        Ok(bytes)
    }
}
