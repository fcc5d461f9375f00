//! Maquette.
pub mod camera;
pub mod image;
pub mod math;
pub mod silhouette;
