//! Where the person is, from first masks.

use nalgebra::{Point2, Point3, Vector3};

use crate::camera::{Ray, Rig, closest_point};
use crate::image::Plane;
use crate::silhouette::{ShrunkSize, Volume};

/// Half the sides of the box about a person's middle, metres: an arm's reach, and a little more than half of the height.
const REACH: [f64; 3] = [1.3, 1.3, 1.5];
/// Lines of sight through one person's middle pass each other within this, metres.
const MISS: f64 = 0.5;

/// The box in which the person moves, from the masks of some frames; `None` if no two cameras agree on where that is in any frame.
pub(super) fn volume<'a>(
    rig: &Rig,
    shrunk: &[ShrunkSize],
    frames: impl Iterator<Item = &'a [Option<Plane<u8>>]>,
) -> Option<Volume> {
    let places: Vec<Point3<f64>> = frames.filter_map(|masks| place(rig, shrunk, masks)).collect();
    let middle = |axis: usize| {
        let mut values: Vec<f64> = places.iter().map(|place| place[axis]).collect();
        values.sort_by(f64::total_cmp);
        values.get(values.len() / 2).copied()
    };
    let middle = Point3::new(middle(0)?, middle(1)?, middle(2)?);
    // a mask of something else, far away, must not blow up the box
    let height = Vector3::new(0.0, 0.0, 1.0);
    let near = places.iter().filter(|place| (*place - middle).dot(&height).abs() < 1.0);
    volume_about(&near.copied().collect::<Vec<_>>())
}

/// The box about people whose middles are at these places; `None` without any.
pub(super) fn volume_about(middles: &[Point3<f64>]) -> Option<Volume> {
    let bound = |axis: usize, sign: f64| {
        let ends = middles.iter().map(|place| sign * place[axis]).reduce(f64::max)?;
        Some(sign * (ends + REACH[axis]))
    };
    let corner = |sign: f64| Some(Point3::new(bound(0, sign)?, bound(1, sign)?, bound(2, sign)?));
    Some(Volume { low: corner(-1.0)?, high: corner(1.0)? })
}

/// Where the lines of sight through the masks' middles meet; the camera that is most beside the point is left out once
/// there are three or more.
fn place(rig: &Rig, shrunk: &[ShrunkSize], masks: &[Option<Plane<u8>>]) -> Option<Point3<f64>> {
    let mut rays: Vec<Ray> = rig
        .cameras
        .iter()
        .zip(shrunk)
        .zip(masks)
        .filter_map(|((camera, shrunk), mask)| {
            let middle = middle(mask.as_ref()?)?;
            let recorded = (middle.coords.add_scalar(0.5) * shrunk.factor as f64).add_scalar(-0.5);
            Some(camera.ray(&camera.undistort(&Point2::from(recorded))?))
        })
        .collect();

    loop {
        let place = closest_point(&rays)?;
        let misses = rays.iter().map(|ray| ray.distance_to(&place));
        let (worst, miss) = misses.enumerate().max_by(|a, b| a.1.total_cmp(&b.1))?;
        if miss < MISS {
            return Some(place);
        }
        rays.remove(worst);
    }
}

/// Mean place of the pixels of a mask.
fn middle(mask: &Plane<u8>) -> Option<Point2<f64>> {
    let (mut x_sum, mut y_sum, mut count) = (0.0, 0.0, 0.0);
    for y in 0..mask.height() {
        for (x, _) in mask.row(y).iter().enumerate().filter(|(_, value)| **value == 1) {
            x_sum += x as f64;
            y_sum += y as f64;
            count += 1.0;
        }
    }
    (count > 0.0).then(|| Point2::new(x_sum / count, y_sum / count))
}
