//! What a fit is worth.

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use super::cameras::CameraFaults;
use super::cause::{Cause, Reason, camera_causes, found_causes};
use super::proportions::wrong_scale;
use super::room::still_shares;
use super::seen::{STILL_PART, Seen, WHOLE, cut_off, still_parts};
use super::shown_by_two;
use super::stature::{stature_m, wrong_stature_m};
use super::upright::head_axis;
use super::volume::{Volume, apart_l, size_m, still_share, volumes};
use crate::body::{Posed, Root, Shape};
use crate::inference::Evidence;
use crate::inference::covariance::ShapeUncertainty;
use crate::math::stats::{mean, median};
use crate::pipeline::scene::body_size;
use crate::pipeline::{CameraFound, CameraQuality, FittedFrame};
use crate::silhouette::FrameObservations;

/// What a fit is worth: whether its numbers can be used, and what is wrong with the recording.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Verdict {
    /// Why its numbers cannot be used; empty: they can. Standard deviations are withheld then, for they speak of an optimum
    /// that is not the person.
    pub unusable: Vec<Reason>,
    /// What is wrong with the recording, the most certain first. A fit can be usable nonetheless.
    pub causes: Vec<Cause>,
}

impl Verdict {
    /// Whether the numbers can be used.
    pub fn is_usable(&self) -> bool {
        self.unusable.is_empty()
    }

    /// Where cameras jump.
    pub fn jumps(&self) -> impl Iterator<Item = &Cause> {
        let is_jump =
            |cause: &&Cause| matches!(cause, Cause::TouchedWhile { .. } | Cause::LostFrames { .. });
        self.causes.iter().filter(is_jump)
    }

    /// What moves with the person, where the masks hold such.
    pub fn worn(&self) -> Option<&Cause> {
        self.causes.iter().find(|cause| matches!(cause, Cause::Worn { .. }))
    }
}

/// Of a body that is too large for a person, smaller ones count too: it covers a part of what stands still.
const SMALL_STILL_PART: f64 = 0.1;
/// Above this overlap there is no reason to look for what the masks hold besides.
pub(super) const GOOD_OVERLAP: f64 = 0.85;
pub(super) const BODY_L: f64 = 15.0;
/// Of a fit that cannot be used, and for which nothing else was found, a limb's volume counts too, litres: an arm.
const LIMB_L: f64 = 3.5;
/// So many silhouettes, and fewer, hold much that is not there: 14 litres beside one person in a real room.
const FEW_CAMERAS: usize = 4;
/// A pelvis is accelerated by less, RMS, in g: 0.2 walking, 1 running and jumping (see the prior of motions, `inference/chain.rs`).
const MOST_G: f64 = 2.0;
/// Frames of which a person along another axis of the world may make the most.
const UPRIGHT_FRAMES: usize = 5;
/// The share of a level trunk's length by which its upper end is above its lower one: it is turned by more than 60°.
const LEVEL: f64 = 0.5;
/// Ragged masks miss each other by 3 mm.
const MASKS_AGREE_M: f64 = 0.005;

/// What a diagnosis is made from.
#[derive(Debug)]
pub(in crate::pipeline) struct Diagnosis<'a> {
    /// The body before the cameras as they are calibrated.
    pub(in crate::pipeline) evidence: &'a Evidence<'a>,
    /// What is wrong with these cameras, whatever body they show.
    pub(in crate::pipeline) faults: &'a CameraFaults,
    /// What was left out of it.
    pub(in crate::pipeline) left_out: &'a [Cause],
    pub(in crate::pipeline) observations: &'a [FrameObservations],
    pub(in crate::pipeline) fps: f64,
    pub(in crate::pipeline) shape: &'a Shape,
    pub(in crate::pipeline) uncertainty: Option<&'a ShapeUncertainty>,
    /// How tall the person is, m, if that is known.
    pub(in crate::pipeline) height_m: Option<f64>,
    pub(in crate::pipeline) frames: &'a [FittedFrame],
    pub(in crate::pipeline) cameras: &'a [CameraQuality],
}

impl Diagnosis<'_> {
    /// The verdict on a fit.
    pub(in crate::pipeline) fn verdict(&self) -> Verdict {
        let mut unusable = self.unusable();
        let mut causes = self.causes(&unusable);
        unusable.extend(self.unusable_by(&causes, &unusable));
        if causes.is_empty() && !unusable.is_empty() {
            causes.push(Cause::Unknown);
        }
        let causes = [self.left_out, &causes].concat();
        Verdict { unusable, causes }
    }

    /// Median over the cameras that see the person.
    pub(super) fn overlap(&self) -> Option<f64> {
        let seen = self.cameras.iter().filter(|c| c.frames > 0);
        median(&mut seen.map(|c| c.mean_iou).collect())
    }

    /// The first hypothesis that holds, from the cameras to the body.
    fn causes(&self, unusable: &[Reason]) -> Vec<Cause> {
        let is_unusable = !unusable.is_empty();
        let rig = self.evidence.rig;
        let Some(overlap) = self.overlap() else {
            return self.of_detections(unusable);
        };
        let found = self.faults;
        let of_cameras = || self.of_cameras(unusable);

        // what the masks hold; where they are good there is nothing to look for
        if !is_unusable && overlap > GOOD_OVERLAP {
            let of_cameras = of_cameras();
            let of_body = || self.of_another_size().into_iter().collect();
            return if of_cameras.is_empty() { of_body() } else { of_cameras };
        }
        let seen = self.seen();
        if let Some(cause) = seen.cropped().or_else(|| seen.pieces_of_room()) {
            return vec![cause];
        }
        if found.explain_nearly_all() {
            return of_cameras();
        }
        if unusable.iter().any(|reason| matches!(reason, Reason::ThinParts { .. })) {
            return vec![Cause::ThinPartsGone];
        }

        // the room that the silhouettes leave, without the cameras that are elsewhere: what lacks is tested before what is too much
        let volumes = volumes(rig, self.observations, &found.readings);
        if let Some(cause) = self.of_size(&volumes, unusable) {
            return vec![cause];
        }
        if let Some(stale) = seen.stale_picture() {
            return vec![stale];
        }
        let shares = still_shares(rig, self.observations, |frame| self.body(frame));
        let still_parts = |least: f64| still_parts(rig, &shares, least);
        if let Some(still) = still_parts(STILL_PART) {
            return vec![still];
        }
        let litres = apart_l(&volumes, |frame| self.body(frame));
        let is_tight = rig.cameras.len() > FEW_CAMERAS;
        if litres > BODY_L && (is_tight || is_unusable && rig.cameras.len() == FEW_CAMERAS) {
            // one that never moves is a picture, wherever the body went
            let share = still_share(rig, self.observations, &found.readings, &volumes);
            let cameras = rig.cameras.iter().map(|camera| camera.name.clone()).collect();
            let still = (share > STILL_PART).then_some(Cause::StillParts { cameras, share });
            return vec![still.unwrap_or(Cause::SecondBody { litres })];
        }
        if let Some(cut_off) = self.never_stands().filter(|_| !is_unusable) {
            return vec![cut_off];
        }

        // cameras that explain a part of it
        let of_cameras = of_cameras();
        if !of_cameras.is_empty() {
            return of_cameras;
        }
        if is_unusable && found.left_m > MASKS_AGREE_M {
            return vec![Cause::MasksDisagree { miss_m: found.left_m }];
        }
        if is_unusable && is_tight && litres > LIMB_L {
            return vec![Cause::SecondBody { litres }];
        }

        // the outlines agree; a body that is too large for a person may also have grown to cover what is not one
        let cause = self.of_another_size();
        let has_grown = matches!(cause, Some(Cause::Scale { factor }) if factor > 1.0);
        let still = if has_grown { still_parts(SMALL_STILL_PART) } else { None };
        still.or(cause).into_iter().collect()
    }

    /// What is wrong where there are detections and no masks: with the cameras, or with time and space.
    fn of_detections(&self, unusable: &[Reason]) -> Vec<Cause> {
        if self.cameras.iter().all(|camera| camera.detections.is_none()) {
            return Vec::new();
        }
        let of_cameras = self.of_cameras(unusable);
        let of_size = || self.too_fast().or_else(|| self.too_large()).into_iter().collect();
        if of_cameras.is_empty() { of_size() } else { of_cameras }
    }

    /// What the silhouettes hold lies down, or is lower than a person: than the fitted one, unless that cannot be used.
    fn of_size(&self, volumes: &[Volume], unusable: &[Reason]) -> Option<Cause> {
        let (size_m, model) = (size_m(volumes)?, self.evidence.model);
        let usual_m = match unusable.is_empty() {
            true => stature_m(model, self.shape),
            false => body_size(model),
        };
        self.turned(size_m.imax()).or_else(|| cut_off(usual_m, size_m.z))
    }

    /// The recording without the body.
    fn seen(&self) -> Seen<'_> {
        let Self { evidence, faults, observations, .. } = *self;
        Seen { model: evidence.model, rig: evidence.rig, faults, observations }
    }

    /// What is wrong with the cameras: as the joint optimum found it, where that can.
    fn of_cameras(&self, unusable: &[Reason]) -> Vec<Cause> {
        if unusable.is_empty() && self.faults.are_of_unknowns() && self.has_estimates() {
            return found_causes(self.cameras, self.fps);
        }
        camera_causes(self.evidence.rig, self.faults)
    }

    /// Whether the joint optimum says where or when the cameras are.
    fn has_estimates(&self) -> bool {
        self.cameras.iter().any(|camera| camera.found != CameraFound::default())
    }

    /// Time or space is of another size, or the body never stands.
    fn of_another_size(&self) -> Option<Cause> {
        self.too_fast().or_else(|| self.never_stands()).or_else(|| self.too_large())
    }

    /// A body that is folded in most frames: where the silhouettes lack the legs it is left nothing else.
    fn never_stands(&self) -> Option<Cause> {
        if !self.is_person() || self.lies() {
            return None;
        }
        let height_m = self.shown_height_m()?;
        let is_low = height_m < WHOLE * stature_m(self.evidence.model, self.shape);
        is_low.then_some(Cause::CutOff { height_m })
    }

    /// Whether the trunk is level in most frames, as of who lies or goes on all fours: without legs it would be upright.
    pub(super) fn lies(&self) -> bool {
        let up = |frame: &FittedFrame| (frame.fit.motion.world_from_root * Vector3::z()).z;
        median(&mut self.frames.iter().map(up).collect()).is_some_and(|up| up < LEVEL)
    }

    /// The body's height as it is posed: median over the frames.
    fn shown_height_m(&self) -> Option<f64> {
        let height = |frame: usize| {
            let (low, high) = self.body(frame).bounds()?;
            Some((high - low).z)
        };
        median(&mut (0..self.frames.len()).filter_map(height).collect())
    }

    /// Whether the body is no limb that is held.
    pub(super) fn is_person(&self) -> bool {
        self.evidence.model.root != Root::Fixed
    }

    fn body(&self, frame: usize) -> Posed<'_> {
        Posed::new(self.evidence.model, self.shape, &self.frames[frame].fit.motion)
    }

    /// A motion that no person makes.
    fn too_fast(&self) -> Option<Cause> {
        let acceleration = |three: &[FittedFrame]| {
            let numbers = three[0].frame.0 + 2 == three[2].frame.0;
            let is_seen = numbers && three.iter().all(FittedFrame::is_observed);
            let [a, b, c] = [0, 1, 2].map(|i| three[i].fit.motion.position_world);
            is_seen.then(|| (a - 2.0 * b + c).norm_squared() * self.fps.powi(4))
        };
        let squares = self.frames.windows(3).filter_map(acceleration);
        let acceleration_g = mean(squares)?.sqrt() / 9.81;
        (acceleration_g > MOST_G).then_some(Cause::FrameRate { acceleration_g })
    }

    /// A world that is too large or too small: by the person's height if that is known, or else by the bones alone.
    fn too_large(&self) -> Option<Cause> {
        let model = self.evidence.model;
        match self.height_m {
            Some(given_m) => wrong_stature_m(model, self.shape, self.uncertainty, given_m)
                .map(|found_m| Cause::Height { found_m, given_m }),
            None => wrong_scale(model, self.shape).map(|factor| Cause::Scale { factor }),
        }
    }

    /// A person who stands along the axis of the world along which what is seen is longest.
    fn turned(&self, longest: usize) -> Option<Cause> {
        if !self.is_person() {
            return None;
        }
        let frames = shown_by_two(self.observations, UPRIGHT_FRAMES).into_iter();
        let frames: Vec<_> = frames.map(|frame| &self.observations[frame]).collect();
        Some(Cause::Turned { head: head_axis(self.evidence, &frames, longest)? })
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_2;

    use nalgebra::Rotation3;

    use super::*;
    use crate::body::Motion;
    use crate::inference::frame::FrameFit;
    use crate::pipeline::diagnosis::figures::Figures;
    use crate::pipeline::{DetectedQuality, PoseFound};
    use crate::silhouette::FrameIndex;

    fn fitted(motion: Motion) -> FittedFrame {
        FittedFrame {
            frame: FrameIndex(0),
            fit: FrameFit {
                motion,
                data: 0.0,
                pose: 0.0,
                step: 0.0,
                observations: 1.0,
                recovered: false,
            },
            uncertainty: None,
            points_world: Vec::new(),
            views: Vec::new(),
            points: None,
            detections: Vec::new(),
        }
    }

    #[test]
    fn a_camera_that_the_optimum_found_touched_is_named_of_detections_alone_and_the_others_are_not()
    {
        let figures = Figures::new();
        let camera = |name: &str, turn_deg: f64, pictures: usize| CameraQuality {
            camera: name.into(),
            frames: 0,
            mean_iou: 0.0,
            median_px: None,
            rms_px: None,
            detections: (pictures > 0).then_some(DetectedQuality {
                pictures,
                median_px: 3.0,
                median_of_size: 0.03,
            }),
            found: CameraFound {
                pose: Some(PoseFound {
                    turn_deg: [turn_deg, 0.0, 0.0],
                    turn_sd_deg: Some([0.2; 3]),
                    displacement_m: [0.0; 3],
                    displacement_sd_m: Some([0.01; 3]),
                    zoom: 1.0,
                    zoom_sd: Some(0.001),
                    used: true,
                }),
                clock: None,
            },
        };
        let causes = |pictures: usize| {
            let cameras = [camera("well", 0.1, pictures), camera("rolled", 4.1, pictures)];
            figures.diagnosed(&[], &cameras, |diagnosis| diagnosis.causes(&[]))
        };
        let found = causes(10);
        assert!(
            matches!(&found[..], [Cause::Touched { camera, .. }] if camera == "rolled"),
            "{found:?}"
        );
        // points alone were measured with the calibration
        assert_eq!(causes(0), []);
    }

    #[test]
    fn a_body_that_never_stands_is_part_of_a_person_and_one_that_stands_or_lies_is_whole() {
        let figures = Figures::new();
        let cause =
            |motion: Motion| figures.diagnosed(&[fitted(motion)], &[], |d| d.of_another_size());

        let standing = figures.standing(0.0, 0.0);
        let mut folded = standing.clone();
        for (name, angle) in [("hip_flexion", 2.0), ("knee_flexion", 2.3)] {
            for side in ["_r", "_l"] {
                let joint = figures.model.joint(&format!("{name}{side}")).unwrap();
                folded.angles[joint.0] = angle;
            }
        }
        let mut lying = standing.clone();
        lying.world_from_root *= Rotation3::from_axis_angle(&Vector3::y_axis(), -FRAC_PI_2);
        assert_eq!(cause(standing), None);
        assert_eq!(cause(lying), None);
        let found = cause(folded);
        assert!(matches!(found, Some(Cause::CutOff { height_m }) if height_m < 1.3), "{found:?}");
    }
}
