//! A fit as other programs read it.
//!
//! | file     | format                                                             |
//! |----------|--------------------------------------------------------------------|
//! | `c3d.rs` | C3D: points with SD and cameras, angles, events                    |
//! | `mot.rs` | OpenSim's motion: Rajagopal's coordinates; `.mot` and `.sto`        |
//! | `bvh.rs` | BVH: a skeleton in T-pose and its rotations                        |
//! | `glb.rs` | glTF 2.0, binary: the skin on its bones, moving                    |
//! | `table.rs` | CSV and Parquet: points, angles and their SD, frame by frame     |
//!
//! Every file's world is Y up: (X, Y, Z) of our Z-up world stands there as (Y, Z, X), as in a TRC.

mod bvh;
mod c3d;
mod glb;
mod mot;
mod table;

use nalgebra::{Matrix3, Vector3};

pub use bvh::{BvhError, bvh};
pub use c3d::{C3dError, C3dInput, c3d};
pub use glb::{GlbError, glb};
pub use mot::{MotionTable, TableKind, coordinates, motion_text};
pub use table::{FrameTable, frame_table};

/// The file's world from ours.
fn file_from_world() -> Matrix3<f64> {
    Matrix3::new(0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0)
}

/// A place of our world in the file's.
fn in_file(place: &Vector3<f64>) -> Vector3<f64> {
    Vector3::new(place.y, place.z, place.x)
}
