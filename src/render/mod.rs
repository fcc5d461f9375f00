//! What a camera would see of a body.
//!
//! | file         | holds                                                             |
//! |--------------|-------------------------------------------------------------------|
//! | `raycast.rs` | [`silhouette`]: the mask of a metaball body, by casting rays       |
//! | `profile.rs` | [`RayProfile`]: the field along one ray, as a sum of bumps          |
//!
//! Nothing here is shared with the likelihoods: what is rendered here is what they are tested on.

mod profile;
mod raycast;

pub use profile::{Bump, RayProfile};
pub use raycast::silhouette;
