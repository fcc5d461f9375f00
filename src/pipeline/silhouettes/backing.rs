//! Whether depth backs a contour: the evidence for the body against that for nobody.
//!
//! Depth tells where somebody is without any edge: D, the pixels nearer than the still scene and about the body, without specks. The contour
//! tells it too: C, the pixels within. The backing of a view is how much of both is explained by the body,
//!
//! b = |{x ∈ C ∩ D : |r(x)| < ρ}| / |C ∪ D|,
//!
//! with r the skin distance of the point that x shows. Only pixels count that have a depth, away from where depth ends:
//! correlation by windows cannot tell there. Were nobody where the contour is, its pixels would show the still scene, C ∩ D
//! would be empty and b = 0. Below one half, more speaks against the body than for it. Where hardly anything in the whole picture is nearer
//! than the still scene, as of a person who never moves or of a single frame, the person is a part of that scene, and depth
//! cannot tell.

use nalgebra::Point2;

use super::ViewContours;
use super::ends::{nearness, where_depth_goes_on};
use super::filter::volume;
use super::moving::CLEAN_PX;
use super::still::StillScene;
use crate::body::Posed;
use crate::camera::Camera;
use crate::image::{Mask, opened};
use crate::likelihood::{PointField, PointOptions, SkinScale, SurfacePoint};
use crate::stereo::{CloudPoint, DepthMap};

/// Below this more speaks against a body than for it.
pub(super) const LEAST_BACKING: f64 = 0.5;
/// Depth about the body counts up to this distance from the box around it, m: half the reach of a body.
const ABOUT_M: f64 = 0.3;
/// A point lies on the skin within this distance, m: as for the points that are fitted to.
const ON_SKIN_M: f64 = 0.1;
/// Every so many pixels in the row and in the column one is looked at.
const EVERY_PX: usize = 2;
/// Of so many points the skin distance is looked at.
const MOST_POINTS: usize = 400;
/// Less than this share of the contour's pixels, an arm, are no person who stands out somewhere in the picture (E).
const LEAST_OUT: f64 = 0.1;
/// Of fewer pixels nothing can be said.
const LEAST_PIXELS: usize = 50;

/// One camera's depths and its still scene.
#[derive(Debug, Clone, Copy)]
pub(super) struct DepthView<'a> {
    pub(super) camera: &'a Camera,
    pub(super) map: &'a DepthMap,
    pub(super) still: &'a StillScene,
}

impl DepthView<'_> {
    /// How far depth backs the contours of a body, 0 to 1; `None` where too few depths are known to say.
    pub(super) fn backing(
        &self,
        contours: &ViewContours,
        body: &Posed<'_>,
        scale: &SkinScale,
    ) -> Option<f64> {
        let near = nearness(self.map);
        let (width, height) = (near.width(), near.height());
        let before = opened(&self.still.nearer(&near), CLEAN_PX);
        let sure = where_depth_goes_on(self.map, &Mask::from_fn(width, height, |_, _| true));
        let (inside, is_about) = (contours.inside(), volume(body, ABOUT_M));

        // pixel by pixel that has a depth
        let mut points = self.map.points.iter();
        let (mut either, mut both) = (0usize, Vec::<CloudPoint>::new());
        let (mut within, mut stands_out) = (0usize, 0usize);
        for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
            if !near.get(x, y).is_some_and(f32::is_finite) {
                continue;
            }
            let point = points.next()?;
            if x % EVERY_PX + y % EVERY_PX > 0 || !sure.is_foreground(x, y) {
                continue;
            }

            let is_somebody = before.is_foreground(x, y) && is_about(point);
            let is_in = inside.as_ref().is_some_and(|inside| {
                let pixel: Option<Point2<f64>> =
                    self.camera.project_undistorted(&point.position_world);
                pixel.is_some_and(|pixel| inside.contains(&pixel))
            });
            within += usize::from(is_in);
            stands_out += usize::from(before.is_foreground(x, y));
            either += usize::from(is_in || is_somebody);
            if is_in && is_somebody {
                both.push(*point);
            }
        }
        if either < LEAST_PIXELS || (stands_out as f64) < LEAST_OUT * within as f64 {
            return None;
        }

        // of those that both show, the ones on the skin
        let share = both.len() as f64 / either as f64;
        let step = both.len().div_ceil(MOST_POINTS).max(1);
        let places: Vec<SurfacePoint> = both.iter().step_by(step).map(SurfacePoint::from).collect();
        let count = places.len().max(1) as f64;
        let field = PointField::new(places, PointOptions::default(), scale.clone());
        let touches = field.residuals(body);
        let on_skin = touches.iter().filter(|touch| touch.residual_m.abs() < ON_SKIN_M).count();
        Some(share * on_skin as f64 / count)
    }
}
