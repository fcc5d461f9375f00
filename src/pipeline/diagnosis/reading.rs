//! How the pictures of a camera are read: as they are, or as a hypothesis says.

use nalgebra::Point2;

use crate::camera::{Camera, CameraId};

/// How a picture was flipped before it was stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Flip {
    /// Left and right are exchanged.
    Mirrored,
    /// It is turned by half a turn, as that of a camera that hangs.
    UpsideDown,
}

impl Flip {
    pub(super) const ALL: [Self; 2] = [Self::Mirrored, Self::UpsideDown];

    /// Where a pixel goes, or comes from: each is its own inverse.
    fn of(self, camera: &Camera, pixel: Point2<f64>) -> Point2<f64> {
        let across = f64::from(camera.width_px) - 1.0 - pixel.x;
        let down = f64::from(camera.height_px) - 1.0 - pixel.y;
        match self {
            Self::Mirrored => Point2::new(across, pixel.y),
            Self::UpsideDown => Point2::new(across, down),
        }
    }
}

/// How the pictures of a camera are read.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Reading {
    /// The camera whose pictures these are.
    pub(super) camera: CameraId,
    /// By how many frames they are late.
    pub(super) late: isize,
    /// How they were flipped.
    pub(super) flip: Option<Flip>,
    /// The true focal length over the calibrated one.
    pub(super) zoom: f64,
}

impl Reading {
    /// As they are.
    pub(super) fn plain(camera: CameraId) -> Self {
        Self { camera, late: 0, flip: None, zoom: 1.0 }
    }

    /// Where the picture shows what the calibration puts at a pixel.
    pub(super) fn shown(&self, camera: &Camera, calibrated: Point2<f64>) -> Point2<f64> {
        let middle = principal_point(camera);
        self.flipped(camera, middle + (calibrated - middle) * self.zoom)
    }

    /// Where the calibration would put what the picture shows at a pixel.
    pub(super) fn calibrated(&self, camera: &Camera, shown: Point2<f64>) -> Point2<f64> {
        let middle = principal_point(camera);
        middle + (self.flipped(camera, shown) - middle) / self.zoom
    }

    fn flipped(&self, camera: &Camera, pixel: Point2<f64>) -> Point2<f64> {
        self.flip.map_or(pixel, |flip| flip.of(camera, pixel))
    }
}

fn principal_point(camera: &Camera) -> Point2<f64> {
    Point2::new(camera.intrinsics.cx_px, camera.intrinsics.cy_px)
}
