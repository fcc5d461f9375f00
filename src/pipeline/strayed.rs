//! Cameras that strayed: the joint optimum puts them farther from their calibrated places than anybody moves a camera.
//!
//! A camera that was touched is free to go where its pictures fit. One whose masks hold a wardrobe fits nowhere, and goes wherever the
//! wardrobe looks most like the person. Its pose says nothing then, and what it shows pulls at the body. So it is left out, and the
//! optimum is sought again, as long as three cameras remain.

use super::diagnosis::{AGREEING, CameraFaults, Cause, MOST_DISPLACED_M};
use super::estimate::Estimate;
use crate::camera::{CameraId, Rig};
use crate::silhouette::FrameObservations;

/// A recording without the cameras that strayed.
#[derive(Debug, Clone)]
pub(super) struct Strayed {
    pub(super) frames: Vec<FrameObservations>,
    /// What is wrong with the others.
    pub(super) faults: CameraFaults,
    /// Which cameras were left out.
    pub(super) cause: Cause,
}

impl Strayed {
    /// `None` where no camera strayed, or too few others show anything.
    pub(super) fn of(estimate: &Estimate, rig: &Rig, frames: &[FrameObservations]) -> Option<Self> {
        let has_strayed = |id: CameraId| {
            let pose = estimate.cameras[id.0].pose.filter(|pose| pose.used);
            pose.is_some_and(|pose| pose.displacement().0 > MOST_DISPLACED_M)
        };
        without(rig, frames, has_strayed)
    }
}

/// The recording without some of its cameras.
fn without(
    rig: &Rig,
    frames: &[FrameObservations],
    is_left_out: impl Fn(CameraId) -> bool,
) -> Option<Strayed> {
    let shows = |id: CameraId| frames.iter().any(|frame| frame.is_shown_by(id));
    let shown = rig.iter().filter(|(id, _)| shows(*id));
    let (left_out, kept): (Vec<_>, Vec<_>) = shown.partition(|(id, _)| is_left_out(*id));
    if left_out.is_empty() || kept.len() < AGREEING {
        return None;
    }

    let of_kept = |frame: &FrameObservations| {
        left_out.iter().fold(frame.clone(), |frame, (id, _)| frame.without(*id))
    };
    let frames: Vec<FrameObservations> = frames.iter().map(of_kept).collect();
    let cameras = left_out.into_iter().map(|(_, camera)| camera.name.clone()).collect();
    Some(Strayed {
        faults: CameraFaults::of(rig, &frames),
        frames,
        cause: Cause::Strayed { cameras },
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pipeline::diagnosis::figures::Figures;

    #[test]
    fn a_camera_is_left_out_and_named_while_three_others_show_the_person() {
        let figures = Figures::new();
        let masks = figures.masks(&figures.standing(0.0, 0.0));
        let frames = [figures.frame(0, &masks), figures.frame(1, &masks)];
        let cameras = figures.rig.cameras.len();
        let left = |first: usize| without(&figures.rig, &frames, |id| id.0 < first);

        assert!(left(0).is_none());
        let one = left(1).expect("one of many");
        let name = figures.rig.cameras[0].name.clone();
        assert_eq!(one.cause, Cause::Strayed { cameras: vec![name] });
        assert!(one.frames.iter().all(|frame| frame.views.len() == cameras - 1));
        assert!(left(cameras - AGREEING).is_some());
        assert!(left(cameras - AGREEING + 1).is_none(), "two cameras would be left");
    }
}
