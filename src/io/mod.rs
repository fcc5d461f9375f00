//! Files in and out: the only code that knows formats and the units of files.

pub mod calibration;
pub mod cloud;
pub mod export;
pub mod filmed;
pub mod frames;
pub mod gait;
pub mod journal;
pub mod jpeg;
pub mod layout;
pub mod manifest;
pub mod mesh;
pub mod model;
pub mod out_folder;
pub mod overlays;
mod png;
pub mod recording;
pub mod result;
pub mod segmented;
pub mod silhouettes;
pub mod stereo;
pub mod synthetic;
mod table;
pub mod trc;
pub mod unknown_key;
