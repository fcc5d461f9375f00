//! An arm of two bars (ZS06, Fig. 2), and the posterior of its one shape coefficient.

mod bars;
mod posterior;

pub use bars::{BarArm, observe, rig};
pub use posterior::{Posterior, coefficient_of, share_of};
