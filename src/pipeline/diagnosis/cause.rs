//! Why a fit cannot be used, and what is wrong with a recording.

use serde::{Deserialize, Serialize};

use super::cameras::CameraFaults;
use super::fault::CameraFault;
use super::reading::Flip;
use super::upright::HeadAxis;
use crate::camera::{CameraId, Rig};
use crate::pipeline::{CameraQuality, PoseFound};
use crate::silhouette::FrameIndex;

/// Focal lengths of all cameras are wrong alike if they differ by less than this share of what they are wrong by.
const ALIKE: f64 = 0.5;

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
    /// Median over the cameras of how far detections lie from the body, over the person's size in the picture; where no mask tells.
    Detections {
        /// It.
        found: f64,
        /// Its limit.
        most: f64,
    },
    /// −log p(s) over ½n: 1 is usual.
    Body {
        /// It.
        found: f64,
        /// Its limit.
        most: f64,
    },
    /// The largest share of a silhouette that is thin.
    ThinParts {
        /// It.
        found: f64,
        /// Its limit.
        least: f64,
    },
    /// Cameras whose pictures are another's, or mirrored: however well a body covers them, it is not the person.
    WrongPictures {
        /// How many.
        found: f64,
        /// Their limit.
        most: f64,
    },
    /// The largest displacement of a camera, m: one that stands a metre elsewhere was not touched, the optimum is another.
    Displacement {
        /// It.
        found: f64,
        /// Its limit.
        most: f64,
    },
    /// Cameras that were touched though no two others look across them: they or others beside them, and how far away the person is follows from
    /// where they stand.
    Uncrossed {
        /// How many.
        found: f64,
        /// Their limit.
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

/// By how much a focal length is wrong.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct LensOff {
    /// The calibrated over the true one.
    pub factor: f64,
    /// Its standard deviation, where the joint optimum found it; else it is what silhouettes tell, roughly.
    pub sd: Option<f64>,
    /// Whether the fit takes it into account.
    pub used: bool,
}

impl LensOff {
    /// As silhouettes alone tell that the true one is so many times the calibrated one.
    fn roughly(zoom: f64) -> Self {
        Self { factor: 1.0 / zoom, sd: None, used: false }
    }

    /// As the joint optimum found it, where that is surely off.
    fn found(pose: &PoseFound) -> Option<Self> {
        let sd = pose.zoom_sd.filter(|_| pose.is_zoomed())?;
        let factor = 1.0 / pose.zoom;
        Some(Self { factor, sd: Some(sd * factor * factor), used: pose.used })
    }
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
    /// All pictures are turned by half a turn.
    AllUpsideDown,
    /// The pictures of a camera are turned by half a turn.
    UpsideDown {
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
        /// By how much.
        #[serde(flatten)]
        lens: LensOff,
    },
    /// The focal length of a camera is wrong.
    FocalLength {
        /// Its name.
        camera: String,
        /// By how much.
        #[serde(flatten)]
        lens: LensOff,
    },
    /// A camera shows the person elsewhere than the others.
    Displaced {
        /// Its name.
        camera: String,
        /// By how much its outlines miss the others', m.
        miss_m: f64,
    },
    /// A camera was touched after its calibration, as the joint optimum found it.
    Touched {
        /// Its name.
        camera: String,
        /// By how much.
        pose: Box<PoseFound>,
    },
    /// A camera's clock is off, as the joint optimum found it.
    Clock {
        /// Its name.
        camera: String,
        /// By how many frames its pictures are late; negative: early.
        late_frames: f64,
        /// Their standard deviation.
        sd_frames: f64,
    },
    /// Masks hold something that stands still.
    StillParts {
        /// The cameras.
        cameras: Vec<String>,
        /// The largest area or volume, over that of what the masks show.
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
    /// A camera shows pictures again while the person moves. They were left out.
    Repeated {
        /// Its name.
        camera: String,
        /// How many.
        pictures: usize,
    },
    /// Masks hold canes, crutches, a walking frame or poles. They were taken out.
    Rods {
        /// The cameras.
        cameras: Vec<String>,
        /// The share of masks that hold some.
        share: f64,
    },
    /// The masks of some cameras lack a part of the person that the others see. They were left out.
    PartsHidden {
        /// The cameras.
        cameras: Vec<String>,
        /// The largest share of the person that a camera lacks, median over its frames.
        share: f64,
    },
    /// The masks of some cameras hold something that the others do not see. They were left out.
    PartsAlone {
        /// The cameras.
        cameras: Vec<String>,
        /// The largest share of a mask that it is, median over its frames.
        share: f64,
    },
    /// The masks of some cameras hold things that stand still while the person walks. The things were left out.
    Things {
        /// The cameras.
        cameras: Vec<String>,
        /// The largest share of a mask that they are.
        share: f64,
    },
    /// The masks hold shadows on the floor. They were left out.
    Shadows {
        /// The share of the masks' area that was left out.
        share: f64,
    },
    /// The masks hold something that moves with the person. Their borders count less where they lie outside the body.
    Worn {
        /// The share of the body that lay outside the masks before, mean over all silhouettes.
        share: f64,
    },
    /// A camera was touched while it recorded. The shorter side of that was left out.
    TouchedWhile {
        /// Its name.
        camera: String,
        /// The first frame after it.
        frame: FrameIndex,
        /// By how far what it shows jumps there, as an angle, degrees.
        turn_deg: f64,
        /// The first and the last of its frames that were left out.
        left_out: [FrameIndex; 2],
    },
    /// A camera lost frames. What it shows from there on was taken to be so many frames later.
    LostFrames {
        /// Its name.
        camera: String,
        /// The first frame after them, by the number of its file.
        frame: FrameIndex,
        /// How many; negative: so many come twice.
        frames: isize,
    },
    /// The joint optimum put some cameras farther from their calibrated places than anybody moves one, or to where the body covers their masks
    /// much worse than those of the others. They were left out.
    Strayed {
        /// The cameras.
        cameras: Vec<String>,
    },
    /// The masks of half of the cameras or more end at one upright line inside the picture.
    Cropped {
        /// The cameras.
        cameras: Vec<String>,
    },
    /// The masks have lost arms, hands and feet.
    ThinPartsGone,
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

impl Cause {
    /// How many cameras do not show what they would.
    pub(super) fn wrong_pictures(&self, rig: &Rig) -> usize {
        match self {
            Self::AllMirrored | Self::AllUpsideDown => rig.cameras.len(),
            Self::Mirrored { .. } | Self::UpsideDown { .. } => 1,
            Self::Exchanged { .. } => 2,
            _ => 0,
        }
    }
}

/// What is wrong with the cameras, as silhouettes alone tell it.
pub(in crate::pipeline) fn camera_causes(rig: &Rig, found: &CameraFaults) -> Vec<Cause> {
    found.faults.iter().map(|fault| camera_cause(rig, *fault)).collect()
}

/// What the joint optimum found to be wrong with the cameras of a recording at `fps`.
pub(super) fn found_causes(cameras: &[CameraQuality], fps: f64) -> Vec<Cause> {
    let lenses = found_lenses(cameras);
    let of_camera = |quality: &CameraQuality| {
        let camera = || quality.camera.clone();
        let pose = quality.found.pose.filter(PoseFound::was_touched);
        let clock = quality.found.clock.filter(|clock| clock.is_off(fps));
        let touched = pose.map(|pose| Cause::Touched { camera: camera(), pose: Box::new(pose) });
        let off = clock.map(|clock| {
            let (late_frames, sd_frames) = clock.late_frames(fps);
            Cause::Clock { camera: camera(), late_frames, sd_frames: sd_frames.unwrap_or_default() }
        });
        touched.into_iter().chain(off)
    };
    lenses.into_iter().chain(cameras.iter().flat_map(of_camera)).collect()
}

/// Focal lengths that are not the calibrated ones: of all cameras, where they differ alike, or of each.
fn found_lenses(cameras: &[CameraQuality]) -> Vec<Cause> {
    let with_pose = cameras.iter().filter_map(|quality| Some((quality, quality.found.pose?)));
    let with_pose: Vec<(&CameraQuality, PoseFound)> = with_pose.collect();
    let off = with_pose
        .iter()
        .filter_map(|(quality, pose)| Some((quality.camera.clone(), LensOff::found(pose)?)));
    let off: Vec<(String, LensOff)> = off.collect();

    let factors = || off.iter().map(|(_, lens)| lens.factor);
    let (least, most) = (factors().fold(f64::MAX, f64::min), factors().fold(0.0, f64::max));
    let middle = 0.5 * (least + most);
    match off[..] {
        [(_, lens), _, ..]
            if off.len() == with_pose.len() && most - least < ALIKE * (middle - 1.0).abs() =>
        {
            vec![Cause::FocalLengths { lens: LensOff { factor: middle, ..lens } }]
        }
        _ => off.into_iter().map(|(camera, lens)| Cause::FocalLength { camera, lens }).collect(),
    }
}

fn camera_cause(rig: &Rig, fault: CameraFault) -> Cause {
    match fault {
        CameraFault::AllFlipped(Flip::Mirrored) => Cause::AllMirrored,
        CameraFault::AllFlipped(Flip::UpsideDown) => Cause::AllUpsideDown,
        CameraFault::Flipped(id, Flip::Mirrored) => Cause::Mirrored { camera: name(rig, id) },
        CameraFault::Flipped(id, Flip::UpsideDown) => Cause::UpsideDown { camera: name(rig, id) },
        CameraFault::Exchanged(a, b) => Cause::Exchanged { cameras: [name(rig, a), name(rig, b)] },
        CameraFault::Late(id, frames) => Cause::Late { camera: name(rig, id), frames },
        CameraFault::AllZoomed(zoom) => Cause::FocalLengths { lens: LensOff::roughly(zoom) },
        CameraFault::Zoomed(id, zoom) => {
            Cause::FocalLength { camera: name(rig, id), lens: LensOff::roughly(zoom) }
        }
        CameraFault::Elsewhere { camera, miss_m } => {
            Cause::Displaced { camera: name(rig, camera), miss_m }
        }
    }
}

pub(super) fn name(rig: &Rig, id: CameraId) -> String {
    rig.camera(id).map_or_else(|| id.to_string(), |camera| camera.name.clone())
}
