//! Where and when a camera was found to be, against its calibration and its clock.

use nalgebra::{SVector, UnitQuaternion, Vector3};
use serde::{Deserialize, Serialize};

use crate::body::{Layout, Motion};
use crate::inference::camera_offset::{AHEAD, COMPONENTS, CameraOffset, ZOOM};
use crate::inference::camera_prior::{DISPLACEMENT_SD_M, Free, TURN_SD};
use crate::inference::instant::Instant;
use crate::inference::lens_prior::ZOOM_SD;

/// By how much a camera was found to be off; what was not estimated is not there.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct CameraFound {
    /// Its place and its focal length.
    pub pose: Option<PoseFound>,
    /// Its clock.
    pub clock: Option<ClockFound>,
}

/// By how much a camera was turned and displaced after its calibration, and zoomed. World axes.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct PoseFound {
    /// Axis times angle of the turn about the camera's own centre, degrees.
    pub turn_deg: [f64; 3],
    /// Its standard deviations, relative to the rig; withheld where the fit cannot be used.
    pub turn_sd_deg: Option<[f64; 3]>,
    /// The displacement, metres.
    pub displacement_m: [f64; 3],
    /// Its standard deviations.
    pub displacement_sd_m: Option<[f64; 3]>,
    /// The focal length over the calibrated one.
    pub zoom: f64,
    /// Its standard deviation.
    pub zoom_sd: Option<f64>,
    /// Whether the fit takes it into account; else it is told, and the camera taken as calibrated.
    #[serde(default = "is_used")]
    pub used: bool,
}

/// What results said before anything was told and not used.
fn is_used() -> bool {
    true
}

/// By how much a camera's pictures are ahead of the recording's time.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ClockFound {
    /// Seconds; negative: late.
    pub ahead_s: f64,
    /// Its standard deviation.
    pub sd_s: Option<f64>,
}

/// What is known to be off by so many of its standard deviations is told: by chance a normal number is in one case of 370.
const SURE: f64 = 3.0;
/// The length of three numbers that is as rare: √ of the same quantile of χ² with three degrees of freedom.
const SURE_OF_THREE: f64 = 3.76;
/// A clock that is off by less is not worth a word, frames.
const USUAL_FRAMES: f64 = 0.125;

impl CameraFound {
    /// Of what is free of a camera; `sd` are the standard deviations of its components.
    pub(super) fn new(
        offset: &CameraOffset,
        free: Free,
        sd: Option<&SVector<f64, COMPONENTS>>,
    ) -> Self {
        let degrees = |v: Vector3<f64>| v.map(f64::to_degrees).into();
        let three = |first: usize| sd.map(|sd| sd.fixed_rows::<3>(first).into_owned());
        let pose = PoseFound {
            turn_deg: degrees(offset.turn.scaled_axis()),
            turn_sd_deg: three(0).map(degrees),
            displacement_m: offset.displacement_m.into(),
            displacement_sd_m: three(3).map(Into::into),
            zoom: offset.log_zoom.exp(),
            zoom_sd: sd.map(|sd| sd[ZOOM] * offset.log_zoom.exp()),
            used: true,
        };
        let clock = ClockFound { ahead_s: offset.ahead_s, sd_s: sd.map(|sd| sd[AHEAD]) };
        Self { pose: free.pose.then_some(pose), clock: free.clock.then_some(clock) }
    }

    /// What was an unknown of the fit.
    pub(super) fn free(&self) -> Free {
        Free { pose: self.pose.is_some_and(|pose| pose.used), clock: self.clock.is_some() }
    }

    /// The camera's offset; none of what was not estimated, or not used.
    pub fn offset(&self) -> CameraOffset {
        let none = CameraOffset::none();
        let pose = self.pose.filter(|pose| pose.used).map(|pose| pose.offset());
        let ahead_s = self.clock.map_or(0.0, |clock| clock.ahead_s);
        CameraOffset { ahead_s, ..pose.unwrap_or(none) }
    }

    /// The motion that the camera shows in frame i: that of another moment, where its clock is off.
    pub(crate) fn shown(
        &self,
        layout: Layout,
        motions: &[Motion],
        times_s: &[f64],
        i: usize,
    ) -> Motion {
        match self.clock {
            None => motions[i].clone(),
            Some(clock) => Instant::at(layout, motions, times_s, times_s[i] + clock.ahead_s).motion,
        }
    }

    /// Without standard deviations.
    pub(super) fn withhold(&mut self) {
        if let Some(pose) = &mut self.pose {
            (pose.turn_sd_deg, pose.displacement_sd_m, pose.zoom_sd) = (None, None, None);
        }
        if let Some(clock) = &mut self.clock {
            clock.sd_s = None;
        }
    }
}

impl PoseFound {
    /// The offset that was found, used or not.
    pub fn offset(&self) -> CameraOffset {
        let turn = Vector3::from(self.turn_deg).map(f64::to_radians);
        CameraOffset {
            turn: UnitQuaternion::from_scaled_axis(turn),
            displacement_m: self.displacement_m.into(),
            log_zoom: self.zoom.ln(),
            ..CameraOffset::none()
        }
    }

    /// Whether the camera was surely touched, by more than a usual calibration is off.
    pub fn was_touched(&self) -> bool {
        let is_off = |(off, sd): (f64, Option<f64>), usual: f64| {
            sd.is_some_and(|sd| off > SURE_OF_THREE * sd) && off > usual
        };
        is_off(self.turn(), TURN_SD.to_degrees()) || is_off(self.displacement(), DISPLACEMENT_SD_M)
    }

    /// Whether its focal length is surely not the calibrated one, by more than a usual calibration errs.
    pub fn is_zoomed(&self) -> bool {
        let off = (self.zoom - 1.0).abs();
        self.zoom_sd.is_some_and(|sd| off > SURE * sd) && off > ZOOM_SD
    }

    /// The angle of the turn and its standard deviation, degrees.
    pub fn turn(&self) -> (f64, Option<f64>) {
        length(self.turn_deg, self.turn_sd_deg)
    }

    /// By which share its focal length is longer than the calibrated one, and the standard deviation.
    pub fn longer(&self) -> (f64, Option<f64>) {
        (self.zoom - 1.0, self.zoom_sd)
    }

    /// The way of the displacement and its standard deviation, metres.
    pub fn displacement(&self) -> (f64, Option<f64>) {
        length(self.displacement_m, self.displacement_sd_m)
    }
}

impl ClockFound {
    /// By how many frames its pictures are late, and the standard deviation.
    pub fn late_frames(&self, fps: f64) -> (f64, Option<f64>) {
        (-self.ahead_s * fps, self.sd_s.map(|sd| sd * fps))
    }

    /// Whether the clock is surely off, by more than an eighth of a frame.
    pub fn is_off(&self, fps: f64) -> bool {
        let is_sure = self.sd_s.is_some_and(|sd| self.ahead_s.abs() > SURE * sd);
        is_sure && self.ahead_s.abs() * fps > USUAL_FRAMES
    }
}

/// ‖x‖ and its standard deviation √(Σ x²σ²)/‖x‖, of components that are taken to be independent; none where it is withheld.
fn length(x: [f64; 3], sd: Option<[f64; 3]>) -> (f64, Option<f64>) {
    let x = Vector3::from(x);
    let norm = x.norm();
    let along = |sd: Vector3<f64>| match norm > 0.0 {
        true => x.component_mul(&sd).norm() / norm,
        false => sd.max(),
    };
    (norm, sd.map(|sd| along(sd.into())))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pose(turn_deg: f64, displacement_m: f64) -> PoseFound {
        PoseFound {
            turn_deg: [turn_deg, 0.0, 0.0],
            turn_sd_deg: Some([0.1; 3]),
            displacement_m: [0.0, displacement_m, 0.0],
            displacement_sd_m: Some([0.005; 3]),
            zoom: 1.0,
            zoom_sd: Some(0.001),
            used: true,
        }
    }

    #[test]
    fn a_camera_was_touched_where_that_is_sure_and_not_where_it_may_be() {
        assert!(pose(1.0, 0.0).was_touched() && pose(0.0, 0.02).was_touched());
        assert!(!pose(0.25, 0.012).was_touched());
        let zoomed = |zoom: f64| PoseFound { zoom, ..pose(0.0, 0.0) };
        assert!(zoomed(0.98).is_zoomed() && !zoomed(1.0025).is_zoomed());
        assert!(!zoomed(1.0015).is_zoomed() && !zoomed(0.98).was_touched());
        let mut withheld = CameraFound { pose: Some(pose(1.0, 0.02)), clock: None };
        withheld.withhold();
        let withheld = withheld.pose.unwrap();
        assert!(!withheld.was_touched() && !PoseFound { zoom: 1.1, ..withheld }.is_zoomed());
        assert_eq!(withheld.turn(), (1.0, None));
    }

    #[test]
    fn what_is_written_is_what_was_found() {
        let mut found = CameraFound {
            pose: Some(PoseFound { zoom: 1.02, ..pose(1.0, 0.02) }),
            clock: Some(ClockFound { ahead_s: -0.03, sd_s: Some(0.002) }),
        };
        let free = Free { pose: true, clock: true };
        let again = CameraFound::new(&found.offset(), free, None).offset();
        approx::assert_relative_eq!(again.turn.angle().to_degrees(), 1.0, epsilon = 1e-9);
        approx::assert_relative_eq!(again.log_zoom.exp(), 1.02, epsilon = 1e-12);
        assert_eq!((again.displacement_m.y, again.ahead_s), (0.02, -0.03));
        let (turn, sd) = found.pose.unwrap().turn();
        assert_eq!((turn, sd), (1.0, Some(0.1)));
        assert_eq!(CameraFound::default().offset(), CameraOffset::none());

        // what is only told moves nothing
        found.pose = found.pose.map(|pose| PoseFound { used: false, ..pose });
        let told = found.offset();
        let nothing = (told.turn.angle(), told.displacement_m.y, told.log_zoom, told.ahead_s);
        assert_eq!(nothing, (0.0, 0.0, 0.0, -0.03));
    }
}
