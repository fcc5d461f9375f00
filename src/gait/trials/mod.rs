//! Several trials of one person: all strides together, how far numbers vary, and what changed from one session to another.
//!
//! | file         | holds                                                             |
//! |--------------|-------------------------------------------------------------------|
//! | `pooled.rs`  | [`pooled`]: all strides, as if of one trial                        |
//! | `measure.rs` | [`Measure`]: one number of a walk; [`measured`]: all of a trial's   |
//! | `spread.rs`  | [`Spread`]: its mean, and three standard deviations                |
//! | `change.rs`  | [`Change`]: from one session to another, with its interval         |
//! | `sides.rs`   | [`side_differences`]: from the left side to the right one of a session |
//! | `curve_test.rs` | [`CurveTest`]: where over the cycle two sessions differ         |

mod change;
mod curve_test;
mod measure;
mod pooled;
mod sides;
mod spread;

pub use change::{Change, changes};
pub use curve_test::{CurveChange, CurveTest, LEAST_TRIALS, Stretch, curve_changes};
pub use measure::{Measure, Measured, Quantity, measured};
pub use pooled::{NamedTrial, pooled};
pub use sides::{Sides, side_differences};
pub use spread::{Spread, spreads};
