//! What changes at a jump: whether a camera has lost frames, or was touched.
//!
//! Just before the jump the camera shows the body of n₀ frames later, turned by R₀: both are usually nothing. Just behind it, either n is another, or R.
//! Both are tried on some frames, and what leaves them the smaller cost is what changed. Frames that come twice are lost less than never.

use nalgebra::{UnitQuaternion, Vector3};

use super::beside::{Beside, Moments};
use crate::body::Motion;
use crate::camera::CameraId;
use crate::inference::camera_offset::CameraOffset;
use crate::inference::{Detail, Look};
use crate::math::stats::{mean, median};
use crate::silhouette::{FrameIndex, FrameObservations};

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
        frames: &[FrameObservations],
        camera: CameraId,
        shown: &[Beside],
        jump: FrameIndex,
    ) -> Option<Self> {
        let first = shown.partition_point(|shown| shown.frame < jump);
        let (before, behind) = shown.split_at(first);
        let near = |shown: &[Beside]| Near::new(moments, frames, camera, shown);
        let before = near(&before[before.len().saturating_sub(LOOKED_AT)..])?;
        let behind = near(&behind[..behind.len().min(LOOKED_AT)])?;

        let still = before.turn(moments, before.ahead, UnitQuaternion::identity())?;
        let turn = behind.turn(moments, before.ahead, still)?;
        let turned = behind.cost(moments, before.ahead, turn)?;
        let lost = behind.cost(moments, behind.ahead, still)?;
        let frames = behind.ahead - before.ahead;
        let is_time = frames != 0 && lost < turned;
        Some(Self { lost: is_time.then_some(frames), turn_rad: still.angle_to(&turn) })
    }
}

/// Some frames on one side of a jump.
struct Near<'f> {
    camera: CameraId,
    /// The position of each, and what the camera shows there.
    looks: Vec<(usize, Vec<Look<'f>>)>,
    /// n: median of the frames by which it is ahead.
    ahead: isize,
}

impl<'f> Near<'f> {
    fn new(
        moments: &Moments<'_>,
        frames: &'f [FrameObservations],
        camera: CameraId,
        shown: &[Beside],
    ) -> Option<Self> {
        let looks = |shown: &Beside| {
            let found = frames.binary_search_by_key(&shown.frame, |frame| frame.frame);
            let position = found.ok()?;
            let mut looks = moments.evidence.looks(&frames[position], Detail::Thinned);
            looks.retain(|look| look.camera == Some(camera.0));
            Some((position, looks))
        };
        let ahead = median(&mut shown.iter().map(|shown| shown.ahead_frames).collect())?;
        let looks = shown.iter().filter_map(looks).collect();
        Some(Self { camera, looks, ahead: ahead.round() as isize })
    }

    /// The body of n frames later before the camera turned by R.
    fn seen(
        &self,
        moments: &Moments<'_>,
        position: usize,
        ahead: isize,
        turn: UnitQuaternion<f64>,
    ) -> Option<Motion> {
        let centre = moments.evidence.rig.cameras[self.camera.0].centre_world().coords;
        let instant = moments.later(self.camera, position, ahead)?;
        let offset = CameraOffset { turn, ..CameraOffset::none() };
        Some(offset.seen(&centre, &instant.motion))
    }

    /// Mean cost with n and R.
    fn cost(&self, moments: &Moments<'_>, ahead: isize, turn: UnitQuaternion<f64>) -> Option<f64> {
        let cost = |(position, looks): &(usize, Vec<Look<'_>>)| {
            Some(moments.cost(looks, &self.seen(moments, *position, ahead, turn)?))
        };
        mean(self.looks.iter().filter_map(cost))
    }

    /// R with n: the shortest turn about the camera's centre that brings the body to where it is shown, on the mean.
    fn turn(
        &self,
        moments: &Moments<'_>,
        ahead: isize,
        first: UnitQuaternion<f64>,
    ) -> Option<UnitQuaternion<f64>> {
        let camera = &moments.evidence.rig.cameras[self.camera.0];
        let mut turn = first;
        for _ in 0..STEPS {
            let (mut from, mut to) = (Vector3::zeros(), Vector3::zeros());
            for (position, looks) in &self.looks {
                let Some(motion) = self.seen(moments, *position, ahead, turn) else { continue };
                let aside_m = moments.offset_m(self.camera, looks, &motion)?.push(0.0);
                let aside = camera.camera_from_world.rotation.inverse() * aside_m;
                let sight = motion.position_world - camera.centre_world().coords;
                from += sight + aside;
                to += sight;
            }
            turn *= UnitQuaternion::rotation_between(&from, &to).unwrap_or_default();
        }
        Some(turn)
    }
}
