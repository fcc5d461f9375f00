//! All cameras of a recording.

use std::fmt;

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use super::Camera;

/// Which camera of a [`Rig`]: its index, from 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct CameraId(pub usize);

impl fmt::Display for CameraId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "camera {}", self.0)
    }
}

/// Calibrated cameras in one world frame.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Rig {
    /// The cameras; a [`CameraId`] is an index into them.
    pub cameras: Vec<Camera>,
}

impl Rig {
    /// The camera with this id.
    pub fn camera(&self, id: CameraId) -> Option<&Camera> {
        self.cameras.get(id.0)
    }

    /// The first camera with this name.
    pub fn by_name(&self, name: &str) -> Option<(CameraId, &Camera)> {
        self.iter().find(|(_, camera)| camera.name == name)
    }

    /// The cameras with their ids, in order.
    pub fn iter(&self) -> impl Iterator<Item = (CameraId, &Camera)> {
        self.cameras.iter().enumerate().map(|(index, camera)| (CameraId(index), camera))
    }

    /// Whether the cameras, held upright as most are, have the world's z upwards: within 60° of it on the mean.
    pub fn is_upright(&self) -> bool {
        let up = |camera: &Camera| camera.camera_from_world.rotation.inverse() * -Vector3::y();
        let sum: Vector3<f64> = self.cameras.iter().map(up).sum();
        sum.z > 0.5 * self.cameras.len() as f64
    }

    /// The names, in order.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.cameras.iter().map(|camera| camera.name.as_str())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::{Distortion, Intrinsics};
    use crate::math::Rigid3;
    use crate::synth::Ring;

    #[test]
    fn cameras_are_upright_in_their_world_and_not_in_one_with_another_axis_up() {
        let rig = Ring::default().regular();
        assert!(rig.is_upright());
        for turn in [Vector3::x(), Vector3::y(), 2.0 * Vector3::x()] {
            let mut turned = rig.clone();
            let quarters = Rigid3::rotation(turn * std::f64::consts::FRAC_PI_2);
            turned.cameras.iter_mut().for_each(|camera| camera.camera_from_world *= quarters);
            assert!(!turned.is_upright(), "{turn}");
        }
    }

    #[test]
    fn a_camera_is_found_by_its_name() {
        let camera = |name: &str| Camera {
            name: name.into(),
            width_px: 4,
            height_px: 3,
            intrinsics: Intrinsics { fx_px: 4.0, fy_px: 4.0, cx_px: 1.5, cy_px: 1.0, skew_px: 0.0 },
            distortion: Distortion::None,
            camera_from_world: Rigid3::identity(),
        };
        let rig = Rig { cameras: vec![camera("left"), camera("right")] };
        assert_eq!(rig.by_name("right").unwrap().0, CameraId(1));
        assert_eq!(rig.by_name("centre"), None);
        assert_eq!(rig.camera(CameraId(2)), None);
        assert_eq!(rig.names().collect::<Vec<_>>(), ["left", "right"]);
    }
}
