//! Files in and out: the only code that knows formats and the units of files.

//!
//! | room            | what it reads and writes                                                       |
//! |-----------------|--------------------------------------------------------------------------------|
//! | [`calibration`] | cameras, as a dozen programs write them                                        |
//! | [`model`]       | body models                                                                    |
//! | [`recording`]   | a recording on disk: manifest, masks, pictures, points; synthetic recordings   |
//! | [`points`]      | point clouds, and points over time (TRC)                                       |
//! | [`result`]      | what a fit leaves behind                                                       |
//! | [`gait`]        | what gait analysis reads and leaves behind; norms                              |
//! | [`session`]     | several trials of one person: who, where, and what was found                   |
//! | [`export`]      | a fit in the formats of other programs                                         |
//! | [`folder`]      | the folder that a run writes into                                              |
//! | [`frame_rate`]  | which frame rates there are                                                    |
//! | `input`         | a file that somebody names, of a kind and size that can be read                |

pub mod calibration;
pub mod detections;
pub mod export;
pub mod folder;
pub mod frame_rate;
pub mod gait;
pub(crate) mod input;
pub mod model;
pub mod points;
pub mod recording;
pub mod result;
pub mod session;
mod unknown_key;
