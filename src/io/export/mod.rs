//! A fit as other programs read it.
//!
//! | file     | format                                                             |
//! |----------|--------------------------------------------------------------------|
//! | `c3d.rs` | C3D: points with SD and cameras, angles, events                    |
//! | `mot.rs` | OpenSim's motion: Rajagopal's coordinates; `.mot` and `.sto`        |
//! | `bvh.rs` | BVH: a skeleton in T-pose and its rotations                        |
//! | `glb.rs` | glTF 2.0, binary: the skin on its bones, moving                    |
//! | `table.rs` | points, angles and their SD, frame by frame; CSV               |
//! | `parquet.rs` | the same as Parquet, with the feature `parquet`                |
//!
//! Every file's world is Y up, as in a TRC (see [`UpAxis`](crate::camera::UpAxis)).

mod bvh;
mod c3d;
mod glb;
pub mod mesh;
mod mot;
#[cfg(feature = "parquet")]
mod parquet;
mod table;

pub use bvh::{BvhError, bvh};
pub use c3d::{C3dError, C3dInput, c3d};
pub use glb::{GlbError, glb};
pub use mot::{TableKind, coordinates, motion_text};
pub use table::{FrameTable, frame_table};
