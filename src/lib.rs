//! Maquette.
pub mod camera;
pub mod io;
pub mod math;
