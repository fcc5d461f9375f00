//! Arms held where no silhouette shows them, and how far fitted arms are from the true ones (ZS06 Fig. 6).

mod arms;
mod recording;

pub use arms::{ARMS, Arm, ArmError, Summary};
pub use recording::{CAMERAS, FRAMES, Holding, RightArm, held, held_s, visible};
