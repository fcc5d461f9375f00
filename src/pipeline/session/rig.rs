//! Which cameras of several trials are the same.
//!
//! All trials' cameras stand in one rig, one after the other. A camera is that of an earlier trial if it has its name and its
//! calibration, number for number; then it has one pose in both. A camera of the same name and another calibration was calibrated anew
//! within the session: it has a pose of its own, and that is told.

use std::fmt;
use std::ops::Range;

use super::SessionTrial;
use crate::camera::{Camera, Rig};

/// Cameras that have another calibration than in an earlier trial.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct OtherCalibration {
    /// The trial.
    pub trial: String,
    /// The earlier one.
    pub than: String,
    /// The cameras.
    pub cameras: Vec<String>,
}

impl fmt::Display for OtherCalibration {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { trial, than, cameras } = self;
        write!(
            f,
            "another calibration in the middle of the session: trial {trial} has another one of {} than trial {than}; \
             where they stand is estimated of each calibration by itself",
            cameras.join(", ")
        )
    }
}

/// The cameras of all trials.
pub(super) struct SharedRig {
    pub(super) rig: Rig,
    /// Those of each trial.
    pub(super) cameras: Vec<Range<usize>>,
    /// The camera of an earlier trial that each one is.
    pub(super) same: Vec<Option<usize>>,
    pub(super) others: Vec<OtherCalibration>,
}

impl SharedRig {
    pub(super) fn new(trials: &[SessionTrial<'_>]) -> Self {
        let mut all =
            Self { rig: Rig::default(), cameras: Vec::new(), same: Vec::new(), others: Vec::new() };
        // the trial in which each camera stands
        let mut of_trial: Vec<usize> = Vec::new();
        for (k, trial) in trials.iter().enumerate() {
            let known = all.rig.cameras.len();
            let mut others: Vec<(usize, String)> = Vec::new();
            for camera in &trial.rig.cameras {
                let same = all.rig.cameras[..known].iter().position(|other| other == camera);
                let named = |other: &Camera| other.name == camera.name;
                let named = all.rig.cameras[..known].iter().position(named);
                if let (None, Some(named)) = (same, named) {
                    others.push((of_trial[named], camera.name.clone()));
                }
                all.same.push(same);
            }
            all.cameras.push(known..known + trial.rig.cameras.len());
            all.rig.cameras.extend(trial.rig.cameras.iter().cloned());
            of_trial.resize(all.rig.cameras.len(), k);
            if let Some((than, _)) = others.first() {
                let (trial, than) = (trial.name.into(), trials[*than].name.into());
                let cameras = others.into_iter().map(|(_, camera)| camera).collect();
                all.others.push(OtherCalibration { trial, than, cameras });
            }
        }
        all
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::DVector;

    use super::*;
    use crate::body::Shape;
    use crate::inference::Sequence;
    use crate::pipeline::{AloneFit, EstimateOptions};
    use crate::synth::Ring;

    #[test]
    fn a_camera_of_another_calibration_is_named_and_its_pose_is_its_own() {
        let alone = AloneFit {
            shape: Shape(DVector::zeros(0)),
            covariance: None,
            motions: Vec::new(),
            recovered: Vec::new(),
            cameras: Vec::new(),
            keyframes: Vec::new(),
            jumps: Vec::new(),
            worn: None,
        };
        let rig = Ring { cameras: 4, ..Ring::default() }.regular();
        let mut moved = rig.clone();
        moved.cameras[1].camera_from_world.translation.vector.x += 0.01;

        let options = EstimateOptions::default();
        let sequence = Sequence { frames: &[], fps: 10.0 };
        let trial = |name, rig| SessionTrial {
            name,
            rig,
            sequence,
            options: &options,
            alone: alone.clone(),
        };
        let trials = [trial("a", &rig), trial("b", &rig), trial("c", &moved)];
        let shared = SharedRig::new(&trials);
        let same: Vec<Option<usize>> = (0..4).map(Some).collect();
        assert_eq!(shared.same[4..8], same);
        assert_eq!(shared.same[8..], [Some(0), None, Some(2), Some(3)]);
        let line = shared.others[0].to_string();
        let name = &rig.cameras[1].name;
        assert!(
            line.contains(&format!("trial c has another one of {name} than trial a")),
            "{line}"
        );
    }
}
