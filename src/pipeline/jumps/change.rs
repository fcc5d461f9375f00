//! What changes at a jump: whether a camera has lost frames, or was touched.
//!
//! Just before the jump the camera shows the body of n₀ frames later, turned by R₀: both are usually nothing. Just behind it, either n is another, or R.
//! Both are tried on some frames, and what leaves them the smaller cost is what changed. Where frames come twice, n falls.

use nalgebra::UnitQuaternion;

use super::beside::{Beside, Moments};
use crate::body::Motion;
use crate::camera::CameraId;
use crate::inference::Look;
use crate::inference::camera_offset::CameraOffset;
use crate::math::stats::{mean, median};
use crate::pipeline::joint_stage::turn_towards;
use crate::silhouette::FrameIndex;

/// So many frames on either side are looked at.
const LOOKED_AT: usize = 12;
/// A turn is found in so many steps.
const STEPS: usize = 5;

/// What changes at a jump.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Change {
    /// So many frames are lost, if that explains more than a turn does; negative: they come twice.
    pub(super) lost: Option<isize>,
    /// The angle by which the camera would be turned, radians.
    pub(super) turn_rad: f64,
}

impl Change {
    /// Of what a camera shows beside the body of the others, with the whole frames by which it is ahead; `None` if it shows nothing.
    pub(super) fn of(
        moments: &Moments<'_>,
        camera: CameraId,
        shown: &[Beside],
        jump: FrameIndex,
    ) -> Option<Self> {
        let first = shown.partition_point(|shown| shown.frame < jump);
        let (before, behind) = shown.split_at(first);
        let before = Near::new(moments, camera, &before[before.len().saturating_sub(LOOKED_AT)..])?;
        let behind = Near::new(moments, camera, &behind[..behind.len().min(LOOKED_AT)])?;

        let still = before.turn(before.ahead, UnitQuaternion::identity())?;
        let turn = behind.turn(before.ahead, still)?;
        let turned = behind.cost(before.ahead, turn)?;
        let lost = behind.cost(behind.ahead, still)?;
        let frames = behind.ahead - before.ahead;
        let is_time = frames != 0 && lost < turned;
        Some(Self { lost: is_time.then_some(frames), turn_rad: still.angle_to(&turn) })
    }
}

/// Some frames on one side of a jump.
struct Near<'m> {
    moments: &'m Moments<'m>,
    camera: CameraId,
    /// The position of each, and what the camera shows there.
    looks: Vec<(usize, Vec<Look<'m>>)>,
    /// n: median of the frames by which it is ahead.
    ahead: isize,
}

impl<'m> Near<'m> {
    fn new(moments: &'m Moments<'m>, camera: CameraId, shown: &[Beside]) -> Option<Self> {
        let ahead = median(&mut shown.iter().map(|shown| shown.ahead_frames).collect())?;
        let looks = shown.iter().filter_map(|shown| moments.looks(camera, shown.frame)).collect();
        Some(Self { moments, camera, looks, ahead: ahead.round() as isize })
    }

    /// The body of n frames later before the camera turned by R.
    fn seen(&self, position: usize, ahead: isize, turn: UnitQuaternion<f64>) -> Option<Motion> {
        let centre = self.moments.evidence.rig.cameras[self.camera.0].centre_world().coords;
        let instant = self.moments.later(self.camera, position, ahead)?;
        let offset = CameraOffset { turn, ..CameraOffset::none() };
        Some(offset.seen(&centre, &instant.motion))
    }

    /// Mean cost with n and R.
    fn cost(&self, ahead: isize, turn: UnitQuaternion<f64>) -> Option<f64> {
        let cost = |(position, looks): &(usize, Vec<Look<'_>>)| {
            Some(self.moments.cost(looks, &self.seen(*position, ahead, turn)?))
        };
        mean(self.looks.iter().filter_map(cost))
    }

    /// R with n.
    fn turn(&self, ahead: isize, first: UnitQuaternion<f64>) -> Option<UnitQuaternion<f64>> {
        let camera = &self.moments.evidence.rig.cameras[self.camera.0];
        let mut turn = first;
        for _ in 0..STEPS {
            let mut shown = Vec::new();
            for (position, looks) in &self.looks {
                let Some(motion) = self.seen(*position, ahead, turn) else { continue };
                let pixel = self.moments.shown_px(self.camera, looks, &motion)?;
                shown.push((pixel, motion.position_world.into()));
            }
            turn *= turn_towards(camera, shown.into_iter());
        }
        Some(turn)
    }
}
