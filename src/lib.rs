//! Maquette.
pub mod body;
pub mod camera;
pub mod io;
pub mod math;
pub mod solver;
