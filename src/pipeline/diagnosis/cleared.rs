//! What of a recording's masks can be used.

use std::borrow::Cow;

use super::cause::Cause;
use super::parts::Parted;
use super::repeated::WithoutRepeats;
use super::rods::WithoutRods;
use super::shadows::WithoutShadows;
use super::things::WithoutThings;
use crate::camera::Rig;
use crate::silhouette::FrameObservations;

/// A recording without pictures that come twice, without rods, shadows and still things in its masks, and without views that lack a part of the
/// person or hold something else.
#[derive(Debug, Clone)]
pub(in crate::pipeline) struct Cleared<'a> {
    pub(in crate::pipeline) frames: Cow<'a, [FrameObservations]>,
    /// What was left out.
    pub(in crate::pipeline) causes: Vec<Cause>,
}

impl<'a> Cleared<'a> {
    pub(in crate::pipeline) fn new(rig: &Rig, frames: &'a [FrameObservations]) -> Self {
        let WithoutRepeats { frames, causes: repeats } = WithoutRepeats::new(rig, frames);
        let WithoutRods { frames, cause: rods } = WithoutRods::new(rig, frames);
        let WithoutShadows { frames, cause: shadows } = WithoutShadows::new(rig, frames);
        let WithoutThings { frames, cause: things } = WithoutThings::new(rig, frames);
        let Parted { frames, causes: parts } = Parted::new(rig, frames);
        let of_masks = rods.into_iter().chain(shadows).chain(things);
        Self { frames, causes: repeats.into_iter().chain(of_masks).chain(parts).collect() }
    }
}
