//! What a fit is worth.

use serde::{Deserialize, Serialize};

use super::cameras::{CameraFault, camera_faults};
use super::coherence::Scene;
use super::proportions::wrong_scale;
use super::room::still_shares;
use super::stature::wrong_stature_m;
use super::upright::{HeadAxis, head_axis};
use super::volume::{apart_l, height_m, volumes};
use crate::body::{Posed, Root, Shape};
use crate::camera::{CameraId, Rig};
use crate::inference::Evidence;
use crate::inference::covariance::ShapeUncertainty;
use crate::math::stats::{mean, median};
use crate::pipeline::scene::body_size;
use crate::pipeline::{CameraQuality, FittedFrame};
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
}

/// A figure beyond its limit.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", tag = "figure")]
#[non_exhaustive]
pub enum Reason {
    /// Median over the cameras of the mean overlap.
    Overlap {
        /// It.
        found: f64,
        /// Its limit.
        least: f64,
    },
    /// −log p(s) over ½n: 1 is usual.
    Body {
        /// It.
        found: f64,
        /// Its limit.
        most: f64,
    },
    /// The share of the seen frames that the body covers much worse than the rest.
    LostFrames {
        /// It.
        found: f64,
        /// Its limit.
        most: f64,
    },
}

/// What is wrong with a recording.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", tag = "cause")]
#[non_exhaustive]
pub enum Cause {
    /// All pictures show left for right.
    AllMirrored,
    /// The pictures of a camera show left for right.
    Mirrored {
        /// Its name.
        camera: String,
    },
    /// The pictures of two cameras are exchanged.
    Exchanged {
        /// Their names.
        cameras: [String; 2],
    },
    /// A camera shows everything late; negative: early.
    Late {
        /// Its name.
        camera: String,
        /// By how many frames.
        frames: isize,
    },
    /// The focal lengths of all cameras are wrong.
    FocalLengths {
        /// The calibrated over the true ones.
        factor: f64,
    },
    /// The focal length of a camera is wrong.
    FocalLength {
        /// Its name.
        camera: String,
        /// The calibrated over the true one.
        factor: f64,
    },
    /// A camera shows the person elsewhere than the others.
    Displaced {
        /// Its name.
        camera: String,
        /// By how much its outlines miss the others', m.
        miss_m: f64,
    },
    /// Masks hold something that stands still.
    StillParts {
        /// The cameras.
        cameras: Vec<String>,
        /// The largest area, over that of the silhouette.
        share: f64,
    },
    /// The silhouettes hold more than one body.
    SecondBody {
        /// Litres beside the body.
        litres: f64,
    },
    /// The silhouettes miss each other, and no camera is the cause.
    MasksDisagree {
        /// By how much, m.
        miss_m: f64,
    },
    /// The silhouettes show less than a whole person.
    CutOff {
        /// How tall what they show is, m.
        height_m: f64,
    },
    /// The person stands along another axis.
    Turned {
        /// Along which.
        head: HeadAxis,
    },
    /// The world is too large or too small for the body.
    Scale {
        /// By which factor.
        factor: f64,
    },
    /// The body is not as tall as the person is known to be.
    Height {
        /// How tall it is, m.
        found_m: f64,
        /// How tall the person is, m.
        given_m: f64,
    },
    /// The frame rate is too high for a person's accelerations.
    FrameRate {
        /// Root mean square of the root's acceleration, in g.
        acceleration_g: f64,
    },
    /// Nothing of what was tested.
    Unknown,
}

/// An overlap below this is bad: bodies and masks of other people still overlap as much.
pub(in crate::pipeline) const LEAST_OVERLAP: f64 = 0.65;
/// A shape this many times as improbable as usual is nobody's: upside-down cameras gave 43, people in clothes up to 8.
const MOST_BODY: f64 = 10.0;
/// More lost frames than this share, and nobody knows which are right.
const MOST_LOST: f64 = 0.33;
/// A frame below this share of the median frame's overlap is lost.
const LOST_SHARE: f64 = 0.8;
/// Above this overlap there is no reason to look for what the masks hold besides.
const GOOD_OVERLAP: f64 = 0.85;
/// Still parts and volumes beside the body count from here on, over the silhouette's area and in litres (a child of five: 18).
const STILL_PART: f64 = 0.25;
pub(super) const BODY_L: f64 = 15.0;
/// Of a fit that cannot be used, and for which nothing else was found, a limb's volume counts too, litres: an arm.
const LIMB_L: f64 = 3.5;
/// So many silhouettes, and fewer, hold much that is not there: 14 litres beside one person in a real room.
const FEW_CAMERAS: usize = 4;
/// A pelvis is accelerated by less, RMS, in g: 0.2 walking, 1 running and jumping.
const MOST_G: f64 = 2.0;
/// Ragged masks miss each other by 3 mm.
const MASKS_AGREE_M: f64 = 0.005;
/// Silhouettes below this share of the body's height show less than all of it: three standard deviations of stature.
const WHOLE: f64 = 0.8;

/// What a diagnosis is made from.
#[derive(Debug)]
pub(in crate::pipeline) struct Diagnosis<'a> {
    /// The body before the cameras as they are calibrated.
    pub(in crate::pipeline) evidence: &'a Evidence<'a>,
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
        let unusable = self.unusable();
        let mut causes = self.causes(&unusable);
        if causes.is_empty() && !unusable.is_empty() {
            causes.push(Cause::Unknown);
        }
        Verdict { unusable, causes }
    }

    fn unusable(&self) -> Vec<Reason> {
        let overlap = self.overlap();
        let overlap = overlap.filter(|iou| *iou < LEAST_OVERLAP);
        let overlap = overlap.map(|found| Reason::Overlap { found, least: LEAST_OVERLAP });

        let usual = 0.5 * self.shape.0.len() as f64;
        let found = self.evidence.shape_prior.cost(self.shape) / usual.max(0.5);
        let body = (found > MOST_BODY).then_some(Reason::Body { found, most: MOST_BODY });

        let seen = self.frames.iter().filter(|f| !f.views.is_empty()).count();
        let found = lost_frames(self.frames).len() as f64 / seen.max(1) as f64;
        let lost = (found > MOST_LOST).then_some(Reason::LostFrames { found, most: MOST_LOST });

        [overlap, body, lost].into_iter().flatten().collect()
    }

    /// Median over the cameras that see the person.
    fn overlap(&self) -> Option<f64> {
        let seen = self.cameras.iter().filter(|c| c.frames > 0);
        median(&mut seen.map(|c| c.mean_iou).collect())
    }

    /// The first hypothesis that holds, from the cameras to the body.
    fn causes(&self, unusable: &[Reason]) -> Vec<Cause> {
        let is_unusable = !unusable.is_empty();
        let Evidence { model, rig, .. } = self.evidence;
        let Some(overlap) = self.overlap() else {
            return Vec::new();
        };
        let scene = Scene::new(rig, self.observations);
        let found = camera_faults(&scene);
        let of_cameras = || found.faults.iter().map(|fault| camera_cause(rig, *fault)).collect();

        // what the masks hold; where they are good there is nothing to look for
        if !is_unusable && overlap > GOOD_OVERLAP {
            let is_fine = found.faults.is_empty();
            let of_body = || self.too_fast().or_else(|| self.too_large()).into_iter().collect();
            return if is_fine { of_body() } else { of_cameras() };
        }
        if found.explain_nearly_all() {
            return of_cameras();
        }
        if let Some(still) = self.still_parts() {
            return vec![still];
        }

        // the room that the silhouettes leave, without the cameras that are elsewhere
        let volumes = volumes(rig, self.observations, &found.readings);
        let litres = apart_l(&volumes, |frame| self.body(frame));
        let height_m = height_m(&volumes).filter(|height| *height < WHOLE * body_size(model));
        let is_tight = rig.cameras.len() > FEW_CAMERAS;
        if litres > BODY_L && (is_tight || is_unusable && rig.cameras.len() == FEW_CAMERAS) {
            return vec![Cause::SecondBody { litres }];
        }
        let turned = if is_unusable { self.turned() } else { None };
        let cut_off = height_m.filter(|_| is_unusable).map(|height_m| Cause::CutOff { height_m });
        if let Some(cause) = turned.or(cut_off) {
            return vec![cause];
        }

        // cameras that explain a part of it
        if !found.faults.is_empty() {
            return of_cameras();
        }
        if is_unusable && found.left_m > MASKS_AGREE_M {
            return vec![Cause::MasksDisagree { miss_m: found.left_m }];
        }
        if is_unusable && is_tight && litres > LIMB_L {
            return vec![Cause::SecondBody { litres }];
        }

        // the outlines agree: time or space is of another size
        self.too_fast().or_else(|| self.too_large()).into_iter().collect()
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

    fn still_parts(&self) -> Option<Cause> {
        let rig = self.evidence.rig;
        let shares = still_shares(rig, self.observations, |frame| self.body(frame));
        let large = shares.into_iter().filter(|(_, share)| *share > STILL_PART);
        let large: Vec<(CameraId, f64)> = large.collect();
        let share = large.iter().map(|(_, share)| *share).reduce(f64::max)?;
        let cameras = large.into_iter().map(|(id, _)| name(rig, id)).collect();
        Some(Cause::StillParts { cameras, share })
    }

    fn turned(&self) -> Option<Cause> {
        if self.evidence.model.root == Root::Fixed {
            return None;
        }
        let middle = self.observations.len() / 2;
        let frame = self.observations.iter().skip(middle).find(|f| f.views.len() >= 2)?;
        Some(Cause::Turned { head: head_axis(self.evidence, frame)? })
    }
}

/// Positions of the frames that the body covers much worse than the rest.
pub(in crate::pipeline) fn lost_frames(frames: &[FittedFrame]) -> Vec<usize> {
    let overlaps = frames.iter().enumerate().filter_map(|(i, f)| Some((i, f.mean_iou()?)));
    let overlaps: Vec<(usize, f64)> = overlaps.collect();
    let usual = median(&mut overlaps.iter().map(|(_, iou)| *iou).collect()).unwrap_or(0.0);
    let lost = overlaps.into_iter().filter(|(_, iou)| *iou < LOST_SHARE * usual);
    lost.map(|(i, _)| i).collect()
}

/// What is wrong with the cameras, for recordings that cannot be fitted at all.
pub(in crate::pipeline) fn camera_causes(rig: &Rig, frames: &[FrameObservations]) -> Vec<Cause> {
    let found = camera_faults(&Scene::new(rig, frames));
    found.faults.into_iter().map(|fault| camera_cause(rig, fault)).collect()
}

fn camera_cause(rig: &Rig, fault: CameraFault) -> Cause {
    match fault {
        CameraFault::AllMirrored => Cause::AllMirrored,
        CameraFault::Mirrored(id) => Cause::Mirrored { camera: name(rig, id) },
        CameraFault::Exchanged(a, b) => Cause::Exchanged { cameras: [name(rig, a), name(rig, b)] },
        CameraFault::Late(id, frames) => Cause::Late { camera: name(rig, id), frames },
        CameraFault::AllZoomed(zoom) => Cause::FocalLengths { factor: 1.0 / zoom },
        CameraFault::Zoomed(id, zoom) => {
            Cause::FocalLength { camera: name(rig, id), factor: 1.0 / zoom }
        }
        CameraFault::Elsewhere { camera, miss_m } => {
            Cause::Displaced { camera: name(rig, camera), miss_m }
        }
    }
}

fn name(rig: &Rig, id: CameraId) -> String {
    rig.camera(id).map_or_else(|| id.to_string(), |camera| camera.name.clone())
}
