//! Cameras that are not where their calibration says, or not on time, before a person who walks.

mod ellipsoid_person;

#[path = "cameras/jumps.rs"]
mod jumps;
#[path = "cameras/side_by_side.rs"]
mod side_by_side;
#[path = "cameras/walker.rs"]
mod walker;
