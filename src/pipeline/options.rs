//! The settings of a fit: what is observed, and one field for each stage of the estimate.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::inference::ConfidenceOptions;
use crate::inference::camera_prior::{Free, PoseErrors};
use crate::inference::joint::{JointOptions, Rounds};
use crate::inference::search::SearchOptions;
use crate::likelihood::{LikelihoodOptions, Measure};
use crate::silhouette::{FrameObservations, InvalidOption, SilhouetteOptions};
use crate::solver::Loss;

/// From masks and points to what is fitted to.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ObservationOptions {
    /// From masks to silhouettes.
    pub silhouettes: SilhouetteOptions,
    /// Which of the observations are fitted to.
    pub fit_to: FitTo,
    /// Who is looked for, and who is measured.
    pub people: PeopleOptions,
}

/// Who is looked for in a recording, and who is measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct PeopleOptions {
    /// At most so many people, those who are in view longest; none: as many as the masks show.
    pub most: Option<usize>,
    /// Who is measured: 1 is the one who is in view longest and crosses the room.
    pub person: usize,
}

impl Default for PeopleOptions {
    fn default() -> Self {
        Self { most: None, person: 1 }
    }
}

/// The settings of the estimate, one for each stage of [`fit`](super::fit).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct EstimateOptions {
    /// −log p(Z | m, s).
    pub likelihood: LikelihoodOptions,
    /// What silhouettes are compared with. By default Algorithm 1 looks at the ellipsoids, which are fast, and the
    /// joint optimum at the metaballs, which are fine; whichever of them the model has.
    pub measure: Option<Measure>,
    /// Algorithm 1.
    pub search: SearchOptions,
    /// The joint optimum; none: the winner of Algorithm 1 as it was tracked.
    pub joint: Option<JointOptions>,
    /// Whether cameras may be a little elsewhere than their calibration says; only with the joint optimum, and without points,
    /// which were measured with the calibration.
    pub cameras: Cameras,
    /// What the calibration errs by.
    #[serde(skip_serializing_if = "is_usual")]
    pub calibration_errors: PoseErrors,
    /// Whether their clocks may be off; as for `cameras`.
    pub clocks: Clocks,
    /// By how many frames the pictures of a camera are known to be ahead, by its name: where the estimate of its clock starts, and
    /// what it is where it is not estimated but other clocks or places are.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub ahead_frames: BTreeMap<String, f64>,
    /// ε of the confidence.
    pub confidence: ConfidenceOptions,
    /// The person's height without shoes, metres, where it is known. It changes nothing of the estimate: the verdict tests the
    /// size of the world with it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub height_m: Option<f64>,
}

impl Default for EstimateOptions {
    fn default() -> Self {
        Self {
            likelihood: LikelihoodOptions::default(),
            measure: None,
            search: SearchOptions::default(),
            joint: Some(JointOptions::default()),
            cameras: Cameras::default(),
            calibration_errors: PoseErrors::default(),
            clocks: Clocks::default(),
            ahead_frames: BTreeMap::new(),
            confidence: ConfidenceOptions::default(),
            height_m: None,
        }
    }
}

/// What most calibrations err by is not worth a line in a result.
fn is_usual(errors: &PoseErrors) -> bool {
    *errors == PoseErrors::default()
}

/// Where the cameras are.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Cameras {
    /// Where their calibration says.
    Trust,
    /// About there: turns, displacements and focal lengths are estimated.
    #[default]
    Refine,
    /// Where their calibration says; turns, displacements and focal lengths are estimated and told, and not used.
    Check,
}

/// When the cameras took their pictures.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Clocks {
    /// All at once.
    Trust,
    /// By clocks that may be off: offsets are estimated.
    #[default]
    Estimate,
}

/// Which of the observations are fitted to.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum FitTo {
    /// Silhouettes, and points and detections where there are any.
    #[default]
    All,
    /// Silhouettes alone.
    Silhouettes,
    /// Points alone.
    Points,
    /// Detections alone.
    Detections,
}

impl FitTo {
    /// Keeps what is fitted to of a frame.
    pub fn select(self, mut frame: FrameObservations) -> FrameObservations {
        let FrameObservations { views, points, detections, .. } = &mut frame;
        match self {
            Self::All => {}
            Self::Silhouettes => {
                points.clear();
                detections.clear();
            }
            Self::Points => {
                views.clear();
                detections.clear();
            }
            Self::Detections => {
                views.clear();
                points.clear();
            }
        }
        frame
    }
}

/// A height that is in its range where none is given.
const USUAL_HEIGHT_M: f64 = 1.7;

/// Name, value, least and most.
type Range = (&'static str, f64, f64, f64);

impl EstimateOptions {
    /// Whether every option is in its range.
    ///
    /// # Errors
    /// [`InvalidOption`] for the first that is not.
    pub fn validate(&self) -> Result<(), InvalidOption> {
        let displacement_m = self.calibration_errors.displacement_m;
        let ranges = [
            self.ranges_of_likelihood().as_slice(),
            self.ranges_of_search().as_slice(),
            &[
                ("calibration_errors.turn_deg", self.calibration_errors.turn_deg, 1e-6, 180.0),
                ("calibration_errors.displacement_m", displacement_m, 1e-9, 100.0),
                ("height_m", self.height_m.unwrap_or(USUAL_HEIGHT_M), 0.4, 2.6),
                ("epsilon_m", self.confidence.epsilon_m, 1e-6, 10.0),
                ("epsilon_coefficient", self.confidence.epsilon_coefficient, 1e-6, 10.0),
            ],
        ]
        .concat();

        let outside = |(_, value, least, most): &Range| !(*least..=*most).contains(value);
        match ranges.into_iter().find(outside) {
            Some((name, value, least, most)) => Err(InvalidOption { name, value, least, most }),
            None => Ok(()),
        }
    }

    /// The same for a trial of a session by itself: to the optimum from which that of all trials starts
    /// ([`fit_session`](super::fit_session)).
    #[must_use]
    pub fn of_trial_alone(&self) -> Self {
        let joint = self.joint.map(|joint| JointOptions { rounds: Rounds::Thinned, ..joint });
        Self { joint, ..self.clone() }
    }

    /// What of the cameras is estimated to be told of.
    pub(super) fn asked(&self) -> Free {
        Free { pose: self.cameras != Cameras::Trust, ..self.free() }
    }

    /// What of the cameras is an unknown of the result.
    pub(super) fn free(&self) -> Free {
        Free { pose: self.cameras == Cameras::Refine, clock: self.clocks == Clocks::Estimate }
    }

    fn ranges_of_likelihood(&self) -> [Range; 6] {
        let likelihood = &self.likelihood.ellipses;
        let width = match likelihood.loss {
            Loss::Squared => 1.0,
            Loss::Cauchy(width) | Loss::Geman(width) => width,
        };
        let samples = likelihood.back_samples as f64;
        [
            ("sigma_px", likelihood.sigma_px, 0.01, 100.0),
            ("sigma_m", likelihood.sigma_m, 0.0, 1.0),
            ("correlation_m", likelihood.correlation_m, 1e-4, 10.0),
            ("blend_m", likelihood.blend_m, 1e-5, 1.0),
            ("loss", width, 0.1, 1e6),
            ("back_samples", samples, 0.0, 1000.0),
        ]
    }

    fn ranges_of_search(&self) -> [Range; 6] {
        let (search, start) = (&self.search, &self.search.start);
        let track = &search.track;
        let every = search.keyframe_every.unwrap_or(1) as f64;
        let many = 1e6;
        [
            ("keyframe_every", every, 1.0, many),
            ("start.headings", start.headings as f64, 1.0, 360.0),
            ("start.iterations", start.iterations as f64, 1.0, 1000.0),
            ("start.kept", start.kept as f64, 1.0, 1000.0),
            ("track.iterations", track.iterations as f64, 1.0, 1000.0),
            ("track.recovery_ratio", track.recovery_ratio, 1.0, many),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_defaults_are_valid_and_survive_being_written() {
        let options = EstimateOptions::default();
        assert_eq!(options.validate(), Ok(()));
        let text = serde_json::to_string(&options).unwrap();
        assert_eq!(serde_json::from_str::<EstimateOptions>(&text).unwrap(), options);
    }

    #[test]
    fn nonsense_is_named_with_its_range() {
        let mut options = EstimateOptions::default();
        options.search.keyframe_every = Some(0);
        let message = options.validate().unwrap_err().to_string();
        assert_eq!(message, "option keyframe_every = 0: expected 1 to 1000000");
        let mut options = EstimateOptions::default();
        options.likelihood.ellipses.sigma_px = f64::NAN;
        assert_eq!(options.validate().unwrap_err().name, "sigma_px");
        let mut options = EstimateOptions::default();
        options.likelihood.ellipses.loss = Loss::Cauchy(0.0);
        assert_eq!(options.validate().unwrap_err().name, "loss");
        let mut options = EstimateOptions::default();
        options.confidence.epsilon_m = -0.02;
        assert_eq!(options.validate().unwrap_err().name, "epsilon_m");
        let options = EstimateOptions { height_m: Some(180.0), ..EstimateOptions::default() };
        let message = options.validate().unwrap_err().to_string();
        assert_eq!(message, "option height_m = 180: expected 0.4 to 2.6");
    }
}
