//! Depths of a camera, frame by frame, and the places that they show.

use std::collections::BTreeMap;

use nalgebra::{Point3, Vector3};

use super::ends::nearness;
use crate::camera::Camera;
use crate::image::Plane;
use crate::silhouette::FrameIndex;
use crate::stereo::{CloudPoint, DepthMap, Spread};

/// Every so many moving pixels one is taken to find the place.
pub(super) const EVERY_PX: usize = 2;

/// Depths that one camera has seen, frame by frame.
#[derive(Debug, Clone)]
pub(super) struct SeenDepths {
    /// The rectified camera.
    pub(super) camera: Camera,
    /// Distance of the camera beside it, m.
    pub(super) baseline_m: f64,
    /// How near each pixel is, px; NaN unknown.
    pub(super) maps: BTreeMap<FrameIndex, Plane<f32>>,
}

impl SeenDepths {
    /// Those of one frame.
    pub(super) fn of(frame: FrameIndex, map: &DepthMap) -> Self {
        let baseline_m = map.pair.baseline().abs();
        let maps = BTreeMap::from([(frame, nearness(map))]);
        Self { camera: map.pair.left.camera.clone(), baseline_m, maps }
    }

    /// Depth · nearness, m px.
    pub(super) fn scale(&self) -> f64 {
        self.camera.intrinsics.fx_px * self.baseline_m
    }

    /// The place that a pixel shows; `None` where nothing is known, or at infinity.
    pub(super) fn place(&self, x: usize, y: usize, nearness: f32) -> Option<Point3<f64>> {
        let depth_m = self.scale() / f64::from(nearness);
        if !depth_m.is_finite() || depth_m <= 0.0 {
            return None;
        }
        let k = &self.camera.intrinsics;
        let ray = Vector3::new((x as f64 - k.cx_px) / k.fx_px, (y as f64 - k.cy_px) / k.fy_px, 1.0);
        Some(self.camera.camera_from_world.inverse() * Point3::from(ray * depth_m))
    }

    /// The places of every few pixels that `shows` (column, row) tells the nearness of.
    pub(super) fn places(&self, shows: impl Fn(usize, usize) -> Option<f32>) -> Vec<CloudPoint> {
        let (width, height) = (self.camera.width_px as usize, self.camera.height_px as usize);
        let rows = (0..height).step_by(EVERY_PX);
        let pixels = rows.flat_map(|y| (0..width).step_by(EVERY_PX).map(move |x| (x, y)));
        let place = |(x, y)| self.place(x, y, shows(x, y)?);
        pixels.filter_map(place).map(cloud_point).collect()
    }
}

fn cloud_point(position_world: Point3<f64>) -> CloudPoint {
    CloudPoint { position_world, spread: Spread::Unknown }
}
