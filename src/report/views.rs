//! The cameras' calibration, and the outline that each saw in every frame.

use nalgebra::{Point2, Vector2};
use serde::{Serialize, Serializer};

use super::picture::{FramePicture, ImagePart};
use super::scene::base64_of_i16;
use crate::camera::Camera;
use crate::image::{Mask, Runs, resample, trace};

/// Steps per pixel in which outlines are stored.
const PER_PX: f64 = 4.0;
/// Points of an outline along the longer side of an image.
const POINTS_ALONG: f64 = 120.0;
/// Borders shorter than this share of the longer side are left out.
const SHORTEST: f64 = 0.05;
/// Half the size of the mark on a detected joint, over the longer side of an image.
const MARK: f64 = 0.006;
/// Width and height of what is shown over those of the outline.
const MARGIN: f64 = 1.2;
/// Least width of what is shown over its height.
const NARROWEST: f64 = 0.7;

/// What the cameras saw.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Views {
    /// Camera by camera; empty if the recording is not at hand.
    pub cameras: Vec<CameraOutlines>,
    /// Every so many frames have pictures; 0 if none has.
    pub every: usize,
}

impl Views {
    /// Whether recorded pictures are shown.
    pub(super) fn has_pictures(&self) -> bool {
        self.cameras.iter().any(|camera| !camera.pictures.is_empty())
    }
}

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
    /// What was recorded under them.
    pub pictures: Vec<FramePicture>,
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
            pictures: Vec::new(),
        }
    }

    /// The part of the image around the person, `frame` frames after the first: as large in all frames, and within the
    /// image; `None` where nobody was seen.
    pub fn part(&self, frame: usize) -> Option<ImagePart> {
        let boxes = self.outlines.iter().filter_map(|lines| bounds(lines));
        let (width, height) = boxes.fold((0.0_f64, 0.0_f64), |(width, height), (least, most)| {
            (width.max(most[0] - least[0]), height.max(most[1] - least[1]))
        });
        let height = MARGIN * height;
        let half = [0.5 * (MARGIN * width).max(NARROWEST * height), 0.5 * height];

        let (least, most) = bounds(self.outlines.get(frame)?)?;
        let end = |k: usize, sign: f64| {
            let place = 0.5 * (least[k] + most[k]) + sign * half[k];
            place.round().clamp(0.0, f64::from(self.size_px[k])) as usize
        };
        let [[left, top], [right, bottom]] = [-1.0, 1.0].map(|sign| [end(0, sign), end(1, sign)]);
        let part = ImagePart { left, top, width: right - left, height: bottom - top };
        (part.width > 0 && part.height > 0).then_some(part)
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

/// A small diamond about each joint that was detected, undistorted pixels, in place of an outline.
pub fn joint_marks(camera: &Camera, joints_px: &[Point2<f64>]) -> Vec<Vec<i16>> {
    let half = MARK * f64::from(camera.width_px.max(camera.height_px));
    let corners = [[half, 0.0], [0.0, half], [-half, 0.0], [0.0, -half]].map(Vector2::from);
    let mark = |joint: &Point2<f64>| in_quarters(corners.iter().map(move |corner| joint + corner));
    joints_px.iter().map(mark).collect()
}

fn quarters(camera: &Camera, border: &[Point2<f64>]) -> Vec<i16> {
    in_quarters(border.iter().filter_map(|p| camera.undistort(p)))
}

fn in_quarters(points: impl Iterator<Item = Point2<f64>>) -> Vec<i16> {
    let quarter = |v: f64| (PER_PX * v).round().clamp(-32768.0, 32767.0) as i16;
    points.flat_map(|p| [quarter(p.x), quarter(p.y)]).collect()
}

/// The least and the greatest x and y of lines in quarter pixels, px.
fn bounds(lines: &[Vec<i16>]) -> Option<([f64; 2], [f64; 2])> {
    let of = |k: usize| {
        let values = lines.iter().flat_map(move |line| line.iter().skip(k).step_by(2));
        let px = |v: &i16| f64::from(*v) / PER_PX;
        Some((px(values.clone().min()?), px(values.max()?)))
    };
    let ((left, right), (top, bottom)) = (of(0)?, of(1)?);
    Some(([left, top], [right, bottom]))
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::{Distortion, Intrinsics};
    use crate::math::Rigid3;

    #[test]
    fn the_part_around_the_person_goes_with_the_outline_and_stays_in_the_image() {
        let intrinsics =
            Intrinsics { fx_px: 100.0, fy_px: 100.0, cx_px: 50.0, cy_px: 50.0, skew_px: 0.0 };
        let camera = Camera {
            name: "a".into(),
            width_px: 200,
            height_px: 100,
            intrinsics,
            distortion: Distortion::None,
            camera_from_world: Rigid3::identity(),
        };
        let quarters = |px: [i16; 4]| vec![px.map(|v| 4 * v).to_vec()];
        let outlines = vec![quarters([80, 20, 120, 70]), quarters([0, 20, 20, 70]), Vec::new()];
        let view = CameraOutlines::new(&camera, outlines);
        // 1.2 of the largest outline: 48 by 60
        let middle = ImagePart { left: 76, top: 15, width: 48, height: 60 };
        assert_eq!(view.part(0), Some(middle));
        assert_eq!(view.part(1), Some(ImagePart { left: 0, top: 15, width: 34, height: 60 }));
        assert_eq!((view.part(2), view.part(9)), (None, None));
    }
}
