//! Files in and out: the only rooms that touch the disk and know the units of files.

pub mod calibration;
pub mod manifest;
pub mod recording;
pub mod unknown_key;
