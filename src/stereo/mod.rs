//! Points on the surface of the body, as stereo sees them: places in the world and how far they err.
//!
//! A [`Cloud`] is what one frame has of them, from any source. It knows neither cameras nor body.

mod cloud;
pub mod correlation;

pub use cloud::{Cloud, CloudPoint, LeftOut, Spread};
