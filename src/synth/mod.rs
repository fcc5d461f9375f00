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
//! | `make.rs`    | [`Make`]: what a person is made of                                        |
//! | `bound_skin.rs`, `shares.rs`, `worn.rs` | a skin that bones move, by which shares, and what is worn where on it |
//! | `curves.rs`  | [`Curve`], normative joint angles over the gait cycle                       |
//! | `walking_style.rs` | [`WalkingStyle`]: the angles over one person's gait cycle |
//! | `contact.rs` | soles, and how the floor holds them                                         |
//! | `walk.rs`    | [`Walk`]: the motion of a model that walks                                  |
//! | `movement.rs` | [`Movement`]: other motions, between key poses             |
//! | `cloud.rs`   | [`StereoPair`]: the points that stereo would see on the skin                |
//! | `noise.rs`   | [`SegmentationErrors`]: what a segmentation does to a true mask             |
//! | `film/`      | [`FilmRecipe`]: photographs of a person before clutter, by cameras side by side |
//! | `recording.rs` | [`Synthetic`]: all of it together; [`Recipe`], [`sample_walker`]: how it is made |

mod bound_skin;
mod centres;
mod cloud;
mod contact;
mod curves;
mod film;
mod make;
mod movement;
mod movement_keys;
mod noise;
mod recording;
mod scene;
mod shape;
mod shares;
mod walk;
mod walking_style;
mod worn;

pub use bound_skin::BoundSkin;
pub use centres::{draw_centres, move_centres};
pub use cloud::StereoPair;
pub use curves::Curve;
pub use film::{Company, Film, FilmError, FilmRecipe, Shot, Staging, Studio};
pub use make::Make;
pub use movement::Movement;
pub use noise::SegmentationErrors;
pub use recording::{Action, Recipe, Synthetic, sample_walker};
pub use scene::Ring;
pub use shape::draw_shape;
pub use walk::{Ground, Walk, WalkError};
pub use walking_style::WalkingStyle;
