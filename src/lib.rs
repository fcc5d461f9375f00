//! Maquette.
pub mod body;
pub mod camera;
pub mod image;
pub mod inference;
pub mod io;
pub mod likelihood;
pub mod math;
pub mod pipeline;
pub mod silhouette;
pub mod solver;
