//! Which edges can be the person's: the gradient through a disparity mask and hysteresis (PF02 § 4.2, Fig. 5).

use nalgebra::Point2;

use super::ContourOptions;
use super::shown::ShownView;
use super::still::nearness;
use crate::body::Posed;
use crate::camera::Camera;
use crate::image::{Gradient, Mask, Plane, closed, opened, widened};
use crate::render::ModelOutline;
use crate::stereo::{CloudPoint, DepthMap};

/// Depth ends where it changes by more than this within a window, px of disparity.
const ENDS_PX: f32 = 1.5;
/// Half that window, px: correlation finds borders to so much.
const ENDS_WITHIN_PX: usize = 4;

/// Gradients of one view at both scales, before the mask.
#[derive(Debug, Clone)]
pub struct Edges {
    /// At the wide scale: seen from afar.
    pub(super) wide: Gradient,
    /// At the narrow scale: in place.
    pub(super) narrow: Gradient,
}

impl Edges {
    /// The edges of a view.
    pub fn of(view: &ShownView, options: &ContourOptions) -> Self {
        let (wide, narrow) = rayon::join(
            || Gradient::of(&view.colours, options.wide_px),
            || Gradient::of(&view.colours, options.narrow_px),
        );
        Self { wide, narrow }
    }
}

/// The edges that passed, and the steps to them.
#[derive(Debug, Clone)]
pub struct Filtered {
    /// Where edges count: the disparity mask, or the band of the prediction where there is no stereo.
    pub mask: Mask,
    /// The wide scale's edges that passed.
    pub(super) wide: Gradient,
    /// The narrow scale's.
    pub(super) narrow: Gradient,
    /// The narrow scale's upper threshold, grey levels per pixel; 0 of a flat picture.
    pub strong: f32,
}

impl Filtered {
    /// What of the edges lies on the mask and passes the hysteresis.
    pub fn of(edges: &Edges, mask: Mask, options: &ContourOptions) -> Self {
        let passed = |gradient: &Gradient| {
            let within = gradient.within(&mask);
            let high = quantile(&within.magnitude(), options.strong).max(options.flattest);
            (within.hysteresis(options.weak * high, high), high)
        };
        let (wide, _) = passed(&edges.wide);
        let (narrow, high) = passed(&edges.narrow);
        let is_flat = narrow.magnitude().values().iter().all(|m| *m <= 0.0);
        Self {
            mask,
            wide,
            narrow,
            strong: if is_flat { 0.0 } else { high },
        }
    }

    /// Strength of the edges that passed, for a picture.
    pub fn magnitude(&self) -> Plane<f32> {
        self.narrow.magnitude()
    }
}

/// A quantile of what is not 0; 0 of nothing.
fn quantile(plane: &Plane<f32>, share: f64) -> f32 {
    let mut values: Vec<f32> = plane
        .values()
        .iter()
        .copied()
        .filter(|v| *v > 0.0)
        .collect();
    let place = (share * (values.len() as f64 - 1.0)).max(0.0) as usize;
    if values.is_empty() {
        return 0.0;
    }
    *values.select_nth_unstable_by(place, f32::total_cmp).1
}

/// The pixels that show something at the depth of the working volume, binarised and cleaned.
///
/// The working volume is that of the body where it is expected, and `volume_m` around it. The mask reaches a little beyond what
/// is near, for the edge is at its border and correlation blurs it.
pub fn disparity_mask(
    camera: &Camera,
    points: &[CloudPoint],
    body: &Posed<'_>,
    options: &ContourOptions,
) -> Mask {
    let is_in = volume(body, options.volume_m);
    let near = points.iter().filter(|p| is_in(p));
    let pixels = near.filter_map(|p| camera.project_undistorted(&p.position_world));
    let mask = marked(camera, pixels);
    let radius = options.clean_px;
    widened(&opened(&closed(&mask, radius), radius), options.reach_px)
}

/// Of the pixels of a mask those where an edge can be a border, as far as depth tells: where depth ends, or ends nowhere within reach.
///
/// Edges of what a person wears lie beside the border as well and are as strong; but there depth goes on. A foot on the floor has no end of
/// depth, and any edge can be its border.
pub(super) fn where_depth_ends(
    mask: &Mask,
    camera: &Camera,
    map: &DepthMap,
    reach_px: f64,
) -> Mask {
    let near = behind_filled(&nearness(map));
    let (width, height) = (near.width(), near.height());
    let least = extreme(&near, f32::min);
    let most = extreme(&near, f32::max);
    let rectified = &map.pair.left.camera;
    let ends = Mask::from_fn(width, height, |x, y| {
        let ray = camera.ray(&Point2::new(x as f64, y as f64));
        let seen = rectified.project_undistorted(&ray.point_at(1.0));
        let place = seen.and_then(|p| rounded(&p));
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

/// What is not known, as far as the farther of its neighbours in the row: beside what is near, one camera sees what the other does not.
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
fn extreme(plane: &Plane<f32>, of: fn(f32, f32) -> f32) -> Plane<f32> {
    let (width, height) = (plane.width(), plane.height());
    let window = |at: usize, size: usize| {
        at.saturating_sub(ENDS_WITHIN_PX)..(at + ENDS_WITHIN_PX + 1).min(size)
    };
    let mut along = plane.clone();
    let mut both = plane.clone();
    for y in 0..height {
        let from = plane.row(y);
        for (x, value) in along.row_mut(y).iter_mut().enumerate() {
            *value = from[window(x, width)].iter().copied().fold(f32::NAN, of);
        }
    }
    for y in 0..height {
        let row = both.row_mut(y);
        row.fill(f32::NAN);
        for k in window(y, height) {
            for (value, other) in row.iter_mut().zip(along.row(k)) {
                *value = of(*value, *other);
            }
        }
    }
    both
}

/// Whether a point lies in the box around a body and `margin_m` about it; none does of a body without size.
pub(super) fn volume(body: &Posed<'_>, margin_m: f64) -> impl Fn(&CloudPoint) -> bool {
    let bounds = body.bounds();
    move |point| {
        let x = point.position_world.coords;
        bounds.is_some_and(|(low, high)| {
            (0..3).all(|k| (low[k] - margin_m..=high[k] + margin_m).contains(&x[k]))
        })
    }
}

/// The band around an expected outline, in the place of a disparity mask.
pub fn band_mask(camera: &Camera, outline: &ModelOutline, half_px: f64) -> Mask {
    let curves = outline.outer.iter().chain(&outline.inner).flatten();
    around(camera, curves.map(|p| p.pixel), whole_px(half_px))
}

/// A radius in whole pixels.
fn whole_px(radius: f64) -> u8 {
    radius.ceil().clamp(1.0, 250.0) as u8
}

/// The pixels of an image that are not farther from some places than `half_px`.
pub(super) fn around(
    camera: &Camera,
    places: impl Iterator<Item = Point2<f64>>,
    half_px: u8,
) -> Mask {
    widened(&marked(camera, places), half_px)
}

/// The pixels of an image at some places.
fn marked(camera: &Camera, places: impl Iterator<Item = Point2<f64>>) -> Mask {
    let (width, height) = (camera.width_px as usize, camera.height_px as usize);
    let mut marked = Plane::filled(width, height, 0u8);
    for (x, y) in places.filter_map(|p| rounded(&p)) {
        if let Some(value) = marked.row_mut(y).get_mut(x) {
            *value = 1;
        }
    }
    Mask::brighter_than(&marked, 0)
}

pub(super) fn rounded(pixel: &Point2<f64>) -> Option<(usize, usize)> {
    let is_there = pixel.x > -0.5 && pixel.y > -0.5;
    is_there.then(|| (pixel.x.round() as usize, pixel.y.round() as usize))
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
}
