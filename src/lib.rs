//! Maquette.
pub mod body;
pub mod camera;
pub mod image;
pub mod io;
pub mod math;
pub mod render;
pub mod silhouette;
pub mod solver;
pub mod synth;
