//! The main job: from observations to shape, motion and confidence; and before it, from pictures to masks ([`segment`]).
//!
//! | stage                               | where                              |
//! |-------------------------------------|------------------------------------|
//! | 0. whose the masks are, and the detections | [`people()`], [`detected_people`]              |
//! | 1. do cameras and masks agree       | [`check_scene`]                    |
//! | 2. Algorithm 1                      | [`crate::inference::search`]       |
//! | 3. the joint optimum, and where the cameras look | [`crate::inference::joint`], [`crate::inference::camera_offset`] |
//! | 4. how far the keyframes agree      | [`crate::inference::ShapeConfidence`] |
//! | 5. how well the body covers the masks, and lies on the points | [`ViewQuality`], [`CameraQuality`], [`PointQuality`], [`DetectionQuality`] |
//! | 6. what a person should know of it  | [`Warning`]                        |

mod ambiguity;
mod camera_covariance;
mod camera_found;
mod clock_line;
mod counted;
mod detected;
mod diagnosis;
mod estimate;
mod fit;
mod fit_error;
mod fitted;
mod frame_range;
mod hidden;
mod joint_stage;
mod judged;
mod jumps;
mod lenses;
mod measures;
mod memory;
mod movement;
mod options;
mod overlap;
mod people;
mod person;
mod points;
mod progress;
mod quality;
mod rig_estimate;
mod scene;
pub mod segment;
mod session;
pub mod silhouettes;
mod sound;
mod source;
pub mod stereo;
mod strayed;
mod unseen;
mod warning;
mod warning_text;
mod watch;
mod worn;

pub use crate::inference::covariance::ShapeUncertainty;
pub use camera_covariance::{CameraCovariances, POSE, without_lenses};
pub use camera_found::{CameraFound, ClockFound, PoseFound};
pub use clock_line::{ClockLine, Drift, TOLD_PPM, WindowClock, clock_line};
pub use counted::counted;
pub use detected::{DetectedQuality, DetectionQuality};
pub use diagnosis::{
    Cause, HeadAxis, LensOff, Reason, Verdict, largest_people, other_pose_form, strangers,
};
pub use fit::{Fit, fit, fit_watched};
pub use fit_error::FitError;
pub use fitted::{FittedFrame, MinusLogPosterior, TriedHypothesis};
pub use frame_range::{FrameRange, FrameRangeError, span};
pub use lenses::{
    LensError, PlaceSd, PlacedRig, Scale, Size, SizeError, Walker, placed_rig, relative_sds,
};
pub use measures::check_measure;
pub(crate) use measures::fits_points;
pub use memory::MemoryPictures;
pub use movement::{FittedBody, FittedMotion, FittedPoint, FramePose, FrameSd};
pub use options::{Cameras, Clocks, EstimateOptions, FitTo, ObservationOptions, PeopleOptions};
pub use people::{LEAST_SHARE, by_labels, people};
pub use person::{Beside, Person, detected_people, other_scale};
pub use points::PointQuality;
pub use progress::{NoProgress, Progress};
pub use quality::{CameraQuality, ViewQuality};
pub use rig_estimate::{RigEstimate, RigEvidence, Singular, rig_estimate};
pub(crate) use scene::MOST_EMPTY_FRAMES;
pub use scene::check_scene;
pub use session::{
    AloneFit, Disagreement, OneBody, OtherCalibration, SessionFit, SessionTrial, disagreements,
    fit_session, one_body,
};
pub use sound::{ENVELOPE_HZ, sound_delay_s};
pub use source::{FramePictures, MaskSource, PictureSource, PictureStream};
pub use unseen::prior_angles_sd;
pub use warning::{Frames, Warning};
