//! Synthetic recordings: a body, a walk, cameras and segmentation errors, with the truth beside them.
//!
//! Everything is a function of its arguments and a seed; frames and cameras draw from streams of their own, so
//! they can be made in any order and in parallel.
//!
//! | file         | holds                                                                      |
//! |--------------|----------------------------------------------------------------------------|
//! | `scene.rs`   | [`Ring`]: cameras around a volume                                           |
//! | `shape.rs`   | [`draw_shape`]: a body drawn from a model's statistics                      |
//! | `centres.rs` | [`draw_centres`]: where in the flesh a person's joint centres lie       |
//! | `curves.rs`  | [`Curve`], normative joint angles over the gait cycle                       |
//! | `gait.rs`    | [`Gait`]: one person's way of walking                                       |
//! | `contact.rs` | soles, and how the floor holds them                                         |
//! | `walk.rs`    | [`Walk`]: the motion of a model that walks                                  |
//! | `cloud.rs`   | [`StereoPair`]: the points that stereo would see on the skin                |
//! | `noise.rs`   | [`SegmentationErrors`]: what a segmentation does to a true mask             |
//! | `film/`      | [`FilmRecipe`]: photographs of a person before clutter, by cameras side by side |
//! | `recording.rs` | [`Synthetic`]: all of it together; [`Recipe`], [`sample_walker`]: how it is made |

mod centres;
mod cloud;
mod contact;
mod curves;
mod film;
mod gait;
mod noise;
mod recording;
mod scene;
mod shape;
mod walk;

pub use centres::{draw_centres, move_centres};
pub use cloud::StereoPair;
pub use curves::Curve;
pub use film::{FilmError, FilmRecipe, Filmed, Shot, Studio};
pub use gait::Gait;
pub use noise::SegmentationErrors;
pub use recording::{Recipe, Synthetic, sample_walker};
pub use scene::Ring;
pub use shape::draw_shape;
pub use walk::{Walk, WalkError};
