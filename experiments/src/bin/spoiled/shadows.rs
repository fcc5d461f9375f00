//! Shadows on the floor, drawn into masks.

use experiments::recorded::Recorded;
use maquette::camera::Camera;
use maquette::image::Mask;
use nalgebra::{Point2, Point3};
use rayon::prelude::*;

/// The lamp of a shadow that falls to a side.
const LAMP: Point3<f64> = Point3::new(2.5, 2.0, 4.0);
/// Half a limb's width, and how far the dark below a body reaches around a joint.
const LIMB_M: f64 = 0.1;
const DARK_M: f64 = 0.18;
/// Whose joints lie lower stands on them.
const LOW_M: f64 = 0.25;

/// A disk on the floor.
type Disk = (Point2<f64>, f64);

/// The shadow of all joints that a lamp casts, and of what lies between those that follow each other.
pub(crate) fn cast(joints: &[Point3<f64>]) -> Vec<Disk> {
    let on_floor = |joint: &Point3<f64>| {
        let far = LAMP.z / (LAMP.z - joint.z);
        ((LAMP + (joint - LAMP) * far).xy(), LIMB_M * far)
    };
    let between = joints.windows(2).flat_map(|pair| {
        let along = (0..8).map(|k| pair[0] + (pair[1] - pair[0]) * (f64::from(k) / 8.0));
        along.collect::<Vec<_>>()
    });
    between.map(|place| on_floor(&place)).collect()
}

/// The dark around what is near to the floor, as under a ceiling full of lamps.
pub(crate) fn around_feet(joints: &[Point3<f64>]) -> Vec<Disk> {
    joints.iter().filter(|joint| joint.z < LOW_M).map(|joint| (joint.xy(), DARK_M)).collect()
}

/// A recording with what a frame's joints darken in all masks.
pub(crate) fn darkened(r: &Recorded, dark: fn(&[Point3<f64>]) -> Vec<Disk>) -> Recorded {
    let floors: Vec<Vec<Option<Point2<f64>>>> = r.rig.cameras.par_iter().map(floor).collect();
    let disks = |frame: usize| {
        let joints = r.truth.frames.get(r.numbers[frame].0)?;
        Some(dark(&joints.iter().flatten().copied().collect::<Vec<_>>()))
    };
    let disks: Vec<Vec<Disk>> =
        (0..r.masks.len()).map(|frame| disks(frame).unwrap_or_default()).collect();
    let is_dark = |frame: usize, place: &Point2<f64>| {
        disks[frame].iter().any(|(middle, radius)| nalgebra::distance(middle, place) < *radius)
    };
    r.with_masks(|frame, camera, mask| {
        let width = mask.width();
        let shown = |x, y| {
            let on_floor = &floors[camera][y * width + x];
            mask.is_foreground(x, y) || on_floor.is_some_and(|place| is_dark(frame, &place))
        };
        Some(Mask::from_fn(width, mask.height(), shown))
    })
}

/// Where each pixel's line of sight meets the floor.
fn floor(camera: &Camera) -> Vec<Option<Point2<f64>>> {
    let rows = 0..camera.height_px;
    let pixels = rows.flat_map(|y| (0..camera.width_px).map(move |x| Point2::new(x, y)));
    let meets = |pixel: Point2<u32>| {
        let ray = camera.ray(&camera.undistort(&pixel.map(f64::from))?);
        Some(ray.point_at(ray.to_height(0.0)?).xy())
    };
    pixels.map(meets).collect()
}
