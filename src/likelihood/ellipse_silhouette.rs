//! Border pixels against the outlines of the projected ellipsoids (ZS06, App. C).
//!
//! *Published*: each border pixel's residual is its distance to the nearest ellipse
//! (`docs/ellipse-distance.md` derives it and lists what differs from the appendix).
//!
//! *Outline*: the published measure punishes neither a limb that sticks out of the silhouette nor a border
//! pixel that lies inside the model. So, forwards, the residual is the signed distance to the outline of
//! the **union**, min dᵢ, as the smooth minimum −τ ln Σ exp(−dᵢ/τ). And, back, samples of every ellipse's
//! own outline shall lie inside the mask: their residual is the mask's distance transform there. (A
//! sample hidden in another ellipse must lie inside the mask too, so no visibility is needed.)
//!
//! The joint optimum does not look at border pixels in folds of the skin (`folds.rs`).
//!
//! A border pixel has the variance σ² = σ_px² + (σ_m·f/z)²: that of the segmentation, and the ellipsoids' own mismatch
//! with a body. Neighbouring pixels err together: the weight of a row is its length over the correlation length.

use nalgebra::{Matrix3x4, SVector, Vector2, Vector3};

use super::clear::{self, Divided};
use super::ellipse_distance::{EllipseDistance, OutlineEllipse};
use super::ellipse_sums::EllipseSums;
use super::ellipse_view::EllipseView;
use super::ellipsoid_surface::EllipsoidSurface;
use super::folds::EllipsoidFolds;
use super::offset_row::OffsetRow;
use super::shared_border::{SharedBorder, WITHIN};
use super::union::{NearEllipses, nearest, smooth_union};
use super::{Clear, PlacedResidual, Source, Term};
use crate::body::{EllipsoidJacobians, Layout, PartId, Posed};
use crate::math::quadric::{Ellipsoid, ProjectionJacobian, project, project_with_jacobian};
use crate::solver::{Loss, NormalEquations};

/// Which measure.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Variant {
    /// ZS06, App. C: distance to the nearest ellipse.
    Published,
    /// Signed distance to the union, and back.
    Outline,
}

/// Settings of the ellipse likelihood.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct EllipseOptions {
    /// Which measure.
    pub variant: Variant,
    /// Which point–ellipse distance; the published variant uses the published one.
    pub distance: EllipseDistance,
    /// σ_px: standard deviation of a border pixel, px.
    pub sigma_px: f64,
    /// σ_m: standard deviation of the body's surface about the ellipsoids, m.
    pub sigma_m: f64,
    /// Length along the border over which errors go together, m.
    pub correlation_m: f64,
    /// τ: width of the smooth minimum, m.
    pub blend_m: f64,
    /// Robust loss of forward and back residuals, in standard deviations.
    pub loss: Loss,
    /// Samples of each ellipse's outline; 0 leaves the back term out.
    pub back_samples: usize,
}

impl Default for EllipseOptions {
    fn default() -> Self {
        Self {
            variant: Variant::Outline,
            distance: EllipseDistance::Gradient,
            sigma_px: 1.0,
            sigma_m: 0.01,
            correlation_m: 0.1,
            blend_m: 0.003,
            loss: Loss::Cauchy(3.0),
            back_samples: 16,
        }
    }
}

impl EllipseOptions {
    /// ZS06's own measure (App. C).
    pub fn published() -> Self {
        Self {
            variant: Variant::Published,
            distance: EllipseDistance::Published,
            back_samples: 0,
            ..Self::default()
        }
    }
}

/// −log p(silhouettes | m, s) of one frame.
#[derive(Debug, Clone)]
pub struct EllipseSilhouette<'a> {
    views: Vec<EllipseView<'a>>,
    options: EllipseOptions,
    /// (sin, cos) of the samples of every ellipse's outline.
    circle: Vec<(f64, f64)>,
}

impl<'a> EllipseSilhouette<'a> {
    /// The term of one frame's views.
    pub fn new(views: Vec<EllipseView<'a>>, options: EllipseOptions) -> Self {
        let turn = std::f64::consts::TAU / options.back_samples as f64;
        let circle = (0..options.back_samples).map(|k| (turn * k as f64).sin_cos()).collect();
        Self { views, options, circle }
    }

    /// Only some of each view's border points.
    fn only(&self, points: &[Vec<usize>]) -> Self {
        let views = self.views.iter().zip(points).map(|(view, points)| view.only(points)).collect();
        Self { views, options: self.options, circle: self.circle.clone() }
    }

    /// Number of border points in all views.
    pub fn border_points(&self) -> usize {
        self.views.iter().map(EllipseView::len).sum()
    }

    fn sigma_px(&self, view: &EllipseView<'_>) -> f64 {
        self.options.sigma_px.hypot(self.options.sigma_m * view.px_per_m)
    }

    /// Calls `row(residual/σ, weight, derivatives by ellipse, by offset)` for every residual of a view.
    fn rows(
        &self,
        view: &EllipseView<'_>,
        ellipses: &[Option<OutlineEllipse>],
        body: &PlacedBody<'_>,
        mut row: impl FnMut(f64, f64, &[(usize, SVector<f64, 5>)], Option<&OffsetRow>),
    ) {
        let precision = 1.0 / self.sigma_px(view);
        let per_m = precision * view.px_per_m;
        let surface = body.surface.as_ref();

        // forwards: from the border to the model
        let mut near = NearEllipses::new();
        let points = view.points.iter().zip(&view.rays);
        for ((x, ray), length_px) in points.zip(&view.lengths_px) {
            let Some(d) = self.distance(view, ellipses, x, &mut near) else { continue };
            let weight = length_px / (view.px_per_m * self.options.correlation_m);
            let offset = surface.and_then(|surface| surface.offset(near.most()?, ray));
            let offset = offset.map(|b| OffsetRow::new(&b, body.layout, -per_m));
            let beyond = offset.map_or(0.0, |b| b.value);

            for (_, slope) in &mut near.slopes {
                *slope *= precision;
            }
            row(d * precision + beyond, weight, &near.slopes, offset.as_ref());
        }

        // back: from the model to the mask
        for (i, ellipse) in ellipses.iter().enumerate() {
            let Some(ellipse) = ellipse else { continue };
            let weight = body.girths_m[i] / (self.circle.len() as f64 * self.options.correlation_m);
            for &(sin, cos) in &self.circle {
                let x = ellipse.centre + ellipse.root * Vector2::new(cos, sin);
                let (d, slope) = view.outside.sample(&x.into());
                if d <= 0.0 {
                    continue;
                }
                let offset =
                    surface.and_then(|surface| surface.offset(i, &view.camera.ray(&x.into())));
                let offset = offset.map(|b| OffsetRow::new(&b, body.layout, per_m));
                let outside = d * precision + offset.map_or(0.0, |b| b.value);
                if outside > 0.0 {
                    let rows = [(i, outline_slope(ellipse, sin, cos, &slope) * precision)];
                    row(outside, weight, &rows, offset.as_ref());
                }
            }
        }
    }

    /// The border points of one view and their residuals, each where its line of sight touches the nearest ellipsoid.
    fn view_residuals(
        &self,
        source: usize,
        view: &EllipseView<'_>,
        ellipsoids: &[Ellipsoid],
        surface: &EllipsoidSurface<'_>,
    ) -> Vec<(usize, PlacedResidual)> {
        let (ellipses, _) = project_all(&view.projection, ellipsoids);
        let sigma = self.sigma_px(view);
        let mut near = NearEllipses::new();
        let mut residuals = Vec::with_capacity(view.points.len());
        let points = view.points.iter().zip(&view.rays);
        let borders = view.lengths_px.iter().zip(&view.normals);

        for (point, ((x, ray), (length_px, normal))) in points.zip(borders).enumerate() {
            let Some(distance) = self.distance(view, &ellipses, x, &mut near) else {
                continue;
            };

            let Some(index) = near.most() else { continue };
            let (part, touched) = surface.contact(index, ray);
            let offset_m = surface.offset(index, ray).map_or(0.0, |b| b.value_m);
            let distance = distance - offset_m * view.px_per_m;

            residuals.push((
                point,
                PlacedResidual {
                    source: Source::View(source),
                    value: distance / sigma,
                    trust: self.options.loss.evaluate(distance / sigma).1,
                    sigma,
                    weight: length_px / (view.px_per_m * self.options.correlation_m),
                    outward_px: *normal,
                    part,
                    place_part: touched,
                },
            ));
        }
        residuals
    }

    /// The border points, divided by whether they tell what they show.
    fn divided(&self, body: &Posed<'_>) -> Divided {
        let ellipsoids = body.ellipsoids();
        let surface = EllipsoidSurface::new(body, &ellipsoids);
        let (folds, shared) = (EllipsoidFolds::new(body), SharedBorder::new(body.model));
        let mut divided = Divided { clear: Vec::new(), unclear: Vec::new() };
        for (source, view) in self.views.iter().enumerate() {
            let (ellipses, _) = project_all(&view.projection, &ellipsoids);
            let reach_px = WITHIN * self.sigma_px(view);
            let is_shared = |point: usize, part: PartId| {
                let x = &view.points[point];
                let is_near = |ellipse: &OutlineEllipse| {
                    !ellipse.is_farther_than(reach_px, x)
                        && ellipse.distance(x, self.options.distance).0 < reach_px
                };
                let mut others = body.model.ellipsoids.iter().zip(&ellipses);
                shared.may_be_of(part)
                    && others.any(|(other, ellipse)| {
                        shared.is_of(part, other.part) && ellipse.as_ref().is_some_and(is_near)
                    })
            };
            for (point, residual) in self.view_residuals(source, view, &ellipsoids, &surface) {
                match folds.contain(&residual) || is_shared(point, residual.part) {
                    true => divided.unclear.push((residual.source, point)),
                    false => divided.clear.push(residual),
                }
            }
        }
        divided
    }

    /// Distance of a border point to the model.
    fn distance(
        &self,
        view: &EllipseView<'_>,
        ellipses: &[Option<OutlineEllipse>],
        x: &Vector2<f64>,
        near: &mut NearEllipses,
    ) -> Option<f64> {
        let kind = self.options.distance;
        match self.options.variant {
            Variant::Published => nearest(ellipses, x, kind, near),
            Variant::Outline => {
                let blend_px = self.options.blend_m * view.px_per_m;
                smooth_union(ellipses, x, kind, blend_px, near)
            }
        }
    }
}

/// What the rows of all views have in common.
struct PlacedBody<'a> {
    layout: Layout,
    /// The girth of each ellipsoid at coefficient 0, metres: whatever the state is.
    girths_m: Vec<f64>,
    /// Of a model with offsets.
    surface: Option<EllipsoidSurface<'a>>,
}

impl<'a> PlacedBody<'a> {
    fn new(body: &'a Posed<'a>, ellipsoids: &[Ellipsoid]) -> Self {
        let girth = |r: Vector3<f64>| {
            let sum = r.norm_squared() - r.min().powi(2);
            std::f64::consts::TAU * (0.5 * sum).sqrt()
        };
        let has_offsets = body.model.offsets.is_some();
        Self {
            layout: Layout::new(body.model),
            girths_m: body.model.ellipsoids.iter().map(|e| girth(e.radii.value)).collect(),
            surface: has_offsets.then(|| EllipsoidSurface::new(body, ellipsoids)),
        }
    }
}

/// ∂(slope·x)/∂(ellipse) for the sample x = c + L·(cos, sin), L the Cholesky factor of Σ.
fn outline_slope(e: &OutlineEllipse, sin: f64, cos: f64, slope: &Vector2<f64>) -> SVector<f64, 5> {
    let (l00, l10, l11) = (e.root[(0, 0)], e.root[(1, 0)], e.root[(1, 1)]);
    // l00 = √Σxx, l10 = Σxy/l00, l11 = √(Σyy − l10²)
    let by =
        |d00: f64, d10: f64, d11: f64| slope[0] * d00 * cos + slope[1] * (d10 * cos + d11 * sin);
    let d00 = 0.5 / l00;
    let d10 = -l10 / l00 * d00;
    SVector::from([[
        slope[0],
        slope[1],
        by(d00, d10, -l10 * d10 / l11),
        by(0.0, 1.0 / l00, -l10 / (l00 * l11)),
        by(0.0, 0.0, 0.5 / l11),
    ]])
}

impl Term for EllipseSilhouette<'_> {
    fn name(&self) -> &'static str {
        "ellipses"
    }

    fn observations(&self) -> f64 {
        let length_m = |v: &EllipseView<'_>| v.lengths_px.iter().sum::<f64>() / v.px_per_m;
        self.views.iter().map(length_m).sum::<f64>() / self.options.correlation_m
    }

    fn cost(&self, body: &Posed<'_>) -> f64 {
        let ellipsoids = body.ellipsoids();
        let placed = PlacedBody::new(body, &ellipsoids);
        let mut cost = 0.0;
        for view in &self.views {
            let ellipses: Vec<_> = ellipsoids
                .iter()
                .map(|e| project(&view.projection, e).map(|e| OutlineEllipse::new(&e)))
                .collect();
            self.rows(view, &ellipses, &placed, |r, w, _, _| {
                cost += 0.5 * w * self.options.loss.evaluate(r).0
            });
        }
        cost
    }

    fn linearize(&self, body: &Posed<'_>, equations: &mut NormalEquations) -> f64 {
        let ellipsoids = body.ellipsoids();
        let placed = PlacedBody::new(body, &ellipsoids);
        let mut cost = 0.0;

        // rows are summed in the image, and over the cameras in the world
        let mut in_world = EllipseSums::<9>::new(ellipsoids.len());
        let mut in_image = EllipseSums::<5>::new(ellipsoids.len());
        for view in &self.views {
            let (ellipses, projections) = project_all(&view.projection, &ellipsoids);
            in_image.clear();
            self.rows(view, &ellipses, &placed, |r, w, rows, offset| {
                let (rho, weight) = self.options.loss.evaluate(r);
                cost += 0.5 * w * rho;
                in_image.add(rows, r, w * weight);
                if let Some(offset) = offset.filter(|offset| offset.is_free(equations)) {
                    OffsetRow::add_own(std::slice::from_ref(offset), r, w * weight, equations);
                    in_image.add_offset(offset, rows, w * weight);
                }
            });
            in_world.add_camera(&in_image, &projections);
        }

        // and chained to the body
        let mut jacobians = EllipsoidJacobians::new(body.model);
        jacobians.update(body, &ellipsoids);
        in_world.add_to(&jacobians, equations);
        cost
    }

    fn placed_residuals(&self, body: &Posed<'_>) -> Vec<PlacedResidual> {
        let ellipsoids = body.ellipsoids();
        let surface = EllipsoidSurface::new(body, &ellipsoids);
        let views = self.views.iter().enumerate();
        views
            .flat_map(|(source, view)| self.view_residuals(source, view, &ellipsoids, &surface))
            .map(|(_, residual)| residual)
            .collect()
    }

    fn clear(&self, body: &Posed<'_>) -> Clear<'_> {
        let Divided { clear, unclear } = self.divided(body);
        let views = self.views.iter().enumerate();
        let kept = views.map(|(i, view)| clear::kept(Source::View(i), view.len(), &unclear));
        let only = || -> Box<dyn Term + '_> { Box::new(self.only(&kept.collect::<Vec<_>>())) };
        Clear { residuals: clear, term: (!unclear.is_empty()).then(only) }
    }
}

fn project_all(
    projection: &Matrix3x4<f64>,
    ellipsoids: &[Ellipsoid],
) -> (Vec<Option<OutlineEllipse>>, Vec<ProjectionJacobian>) {
    let split = |e: &Ellipsoid| match project_with_jacobian(projection, e) {
        Some((ellipse, jacobian)) => (Some(OutlineEllipse::new(&ellipse)), jacobian),
        None => (None, ProjectionJacobian::zeros()),
    };
    ellipsoids.iter().map(split).unzip()
}
