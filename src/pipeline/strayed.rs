//! Cameras that strayed: no place near their calibrated ones explains what they show.
//!
//! A camera that was touched is free to go where its pictures fit. One whose masks hold a wardrobe fits nowhere, and goes wherever the
//! wardrobe looks most like the person: farther than anybody moves a camera, or to where the body still covers its masks much worse than
//! those of the others. Its pose says nothing then, and what it shows pulls at the body. So it is left out, and the optimum is sought
//! again, as long as three cameras remain.
//!
//! A small or ragged mask is covered badly, too, but by borders that lie off by few pixels. So both must be out of line.

use super::CameraQuality;
use super::diagnosis::{AGREEING, CameraFaults, Cause, LOST_SHARE, MOST_DISPLACED_M};
use super::estimate::{Estimate, LastStage};
use super::fitted::FittedFrame;
use crate::camera::{CameraId, Rig};
use crate::inference::Sequence;
use crate::math::stats::median;
use crate::silhouette::FrameObservations;

/// Borders lie off if they lie so many times as far off as those of the other cameras.
const FAR: f64 = 2.0;

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
    /// `None` where no camera strayed, or too few others show anything. `frames` are those of the estimate.
    pub(super) fn of(
        stage: &LastStage<'_>,
        estimate: &Estimate,
        frames: &[FittedFrame],
    ) -> Option<Self> {
        let cameras = &estimate.qualities(frames);
        let is_displaced = |camera: &CameraQuality| {
            let pose = camera.found.pose.filter(|pose| pose.used);
            pose.is_some_and(|pose| pose.displacement().0 > MOST_DISPLACED_M)
        };
        let is_uncovered = is_uncovered(cameras);
        let has_strayed = |CameraId(i): CameraId| {
            let camera = &cameras[i];
            is_displaced(camera) || stage.faults.are_of_unknowns() && is_uncovered(camera)
        };
        without(stage.evidence.rig, stage.sequence.frames, has_strayed)
    }

    /// A stage without them.
    pub(super) fn stage<'a>(&'a self, stage: &LastStage<'a>) -> LastStage<'a> {
        let sequence = Sequence { frames: &self.frames, ..stage.sequence };
        LastStage { sequence, faults: &self.faults, ..*stage }
    }
}

/// Whether the body covers a camera's masks much worse than those of the others.
fn is_uncovered(cameras: &[CameraQuality]) -> impl Fn(&CameraQuality) -> bool {
    let usual = |value: fn(&CameraQuality) -> Option<f64>| {
        median(&mut cameras.iter().filter(|camera| camera.frames > 0).filter_map(value).collect())
    };
    let overlap = usual(|camera| Some(camera.mean_iou)).unwrap_or_default();
    let off_px = usual(|camera| camera.rms_px).unwrap_or(f64::INFINITY);
    move |camera| {
        let is_far = camera.rms_px.is_some_and(|rms_px| rms_px > FAR * off_px);
        is_far && camera.mean_iou < LOST_SHARE * overlap
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
    use crate::pipeline::CameraFound;
    use crate::pipeline::diagnosis::figures::Figures;

    /// A camera that the body overlaps by so much, with borders that lie off by so many pixels.
    fn covered((mean_iou, rms_px): (f64, f64)) -> CameraQuality {
        CameraQuality {
            camera: "cam".into(),
            frames: 1,
            mean_iou,
            median_px: Some(rms_px),
            rms_px: Some(rms_px),
            detections: None,
            found: CameraFound::default(),
        }
    }

    #[test]
    fn a_camera_is_uncovered_if_both_its_overlap_and_its_borders_are_out_of_line() {
        let is = |camera: (f64, f64)| {
            let others = [(0.9, 2.0), (0.92, 3.0), (0.88, 2.0)].map(covered);
            let cameras = [vec![covered(camera)], others.to_vec()].concat();
            is_uncovered(&cameras)(&cameras[0])
        };
        assert!(is((0.5, 20.0)), "its masks hold a chair");
        assert!(!is((0.6, 2.0)), "a small picture");
        assert!(!is((0.89, 20.0)), "a picture of many pixels");
    }

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
