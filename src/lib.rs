//! Maquette.
pub mod camera;
pub mod math;
