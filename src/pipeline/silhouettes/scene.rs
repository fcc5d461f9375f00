//! One frame as the pipelines see it: its edges, its depths, and the contours of a body that they give.

use nalgebra::Point3;
use rayon::prelude::*;

use super::absent::absent_parts;
use super::backing::{DepthView, LEAST_BACKING};
use super::contour::{ViewContours, px_per_m};
use super::ends::where_depth_ends;
use super::filter::{Edges, FilteredEdges, band_mask, disparity_mask, volume};
use super::moving::{MOST_POINTS, thinned};
use super::still::StillScenes;
use super::undistorted::UndistortedFrame;
use super::{ContourFault, ContourOptions, ViewSighting};
use crate::body::{PartId, Posed};
use crate::camera::{Camera, CameraId, Rig};
use crate::likelihood::{PointField, PointOptions, SkinScale, SurfacePoint};
use crate::render::{ModelOutline, outline};
use crate::silhouette::{FrameIndex, FrameObservations};
use crate::stereo::{CloudPoint, DepthMap};

/// One frame's pictures with their edges and depths.
#[derive(Debug)]
pub struct Scene<'a> {
    rig: &'a Rig,
    shown: &'a UndistortedFrame,
    still: &'a StillScenes,
    depths: Vec<Option<DepthMap>>,
    /// Of each camera, the points that can be the person's.
    points: Vec<Vec<CloudPoint>>,
    edges: Vec<Option<Edges>>,
    options: ContourOptions,
}

/// What a frame shows of a body.
#[derive(Debug)]
pub struct FrameSighting {
    /// The contours of its outline, in the order of the rig.
    pub views: Vec<Option<ViewSighting>>,
    /// Silhouettes and points.
    pub observed: FrameObservations,
    /// The parts of the body that are not where it has them: depth shows what stands behind.
    pub absent: Vec<PartId>,
}

impl FrameSighting {
    /// The least [`ViewSighting::backing`] of its views; `None` where no depth is seen.
    pub fn least_backing(&self) -> Option<f64> {
        let backings = self.views.iter().flatten().filter_map(|view| view.backing);
        backings.min_by(f64::total_cmp)
    }

    /// Whether depth backs the contours in most of the views in which it can tell; `None` where it can in none.
    pub fn is_backed(&self) -> Option<bool> {
        let backings = || self.views.iter().flatten().filter_map(|view| view.backing);
        let (all, good) =
            (backings().count(), backings().filter(|backing| *backing >= LEAST_BACKING).count());
        (all > 0).then_some(2 * good > all)
    }
}

/// Depth is looked for so far in front of and behind the body, m: what stands beside it must not be taken for it.
const BEYOND_M: f64 = 0.6;
/// Least depth that is looked for, m.
const NEAREST_M: f64 = 0.3;

impl<'a> Scene<'a> {
    /// Looks for edges, and for depths around the expected body; a camera with no other beside it has no depths.
    ///
    /// Where still scenes are known, points come from their cameras alone, and only from in front of them: else the body
    /// would be fitted to the floor or a chair near a foot.
    pub fn new(
        rig: &'a Rig,
        shown: &'a UndistortedFrame,
        still: &'a StillScenes,
        body: &Posed<'_>,
        options: ContourOptions,
    ) -> Self {
        let views = shown.views.par_iter();
        let edges = views.map(|view| Some(Edges::find(view.as_ref()?, &options)));

        let cameras = rig.cameras.par_iter().enumerate();
        let depths = cameras.map(|(i, camera)| {
            let range = depths_of(camera, body);
            shown.depth(rig, CameraId(i), range)
        });
        let depths: Vec<Option<DepthMap>> = depths.collect();

        let points = depths.iter().enumerate();
        let points = points.map(|(i, depth)| match (depth, still.get(CameraId(i))) {
            (Some(depth), Some(still)) => still.before(depth),
            (Some(depth), None) if still.is_empty() => depth.points.clone(),
            _ => Vec::new(),
        });
        Self {
            edges: edges.collect(),
            points: points.collect(),
            depths,
            rig,
            shown,
            still,
            options,
        }
    }

    /// The contours of an expected body in every view, in the order of the rig; `None` where there is no picture.
    fn contours(&self, body: &Posed<'_>, scale: &SkinScale) -> Vec<Option<ViewSighting>> {
        let cameras = self.rig.cameras.par_iter().enumerate();
        let seen = cameras.map(|(i, camera)| {
            let view = self.shown.views.get(i)?.as_ref()?;
            let expected = outline(&view.grey.camera, body, self.options.outline_px);
            let filtered = self.filtered(i, body, &expected)?;
            let (colours, options) = (&view.colours, &self.options);
            let mut contours = ViewContours::settle(camera, &expected, &filtered, colours, options);
            let depths = self.depths.get(i)?.as_ref().zip(self.still.get(CameraId(i)));
            let backing = depths.and_then(|(map, still)| {
                DepthView { camera, map, still }.backing(&contours, body, scale)
            });
            if let Some(backing) = backing.filter(|backing| *backing < LEAST_BACKING) {
                contours.distrust(ContourFault::Unbacked { percent: 100.0 * backing });
            }
            Some(ViewSighting { contours, filtered, backing })
        });
        seen.collect()
    }

    /// The edges of a view that can be the body's.
    fn filtered(
        &self,
        i: usize,
        body: &Posed<'_>,
        expected: &ModelOutline,
    ) -> Option<FilteredEdges> {
        let (camera, edges) = (&self.rig.cameras[i], self.edges.get(i)?.as_ref()?);
        let reach_px = self.options.search_m * px_per_m(camera, expected);
        let mask = match &self.depths.get(i).and_then(Option::as_ref) {
            Some(depth) => {
                let near = disparity_mask(camera, &depth.points, body, &self.options);
                where_depth_ends(&near, camera, depth, reach_px)
            }
            None => band_mask(camera, expected, reach_px),
        };
        Some(FilteredEdges::select(edges, mask, &self.options))
    }

    /// The points that lie near the skin of a body.
    fn points_near(&self, body: &Posed<'_>, scale: &SkinScale) -> Vec<CloudPoint> {
        let near_m = self.options.near_m;
        let is_in = volume(body, near_m);
        let inside = self.points.iter().flatten().filter(|p| is_in(p)).copied();
        let some = thinned(inside.collect(), 2 * MOST_POINTS);
        let places = some.iter().map(SurfacePoint::from).collect();
        let field = PointField::new(places, PointOptions::default(), scale.clone());
        let near = some.into_iter().zip(field.residuals(body));
        let near = near.filter(|(_, touch)| touch.residual_m.abs() < near_m);
        thinned(near.map(|(point, _)| point).collect(), MOST_POINTS)
    }

    /// What the frame shows of an expected body: contours, and the silhouettes and points that it can be fitted to.
    pub fn sighting(
        &self,
        frame: FrameIndex,
        body: &Posed<'_>,
        scale: &SkinScale,
    ) -> FrameSighting {
        let mut views = self.contours(body, scale);
        let absent = absent_parts(self.depths.iter().flatten(), body);
        if !absent.is_empty() {
            self.distrust(&mut views, &absent, body);
        }

        let silhouettes = views.iter().enumerate().filter_map(|(i, seen)| {
            let silhouette = seen.as_ref()?.contours.silhouette.clone()?;
            Some((CameraId(i), silhouette))
        });
        let observed = FrameObservations {
            views: silhouettes.collect(),
            points: self.points_near(body, scale),
            ..FrameObservations::nothing(frame)
        };
        FrameSighting { views, observed, absent }
    }

    /// Takes it that some parts are elsewhere than the body has them.
    fn distrust(&self, views: &mut [Option<ViewSighting>], absent: &[PartId], body: &Posed<'_>) {
        let names = absent.iter().map(|part| body.model.parts[part.0].name.as_str());
        let parts = names.collect::<Vec<_>>().join(", ");
        for (seen, camera) in views.iter_mut().zip(&self.rig.cameras) {
            if let Some(seen) = seen {
                let fault = ContourFault::SeenThrough { parts: parts.clone() };
                seen.contours.distrust_parts(absent, fault, camera);
            }
        }
    }
}

/// Least and greatest depth that is looked for, m; `None` for a body that has no size.
fn depths_of(camera: &Camera, body: &Posed<'_>) -> Option<(f64, f64)> {
    let (low, high) = body.bounds()?;
    let corner = |k: usize| {
        let axis = |i: usize| if k >> i & 1 == 0 { low[i] } else { high[i] };
        (camera.camera_from_world * Point3::new(axis(0), axis(1), axis(2))).z
    };
    let depths = (0..8).map(corner);
    let (near, far) = depths.fold((f64::MAX, f64::MIN), |(n, f), z| (n.min(z), f.max(z)));
    let near = (near - BEYOND_M).max(NEAREST_M);
    Some((near, (far + BEYOND_M).max(2.0 * near)))
}
