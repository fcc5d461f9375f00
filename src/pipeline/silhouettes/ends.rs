//! Where depth ends: the borders of near things, as sharply as correlation by windows sees them.

use nalgebra::Point2;

use super::filter::{rounded, whole_px};
use crate::camera::{Camera, InfiniteHomography};
use crate::image::{Mask, Plane, widened};
use crate::stereo::DepthMap;

/// Depth ends where it changes by more than this within a window, px of disparity.
const ENDS_PX: f32 = 1.5;
/// Half that window, px: correlation finds borders to within this.
const ENDS_WITHIN_PX: usize = 4;

/// Disparities of a depth map from infinity: the larger, the nearer; NaN unknown.
pub(in crate::pipeline) fn nearness(map: &DepthMap) -> Plane<f32> {
    let infinity = map.pair.infinity() as f32;
    map.disparities.map(|d| (d - infinity).abs())
}

/// The pixels of a mask in which an edge can be a border: depth ends there, or nowhere within reach.
///
/// Clothes have edges beside the border that are as strong as the border, but depth goes on across them. Around a foot on
/// the floor depth ends nowhere: there any edge can be the border.
pub(super) fn where_depth_ends(
    mask: &Mask,
    camera: &Camera,
    map: &DepthMap,
    reach_px: f64,
) -> Mask {
    // where it ends, in the pixels of the rectified image
    let near = behind_filled(&nearness(map));
    let least = extreme(&near, f32::min);
    let most = extreme(&near, f32::max);

    // the same in the pixels of the camera
    let rectified = InfiniteHomography::new(camera, &map.pair.left.camera);
    let (width, height) = (mask.width(), mask.height());
    let ends = Mask::from_fn(width, height, |x, y| {
        let place = rectified.pixel(&Point2::new(x as f64, y as f64)).and_then(|p| rounded(&p));
        place.is_some_and(|(x, y)| {
            let range = most.get(x, y).zip(least.get(x, y));
            range.is_some_and(|(most, least)| most - least > ENDS_PX)
        })
    });

    let about = widened(&ends, whole_px(reach_px));
    Mask::from_fn(width, height, |x, y| {
        let can_be = ends.is_foreground(x, y) || !about.is_foreground(x, y);
        can_be && mask.is_foreground(x, y)
    })
}

/// The pixels of a rectified image with nothing farther beside them: correlation by windows makes near things too wide.
pub(super) fn where_depth_goes_on(map: &DepthMap, mask: &Mask) -> Mask {
    let near = nearness(map);
    let least = extreme(&behind_filled(&near), f32::min);
    Mask::from_fn(near.width(), near.height(), |x, y| {
        let range = near.get(x, y).zip(least.get(x, y));
        mask.is_foreground(x, y) && range.is_some_and(|(here, least)| here - least <= ENDS_PX)
    })
}

/// Fills unknown places with the farther of their neighbours in the row: beside near things, one camera sees what the
/// other does not.
fn behind_filled(nearness: &Plane<f32>) -> Plane<f32> {
    let mut filled = nearness.clone();
    for y in 0..filled.height() {
        let row = filled.row_mut(y);
        let mut start = 0;
        while start < row.len() {
            if row[start].is_finite() {
                start += 1;
                continue;
            }

            let known = row[start..].iter().position(|v| v.is_finite());
            let end = known.map_or(row.len(), |k| start + k);
            let left = start.checked_sub(1).map(|k| row[k]);
            let right = row.get(end).copied();

            let far = left.into_iter().chain(right).fold(f32::NAN, f32::min);
            row[start..end].fill(far);
            start = end;
        }
    }
    filled
}

/// The least or the greatest of every window.
fn extreme(plane: &Plane<f32>, of: impl Fn(f32, f32) -> f32) -> Plane<f32> {
    let (width, height) = (plane.width(), plane.height());

    // first along the rows, with unknown places at both ends
    let mut along = Plane::filled(width, height, f32::NAN);
    let mut row = vec![f32::NAN; width + 2 * ENDS_WITHIN_PX];
    for y in 0..height {
        row[ENDS_WITHIN_PX..ENDS_WITHIN_PX + width].copy_from_slice(plane.row(y));
        for shift in 0..=2 * ENDS_WITHIN_PX {
            widen(along.row_mut(y), &row[shift..], &of);
        }
    }

    // then across them
    let mut both = Plane::filled(width, height, f32::NAN);
    for y in 0..height {
        for other in y.saturating_sub(ENDS_WITHIN_PX)..(y + ENDS_WITHIN_PX + 1).min(height) {
            widen(both.row_mut(y), along.row(other), &of);
        }
    }
    both
}

fn widen(row: &mut [f32], other: &[f32], of: impl Fn(f32, f32) -> f32) {
    for (value, other) in row.iter_mut().zip(other) {
        *value = of(*value, *other);
    }
}

#[cfg(test)]
mod tests {
    use super::super::still::tests::depth_map;
    use super::*;

    #[test]
    fn beside_the_end_of_depth_only_its_edges_count_and_far_from_any_all_do() {
        // near on the left of column 15; what is just right of it only one camera sees
        let map = depth_map(|x, _| match x {
            0..15 => 20.0,
            15..18 => f32::NAN,
            _ => 5.0,
        });
        let camera = &map.pair.left.camera;
        let all = Mask::from_fn(40, 30, |_, _| true);
        let counts = where_depth_ends(&all, camera, &map, 8.0);
        let columns: Vec<usize> = (0..40).filter(|x| counts.is_foreground(*x, 15)).collect();
        let expected: Vec<usize> = (0..3).chain(11..19).chain(27..40).collect();
        assert_eq!(columns, expected);
        let none = Mask::from_fn(40, 30, |_, _| false);
        assert_eq!(where_depth_ends(&none, camera, &map, 8.0), none);
    }

    #[test]
    fn what_is_near_is_relied_on_a_window_away_from_its_end_and_a_slope_everywhere() {
        let all = Mask::from_fn(40, 30, |_, _| true);
        let columns = |disparity: fn(usize) -> f32| -> Vec<usize> {
            let goes_on = where_depth_goes_on(&depth_map(|x, _| disparity(x)), &all);
            (0..40).filter(|x| goes_on.is_foreground(*x, 15)).collect()
        };
        let step = columns(|x| if (10..30).contains(&x) { 20.0 } else { 5.0 });
        let expected: Vec<usize> = (0..10).chain(14..26).chain(30..40).collect();
        assert_eq!(step, expected);
        let slope = columns(|x| 5.0 + 0.3 * x as f32);
        assert_eq!(slope, (0..40).collect::<Vec<_>>());
    }
}
