//! `result.json` and `joints.trc`: what a fit leaves behind.
//!
//! | file         | holds                                                       |
//! |--------------|-------------------------------------------------------------|
//! | `schema.rs`  | [`ResultFile`], field by field                               |
//! | `parts.rs`   | how a fit is written down in it                              |
//! | `layout.rs`  | where its lines break                                        |
//! | `seal.rs`    | the sums at its end                                          |
//! | `read.rs`    | a result read back                                          |
//! | `check.rs`   | whether its numbers are ones that a fit can have            |
//! | `alone.rs`   | a result of one trial of a session                          |
//! | `joints.rs`  | [`trajectories`]: the points, in Pose2Sim's order            |
//!
//! The same fit gives the same bytes: no clock, no path of this machine.

mod alone;
mod check;
mod joints;
mod layout;
mod parts;
mod read;
mod schema;
mod seal;

use serde::Serialize;
use serde_json::Serializer;

use crate::io::points::trc::write_trc;

pub use joints::trajectories;
pub use parts::Provenance;
pub use read::ResultError;
pub use schema::{
    CoefficientPart, FramePart, HypothesisPart, LengthPart, MotionPart, OptionsPart, OriginPart,
    OutcomePart, PlacePart, Program, QualityPart, RecordingPart, RejectedPart, ResultFile,
    ShapePart,
};

/// What `format` says.
pub(crate) const FORMAT: &str = "maquette-result";
/// The version of the fields that this program writes and reads.
pub(crate) const VERSION: u32 = 6;

/// Name of the file of the result, and of the points beside it.
pub(crate) const RESULT: &str = "result.json";
const JOINTS: &str = "joints.trc";

impl ResultFile {
    /// The files that a fit leaves behind, the result last: where it stands all of it stands.
    ///
    /// The result ends with the sum of `joints.trc` and its own. A number that is not finite stands there as `null`.
    ///
    /// # Errors
    /// None that a result can cause; the serialiser's, if it has any.
    pub fn files(&self) -> Result<[(&'static str, Vec<u8>); 2], serde_json::Error> {
        let joints = write_trc(&trajectories(self), JOINTS).into_bytes();
        let mut object = Vec::new();
        self.serialize(&mut Serializer::with_formatter(&mut object, layout::Layout::default()))?;
        let result = seal::seal(&object, &joints);
        Ok([(JOINTS, joints), (RESULT, result)])
    }
}
