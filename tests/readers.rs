//! Readers of files: every format's samples, variants and faults.

#[path = "readers/calibration.rs"]
mod calibration;
#[path = "readers/calibration_fault_tables.rs"]
mod calibration_fault_tables;
#[path = "readers/calibration_faults.rs"]
mod calibration_faults;
#[path = "readers/calibration_samples.rs"]
mod calibration_samples;
#[path = "readers/calibration_shared.rs"]
mod calibration_shared;
#[path = "readers/calibration_writers.rs"]
mod calibration_writers;
#[path = "readers/clouds.rs"]
mod clouds;
