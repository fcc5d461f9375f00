//! Which edges can be the person's: the gradient through a disparity mask and hysteresis (PF02 § 4.2, Fig. 5).

use nalgebra::Point2;

use super::ContourOptions;
use super::undistorted::UndistortedView;
use crate::body::Posed;
use crate::camera::Camera;
use crate::image::{Gradient, Mask, Plane, closed, opened, widened};
use crate::render::ModelOutline;
use crate::stereo::CloudPoint;

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
    pub fn find(view: &UndistortedView, options: &ContourOptions) -> Self {
        let (wide, narrow) = rayon::join(
            || Gradient::new(&view.colours, options.wide_px),
            || Gradient::new(&view.colours, options.narrow_px),
        );
        Self { wide, narrow }
    }
}

/// The edges that passed, and what they passed.
#[derive(Debug, Clone)]
pub struct FilteredEdges {
    /// Where edges count: the disparity mask, or the band of the prediction where there is no stereo.
    pub mask: Mask,
    /// The wide scale's edges that passed.
    pub(super) wide: Gradient,
    /// The narrow scale's.
    pub(super) narrow: Gradient,
    /// The narrow scale's upper threshold, grey levels per pixel; 0 of a flat picture.
    pub strong: f32,
}

impl FilteredEdges {
    /// The edges that lie on the mask and pass the hysteresis.
    pub fn select(edges: &Edges, mask: Mask, options: &ContourOptions) -> Self {
        let passed = |gradient: &Gradient| {
            let within = gradient.within(&mask);
            let high = quantile(&within.magnitude(), options.strong).max(options.flattest);
            (within.hysteresis(options.weak * high, high), high)
        };
        let (wide, _) = passed(&edges.wide);
        let (narrow, high) = passed(&edges.narrow);
        let is_flat = narrow.magnitude().values().iter().all(|m| *m <= 0.0);
        Self { mask, wide, narrow, strong: if is_flat { 0.0 } else { high } }
    }

    /// Strength of the edges that passed, for a picture.
    pub fn magnitude(&self) -> Plane<f32> {
        self.narrow.magnitude()
    }
}

/// A quantile of the values above 0; 0 without any.
fn quantile(plane: &Plane<f32>, share: f64) -> f32 {
    let mut values: Vec<f32> = plane.values().iter().copied().filter(|v| *v > 0.0).collect();
    let place = (share * (values.len() as f64 - 1.0)).max(0.0) as usize;
    if values.is_empty() {
        return 0.0;
    }
    *values.select_nth_unstable_by(place, f32::total_cmp).1
}

/// The pixels that show something at the depth of the working volume, binarised and cleaned.
///
/// The working volume is the box around the expected body and `volume_m` about it. The mask reaches a little beyond the near
/// pixels: the edge is at their border, and correlation blurs it.
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

/// Whether a point lies in the box around a body and `margin_m` about it; no point does if the body has no size.
pub(super) fn volume(body: &Posed<'_>, margin_m: f64) -> impl Fn(&CloudPoint) -> bool {
    let bounds = body.bounds();
    move |point| {
        let x = point.position_world.coords;
        bounds.is_some_and(|(low, high)| {
            (0..3).all(|k| (low[k] - margin_m..=high[k] + margin_m).contains(&x[k]))
        })
    }
}

/// A band around the expected outline, used where there is no disparity mask.
pub(super) fn band_mask(camera: &Camera, outline: &ModelOutline, half_px: f64) -> Mask {
    let curves = outline.outer.iter().chain(&outline.inner).flatten();
    widened(&marked(camera, curves.map(|p| p.pixel)), whole_px(half_px))
}

/// A radius in whole pixels.
pub(super) fn whole_px(radius: f64) -> u8 {
    radius.ceil().clamp(1.0, 250.0) as u8
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
