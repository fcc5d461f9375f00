//! Why the numbers of a fit cannot be used: figures beyond their limits, and causes that misplace a body.

use nalgebra::Vector3;

use super::cause::{Cause, Reason};
use super::thin::{LEAST_THIN, thin_share};
use super::verdict::{Diagnosis, GOOD_OVERLAP};
use crate::inference::camera_prior::Free;
use crate::math::stats::median;
use crate::pipeline::FittedFrame;

/// An overlap below this is bad: bodies and masks of other people still overlap as much.
pub(in crate::pipeline) const LEAST_OVERLAP: f64 = 0.65;
/// Detections that lie farther from the body than this share of the person's size are not of it: three times what published labels scatter by.
const MOST_DETECTED: f64 = 0.25;
/// A shape this many times as improbable as usual is nobody's: upside-down cameras gave 43, people in clothes up to 8.
const MOST_BODY: f64 = 10.0;
/// More lost frames than this share, and nobody knows which are right.
const MOST_LOST: f64 = 0.33;
/// Cameras are kicked and bumped by less, metres.
pub(in crate::pipeline) const MOST_DISPLACED_M: f64 = 1.0;
/// A frame, or a camera, below this share of the median one's overlap is lost.
pub(in crate::pipeline) const LOST_SHARE: f64 = 0.8;
/// One whose detections lie farther off than so many times the median frame's, and too far by themselves, is lost too.
const LOST_OFF: f64 = 3.0;

impl Diagnosis<'_> {
    /// The figures beyond their limits.
    pub(super) fn unusable(&self) -> Vec<Reason> {
        let overlap = self.overlap();
        let overlap = overlap.filter(|iou| *iou < LEAST_OVERLAP);
        let overlap = overlap.map(|found| Reason::Overlap { found, least: LEAST_OVERLAP });

        let detected = self.cameras.iter().filter(|camera| camera.frames == 0);
        let detected = detected.filter_map(|camera| Some(camera.detections?.median_of_size));
        let detected = median(&mut detected.collect()).filter(|found| *found > MOST_DETECTED);
        let detected = detected.map(|found| Reason::Detections { found, most: MOST_DETECTED });

        let usual = 0.5 * self.shape.0.len() as f64;
        let found = self.evidence.shape_prior.cost(self.shape) / usual.max(0.5);
        let body = (found > MOST_BODY).then_some(Reason::Body { found, most: MOST_BODY });

        let seen = self.frames.iter().filter(|f| f.cameras() > 0).count();
        let found = lost_frames(self.frames).len() as f64 / seen.max(1) as f64;
        let lost = (found > MOST_LOST).then_some(Reason::LostFrames { found, most: MOST_LOST });

        // the floor hides the arms of who lies
        let shows_limbs = self.is_person() && !self.lies();
        let thin = if shows_limbs { thin_share(self.observations) } else { None };
        let thin = thin.filter(|found| *found < LEAST_THIN);
        let thin = thin.map(|found| Reason::ThinParts { found, least: LEAST_THIN });

        [overlap, detected, thin, body, lost, self.too_far_displaced()]
            .into_iter()
            .flatten()
            .collect()
    }

    /// A camera that was found much farther from its calibrated place than a touch moves it.
    fn too_far_displaced(&self) -> Option<Reason> {
        let poses = self.cameras.iter().filter_map(|camera| camera.found.pose.as_ref());
        let used = poses.filter(|pose| pose.used);
        let displaced = used.map(|pose| Vector3::from(pose.displacement_m).norm());
        let found = displaced.reduce(f64::max).filter(|found| *found > MOST_DISPLACED_M)?;
        Some(Reason::Displacement { found, most: MOST_DISPLACED_M })
    }

    /// What makes the numbers unusable of what is wrong with the recording, besides other reasons.
    pub(super) fn unusable_by(&self, causes: &[Cause], others: &[Reason]) -> Option<Reason> {
        let wrong = causes.iter().map(|cause| cause.wrong_pictures(self.evidence.rig));
        let wrong: usize = wrong.sum();
        if wrong > 0 {
            return Some(Reason::WrongPictures { found: wrong as f64, most: 0.0 });
        }
        if let Some(uncrossed) = self.uncrossed(causes) {
            return Some(uncrossed);
        }

        // a body that is folded, upside down or drawn to furniture covers a part of a person fairly
        let misplaces = |cause: &Cause| {
            matches!(cause, Cause::CutOff { .. } | Cause::Turned { .. } | Cause::StillParts { .. })
        };
        if !others.is_empty() || !causes.iter().any(misplaces) {
            return None;
        }
        let found = self.overlap().filter(|found| *found < GOOD_OVERLAP)?;
        Some(Reason::Overlap { found, least: GOOD_OVERLAP })
    }

    /// Cameras that were touched and that no two others look across.
    fn uncrossed(&self, causes: &[Cause]) -> Option<Reason> {
        let is_touched = |name: &str| {
            causes.iter().any(|cause| match cause {
                Cause::Touched { camera, .. } => camera == name,
                Cause::FocalLength { camera, lens } => camera == name && lens.sd.is_some(),
                _ => false,
            })
        };
        let motions = self.frames.iter().map(|frame| &frame.fit.motion);
        let rig = self.evidence.rig;
        let crossed = Free::crossed(rig, motions, Free { pose: true, clock: true });
        let cameras = rig.cameras.iter().zip(crossed);
        let found = cameras.filter(|(camera, crossed)| !crossed.pose && is_touched(&camera.name));
        let found = found.count();
        (found > 0).then_some(Reason::Uncrossed { found: found as f64, most: 0.0 })
    }
}

/// Positions of the frames that the body covers much worse than the rest, or from whose detections it lies much farther off.
pub(in crate::pipeline) fn lost_frames(frames: &[FittedFrame]) -> Vec<usize> {
    let of = |value: &dyn Fn(&FittedFrame) -> Option<f64>| -> Vec<(usize, f64)> {
        frames.iter().enumerate().filter_map(|(i, f)| Some((i, value(f)?))).collect()
    };
    let usual = |values: &[(usize, f64)]| median(&mut values.iter().map(|(_, v)| *v).collect());

    let overlaps = of(&FittedFrame::mean_iou);
    let usual_overlap = usual(&overlaps).unwrap_or(0.0);
    let uncovered = overlaps.into_iter().filter(|(_, iou)| *iou < LOST_SHARE * usual_overlap);
    let off = of(&FittedFrame::detected_off);
    let usual_off = usual(&off).unwrap_or(0.0);
    let far =
        off.into_iter().filter(|(_, off)| *off > MOST_DETECTED && *off > LOST_OFF * usual_off);
    uncovered.chain(far).map(|(i, _)| i).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::Rig;
    use crate::inference::camera_offset::CameraOffset;
    use crate::pipeline::diagnosis::figures::Figures;
    use crate::pipeline::diagnosis::upright::HeadAxis;
    use crate::pipeline::{CameraFound, CameraQuality};

    /// A camera that the body overlaps by so much.
    fn quality(mean_iou: f64) -> CameraQuality {
        CameraQuality {
            camera: "cam".into(),
            frames: 1,
            mean_iou,
            median_px: None,
            rms_px: None,
            detections: None,
            found: CameraFound::default(),
        }
    }

    /// What makes a fit unusable of which nothing but a cause is known.
    fn unusable_by(cause: Cause, mean_iou: f64) -> Option<Reason> {
        Figures::new().diagnosed(&[], &[quality(mean_iou)], |diagnosis| {
            diagnosis.unusable_by(std::slice::from_ref(&cause), &[])
        })
    }

    #[test]
    fn a_folded_or_turned_body_must_overlap_more_than_one_that_stands_and_one_beside_furniture_too()
    {
        let still = Cause::StillParts { cameras: Vec::new(), share: 0.5 };
        let (cut_off, turned) =
            (Cause::CutOff { height_m: 1.0 }, Cause::Turned { head: HeadAxis::MinusZ });
        for cause in [cut_off, turned, still] {
            let found = unusable_by(cause.clone(), 0.5 * (LEAST_OVERLAP + GOOD_OVERLAP));
            assert!(matches!(found, Some(Reason::Overlap { .. })), "{found:?}");
            assert_eq!(unusable_by(cause, 0.5 * (1.0 + GOOD_OVERLAP)), None);
        }
    }

    #[test]
    fn a_camera_that_was_touched_makes_a_fit_unusable_if_none_looks_across_it() {
        let all = Figures::new();
        let pose = Free { pose: true, clock: false };
        let found = CameraFound::new(&CameraOffset::zoomed(0.1), pose, None).pose.unwrap();
        let camera = all.rig.cameras[0].name.clone();
        let cause = Cause::Touched { camera, pose: Box::new(found) };
        let reason = |cameras: &[usize]| {
            let cameras = cameras.iter().map(|i| all.rig.cameras[*i].clone()).collect();
            let figures = Figures { rig: Rig { cameras }, ..Figures::new() };
            figures
                .diagnosed(&[], &[], |diagnosis| diagnosis.uncrossed(std::slice::from_ref(&cause)))
        };
        let count = all.rig.cameras.len();
        assert_eq!(reason(&(0..count).collect::<Vec<_>>()), None);
        assert!(matches!(reason(&[0, 1]), Some(Reason::Uncrossed { .. })));
    }

    #[test]
    fn a_camera_that_would_stand_a_metre_elsewhere_makes_a_fit_unusable_and_a_kicked_one_does_not()
    {
        let figures = Figures::new();
        let reasons = |displacement_m: f64| {
            let offset = CameraOffset {
                displacement_m: Vector3::new(0.0, displacement_m, 0.0),
                ..CameraOffset::none()
            };
            let free = Free { pose: true, clock: true };
            let camera =
                CameraQuality { found: CameraFound::new(&offset, free, None), ..quality(0.9) };
            figures.diagnosed(&[], &[camera], |diagnosis| diagnosis.unusable())
        };
        assert_eq!(reasons(0.5), []);
        assert!(matches!(reasons(2.0)[..], [Reason::Displacement { .. }]));
    }
}
