//! A body that lies where the masks show nobody.
//!
//! A bag, a skirt or a long coat moves with the person, so all cameras agree on it and borders that lie off lose their weight: the fitted
//! limbs are drawn into it, and nothing tells. But a limb that is drawn from its place leaves the masks elsewhere. The body
//! is astray where it lies farther outside a mask than half a forearm's width
//! ([`ViewQuality::astray`](crate::pipeline::ViewQuality::astray)). Loose clothes do the contrary, and things that a person
//! carries without harm to the fit leave it within the masks (see docs/decisions, 0035).

use super::unusable::lost_frames;
use crate::math::stats::mean;
use crate::pipeline::FittedFrame;

/// The share of a body that may be astray: in each view a tenth of a hand.
pub(in crate::pipeline) const MOST_ASTRAY: f64 = 0.001;

/// The share of the body that is astray, mean over all views but those of lost frames; `None` without views.
pub(in crate::pipeline) fn astray_share(frames: &[FittedFrame]) -> Option<f64> {
    let lost = lost_frames(frames);
    let found = frames.iter().enumerate().filter(|(i, _)| !lost.contains(i));
    mean(found.flat_map(|(_, frame)| &frame.views).map(|view| view.astray))
}
