//! The cameras' calibration, and the outline that each saw in every frame.

use nalgebra::Point2;
use serde::{Serialize, Serializer};

use super::scene::base64_of_i16;
use crate::camera::Camera;
use crate::image::{Mask, Runs, resample, trace};

/// Steps per pixel in which outlines are stored.
const PER_PX: f64 = 4.0;
/// Points of an outline along the longer side of an image.
const POINTS_ALONG: f64 = 120.0;
/// Borders shorter than this share of the longer side are left out.
const SHORTEST: f64 = 0.05;

/// A camera without its distortion, and the outlines that it saw.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CameraOutlines {
    /// Its name.
    pub name: String,
    /// Width and height of its images.
    size_px: [u32; 2],
    /// fx, fy, cx, cy, skew.
    intrinsics_px: [f64; 5],
    /// Camera from world: rotation row by row, then translation.
    camera_from_world: [f64; 12],
    /// The closed lines that it saw in each frame: x, y, x, y, … of each line, quarter pixels.
    #[serde(serialize_with = "as_numbers")]
    outlines: Vec<Vec<Vec<i16>>>,
}

impl CameraOutlines {
    /// A camera and its outlines, frame by frame; empty for a frame without a mask.
    pub fn new(camera: &Camera, outlines: Vec<Vec<Vec<i16>>>) -> Self {
        let pose = &camera.camera_from_world;
        let (k, turn) = (&camera.intrinsics, pose.rotation.to_rotation_matrix());
        let camera_from_world = std::array::from_fn(|i| match i {
            0..9 => turn[(i / 3, i % 3)],
            _ => pose.translation.vector[i - 9],
        });

        Self {
            name: camera.name.clone(),
            size_px: [camera.width_px, camera.height_px],
            intrinsics_px: [k.fx_px, k.fy_px, k.cx_px, k.cy_px, k.skew_px],
            camera_from_world,
            outlines,
        }
    }
}

/// The borders of a mask in undistorted quarter pixels, thinned out.
pub fn outline_points(camera: &Camera, mask: &Mask) -> Vec<Vec<i16>> {
    let side = f64::from(camera.width_px.max(camera.height_px));
    let borders = trace(&Runs::from_mask(mask)).into_iter();
    let long = borders.filter(|border| border.len() as f64 > SHORTEST * side);
    let thinned = long.map(|border| resample(&border, side / POINTS_ALONG));
    thinned.map(|border| quarters(camera, &border)).collect()
}

fn quarters(camera: &Camera, border: &[Point2<f64>]) -> Vec<i16> {
    let straight = border.iter().filter_map(|p| camera.undistort(p));
    let quarter = |v: f64| (PER_PX * v).round().clamp(-32768.0, 32767.0) as i16;
    straight.flat_map(|p| [quarter(p.x), quarter(p.y)]).collect()
}

/// All outlines in one row of numbers: per frame the number of lines, per line its length and its numbers.
fn as_numbers<S: Serializer>(frames: &[Vec<Vec<i16>>], serializer: S) -> Result<S::Ok, S::Error> {
    let mut row = Vec::new();
    let count = |n: usize| i16::try_from(n).unwrap_or(i16::MAX);
    for lines in frames {
        row.push(count(lines.len()));
        for line in lines {
            row.push(count(line.len()));
            row.extend(&line[..usize::from(count(line.len()).unsigned_abs())]);
        }
    }
    serializer.serialize_str(&base64_of_i16(&row))
}
