//! Lines of sight of border pixels against the skin (PF02 § 3.2, App. A.2).
//!
//! A line of sight through the silhouette's border touches the skin: on it, F is largest at x*, and is T there.
//! The residual is the skin distance r at x*, see [`SkinScale`]: ∂r = Σ wᵢ αᵢ ∂ ln fᵢ at a fixed point.
//!
//! x* = o + t* r moves along the ray as the state changes. It stays where ∂(ln F)/∂t = r·p = 0, p = ∇ ln F, so with
//! K = ∇² ln F
//!
//! dt*/dθ = −(rᵀ ∂p/∂θ)/(rᵀKr)
//!
//! (PF02's −(rᵀ ∂∇F/∂θ)/(rᵀ∇²F r): the same, as r·p = 0). F does not see it, as it is largest there; the local length
//! does, by e = Σ wᵢ αᵢ ∂(ln fᵢ)/∂t. So dr/dθ = Σ wᵢ αᵢ ∂(ln fᵢ)/∂θ + b·∂p/∂θ with b = −r e/(rᵀKr): one row of
//! [`FieldSlopes`]. The published residual sees F alone, and needs no second derivative.
//!
//! A border pixel errs by σ² = (σ_px z/f)² + σ_m², metres at the contact: segmentation, and the model's own
//! mismatch with a body. Neighbours err together: a row weighs its length over the correlation length.

use nalgebra::{Point3, Vector3};

use super::contact::RayField;
use super::limb_sums::LimbSums;
use super::skin_distance::{Derivatives, PosedScale, Residual, SkinResidual, SkinScale};
use super::{PlacedResidual, Source, Term};
use crate::body::Posed;
use crate::body::metaball::{Field, FieldRow, FieldSample, FieldSlopes};
use crate::camera::Camera;
use crate::silhouette::Silhouette;
use crate::solver::{Loss, NormalEquations};

/// Settings of the ray likelihood.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct RayOptions {
    /// Which residual.
    pub residual: Residual,
    /// σ_px: standard deviation of a border pixel, px.
    pub sigma_px: f64,
    /// σ_m: standard deviation of the body's surface about the skin, m.
    pub sigma_m: f64,
    /// Length along the border over which errors go together, m.
    pub correlation_m: f64,
    /// Robust loss, in standard deviations.
    pub loss: Loss,
    /// Which derivatives.
    pub derivatives: Derivatives,
}

impl Default for RayOptions {
    fn default() -> Self {
        Self {
            residual: Residual::Metric,
            sigma_px: 1.0,
            sigma_m: 0.01,
            correlation_m: 0.1,
            loss: Loss::Cauchy(3.0),
            derivatives: Derivatives::Complete,
        }
    }
}

/// One camera's lines of sight.
#[derive(Debug, Clone, PartialEq)]
pub struct RayView {
    origin_world: Vector3<f64>,
    /// Unit vectors.
    directions_world: Vec<Vector3<f64>>,
    lengths_px: Vec<f64>,
    px_per_m: f64,
}

impl RayView {
    /// A silhouette thinned to one border point every `spacing_m`, of a body at depth `depth_m`.
    pub fn new(camera: &Camera, silhouette: &Silhouette, depth_m: f64, spacing_m: f64) -> Self {
        let px_per_m = 0.5 * (camera.intrinsics.fx_px + camera.intrinsics.fy_px) / depth_m;
        let contour = silhouette.thinned(spacing_m * px_per_m);
        let direction = |pixel| camera.ray(pixel).direction_world.into_inner();
        Self {
            origin_world: camera.centre_world().coords,
            directions_world: contour.iter().map(|p| direction(&p.pixel)).collect(),
            lengths_px: contour.iter().map(|p| p.length_px).collect(),
            px_per_m,
        }
    }

    /// Number of lines of sight.
    pub fn len(&self) -> usize {
        self.directions_world.len()
    }

    /// No line of sight at all.
    pub fn is_empty(&self) -> bool {
        self.directions_world.is_empty()
    }
}

/// The residual of one line of sight.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RayResidual {
    /// Which view, in the order given.
    pub view: usize,
    /// Which line of sight of that view, in the order along the thinned border.
    pub ray: usize,
    /// Distance of the skin, positive where the ray passes outside it, m.
    pub residual_m: f64,
    /// Its standard deviation, m.
    pub sigma_m: f64,
    /// Number of independent observations that it stands for.
    pub weight: f64,
    /// x*.
    pub contact_world: Point3<f64>,
    /// The metaball of largest weight at x*: index in [`Field::metaballs`].
    pub metaball: usize,
}

/// −log p(silhouettes | m, s) of one frame, for a body of metaballs.
#[derive(Debug, Clone)]
pub struct SilhouetteRays {
    views: Vec<RayView>,
    options: RayOptions,
    scale: SkinScale,
}

/// One line of sight at one state.
struct Touch<'a> {
    view: usize,
    ray: usize,
    direction: &'a Vector3<f64>,
    sigma_m: f64,
    weight: f64,
    residual: SkinResidual,
}

/// Curvatures of ln F along a ray that are not below this have no defined summit, 1/m².
const FLATTEST: f64 = -1e-3;

impl SilhouetteRays {
    /// The term of one frame's views; `scale` is the model's.
    pub fn new(views: Vec<RayView>, options: RayOptions, scale: SkinScale) -> Self {
        Self {
            views,
            options,
            scale,
        }
    }

    /// Number of lines of sight in all views.
    pub fn border_points(&self) -> usize {
        self.views.iter().map(RayView::len).sum()
    }

    /// Every line of sight's residual, view after view; those that no metaball lies before are left out.
    pub fn residuals(&self, body: &Posed<'_>) -> Vec<RayResidual> {
        let mut all = Vec::with_capacity(self.border_points());
        let field = Field::of(body);
        let scale = self.scale.constant(&field);
        self.touches((&field, &scale), |touch, sample| {
            all.push(RayResidual {
                view: touch.view,
                ray: touch.ray,
                residual_m: touch.residual.distance_m,
                sigma_m: touch.sigma_m,
                weight: touch.weight,
                contact_world: Point3::from(sample.point_world),
                metaball: sample.heaviest().unwrap_or_default(),
            });
        });
        all
    }

    /// Calls `each` for every line of sight that has a contact, with the field there.
    fn touches(
        &self,
        (field, scale): (&Field, &PosedScale<'_>),
        mut each: impl FnMut(&Touch<'_>, &FieldSample),
    ) {
        let mut sample = FieldSample::default();
        let kind = (self.options.residual, self.options.derivatives);
        let mut near = Vec::new();
        for (index, view) in self.views.iter().enumerate() {
            let mut rays = RayField::new(field, view.origin_world);
            let sigma_m = (self.options.sigma_px / view.px_per_m).hypot(self.options.sigma_m);
            let per_px = 1.0 / (view.px_per_m * self.options.correlation_m);
            let rows = view.directions_world.iter().zip(&view.lengths_px);
            for (ray, (direction, length_px)) in rows.enumerate() {
                let Some(contact) = rays.contact(direction, &mut near) else {
                    continue;
                };
                let x = rays.point(direction, contact.t);
                sample.update_limb(field, contact.limb, &x, &near);
                let touch = Touch {
                    view: index,
                    ray,
                    direction,
                    sigma_m,
                    weight: length_px * per_px,
                    residual: scale.residual(kind, &sample),
                };
                each(&touch, &sample);
            }
        }
    }
}

impl Touch<'_> {
    /// (ρ, what a row weighs in units of 1/m²), ρ with its weight.
    fn loss(&self, loss: Loss) -> (f64, f64) {
        let (rho, slope) = loss.evaluate(self.residual.distance_m / self.sigma_m);
        let precision = 1.0 / (self.sigma_m * self.sigma_m);
        (self.weight * rho, self.weight * slope * precision)
    }

    /// b: what the contact's own motion along the ray adds.
    fn along(&self, sample: &FieldSample, alpha: impl Fn(usize) -> f64) -> Vector3<f64> {
        let r = self.direction;
        let curvature = r.dot(&(sample.log_hessian * r));
        // only differences of αᵢ matter: without them F is at its summit
        if self.residual.gamma.abs() < f64::MIN_POSITIVE || curvature > FLATTEST {
            return Vector3::zeros();
        }
        let each = sample.shares.iter();
        let slope: f64 = each
            .map(|s| -4.0 * s.weight * alpha(s.metaball) * s.pull.dot(r))
            .sum();
        r * (-slope / curvature)
    }
}

impl Term for SilhouetteRays {
    fn name(&self) -> &'static str {
        "rays"
    }

    fn observations(&self) -> f64 {
        let length_m = |v: &RayView| v.lengths_px.iter().sum::<f64>() / v.px_per_m;
        self.views.iter().map(length_m).sum::<f64>() / self.options.correlation_m
    }

    fn cost(&self, body: &Posed<'_>) -> f64 {
        let mut cost = 0.0;
        let field = Field::of(body);
        let scale = self.scale.constant(&field);
        self.touches((&field, &scale), |touch, _| {
            cost += 0.5 * touch.loss(self.options.loss).0;
        });
        cost
    }

    fn linearize(&self, body: &Posed<'_>, equations: &mut NormalEquations) -> f64 {
        let field = Field::of(body);
        let slopes = FieldSlopes::new(body, &field);
        let mut sums = LimbSums::new(&slopes);
        let mut row = FieldRow::default();
        let mut cost = 0.0;
        let scale = self.scale.constant(&field);
        self.touches((&field, &scale), |touch, sample| {
            let (rho, weight) = touch.loss(self.options.loss);
            cost += 0.5 * rho;
            let r = touch.residual;
            let change = |i| scale.change(&r, i);
            let b = touch.along(sample, |i| change(i).0);
            slopes.row_with_radii(sample, change, &b, &mut row);
            sums.add(sample.limb, &row.values, r.distance_m, weight);
        });
        sums.add_to(&slopes, equations);
        cost
    }

    fn placed_residuals(&self, body: &Posed<'_>) -> Vec<PlacedResidual> {
        let field = Field::of(body);
        let placed = |r: RayResidual| {
            let source = field.source(r.metaball).unwrap_or_default();
            let part = body.model.metaballs[source].part;
            PlacedResidual {
                source: Source::View(r.view),
                value: r.residual_m / r.sigma_m,
                sigma: r.sigma_m * self.views[r.view].px_per_m,
                weight: r.weight,
                part,
                place_part: body.in_part(part, &r.contact_world),
            }
        };
        self.residuals(body).into_iter().map(placed).collect()
    }
}
