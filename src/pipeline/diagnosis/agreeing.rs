//! What the cameras show that agree: until the joint optimum finds out where and when the others are, the search looks at these.

use super::cameras::CameraFaults;
use super::fault::CameraFault;
use crate::camera::CameraId;
use crate::inference::camera_prior::Free;
use crate::silhouette::{FrameIndex, FrameObservations, numbered_anew};

impl CameraFaults {
    /// By how many frames the pictures of each camera seem ahead.
    pub(in crate::pipeline) fn ahead_frames(&self) -> Vec<isize> {
        let mut ahead = vec![0; self.readings.len()];
        for fault in &self.faults {
            if let CameraFault::Late(id, frames) = fault {
                ahead[id.0] = -frames;
            }
        }
        ahead
    }

    /// ζ of each camera: the logarithm of the focal length that its silhouettes tell, over the calibrated one.
    pub(in crate::pipeline) fn log_zooms(&self) -> Vec<f64> {
        let mut zooms = vec![0.0; self.readings.len()];
        for fault in &self.faults {
            match fault {
                CameraFault::AllZoomed(zoom) => zooms.iter_mut().for_each(|z| *z += zoom.ln()),
                CameraFault::Zoomed(id, zoom) => zooms[id.0] += zoom.ln(),
                _ => {}
            }
        }
        zooms
    }

    /// Whether a camera shows the person elsewhere than the others do.
    pub(in crate::pipeline) fn is_elsewhere(&self, id: CameraId) -> bool {
        let is_it = |fault: &CameraFault| {
            matches!(fault, CameraFault::Elsewhere { .. }) && fault.camera() == Some(id.0)
        };
        self.faults.iter().any(is_it)
    }

    /// What the cameras show that agree: late ones at their moments where clocks are `free`, without those that are elsewhere where poses
    /// are. `None` where there is nothing to change.
    pub(in crate::pipeline) fn agreeing(
        &self,
        frames: &[FrameObservations],
        free: Free,
    ) -> Option<Vec<FrameObservations>> {
        let ahead = if free.clock { self.ahead_frames() } else { vec![0; self.readings.len()] };
        let is_left_out = |id: CameraId| free.pose && self.is_elsewhere(id);
        let cameras = ahead.iter().enumerate().map(|(i, ahead)| (CameraId(i), *ahead));
        let changed: Vec<(CameraId, isize)> =
            cameras.filter(|(id, ahead)| *ahead != 0 || is_left_out(*id)).collect();
        let change = |frames: Vec<FrameObservations>, (id, ahead): &(CameraId, isize)| {
            match is_left_out(*id) {
                true => frames.iter().map(|frame| frame.without(*id)).collect(),
                false => numbered_anew(&frames, *id, FrameIndex(0), *ahead),
            }
        };
        (!changed.is_empty()).then(|| changed.iter().fold(frames.to_vec(), change))
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Point2;

    use super::*;
    use crate::pipeline::diagnosis::figures::{late, walker};

    /// The centroid of what a camera shows in a frame.
    fn shown(frame: &FrameObservations, camera: usize) -> Option<Point2<f64>> {
        let view = frame.views.iter().find(|(id, _)| id.0 == camera);
        view.map(|(_, silhouette)| silhouette.centroid)
    }

    const ALL: Free = Free { pose: true, clock: true };

    #[test]
    fn a_late_camera_is_searched_at_its_moments_if_clocks_are_unknown() {
        let (rig, frames) = walker();
        assert!(CameraFaults::of(&rig, &frames).agreeing(&frames, ALL).is_none());

        let spoiled = late(&frames, 1, 3);
        let faults = CameraFaults::of(&rig, &spoiled);
        assert_eq!(faults.ahead_frames()[1], -3);
        assert!(faults.agreeing(&spoiled, Free { clock: false, ..ALL }).is_none());
        let agreeing = faults.agreeing(&spoiled, ALL).expect("one is late");
        for (found, right) in agreeing.iter().zip(&frames).take(frames.len() - 3) {
            assert_eq!(shown(found, 1), shown(right, 1));
            assert_eq!(shown(found, 2), shown(right, 2));
        }
    }

    #[test]
    fn a_camera_that_is_elsewhere_is_not_searched_if_poses_are_unknown() {
        let (mut rig, frames) = walker();
        rig.cameras[1].camera_from_world.translation.vector.x += 0.3;
        let faults = CameraFaults::of(&rig, &frames);
        assert!(faults.agreeing(&frames, Free { pose: false, ..ALL }).is_none());
        let agreeing = faults.agreeing(&frames, ALL).expect("one is elsewhere");
        assert!(agreeing.iter().all(|frame| shown(frame, 1).is_none()));
        assert!(agreeing.iter().all(|frame| shown(frame, 2).is_some()));
    }
}
