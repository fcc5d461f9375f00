//! Maquette.
pub mod camera;
pub mod image;
pub mod io;
pub mod math;
pub mod silhouette;
