//! The only code that reads and writes files, and the only one that knows their units.

pub mod calibration;
pub mod model;
