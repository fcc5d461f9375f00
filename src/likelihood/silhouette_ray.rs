//! Lines of sight of border pixels against the skin (PF02 § 3.2, App. A.2).
//!
//! A line of sight through the silhouette's border touches the skin: on it, F is largest at x*, and is T there.
//! The residual is the skin distance r at x*, see [`SkinScale`]: ∂r = Σ wᵢ (αᵢ ∂ ln fᵢ + γᵢ ∂ ln Rᵢ) at a fixed point.
//!
//! x* = o + t* r moves along the ray as the state changes. It stays where ∂(ln F)/∂t = r·p = 0, p = ∇ ln F, so with
//! K = ∇² ln F
//!
//! dt*/dθ = −(rᵀ ∂p/∂θ)/(rᵀKr)
//!
//! (PF02 App. A.2's −(rᵀ ∂∇F/∂θ)/(rᵀ∇²F r): the same, as r·p = 0). The motion of x* does not change F, which is largest there. It
//! changes the local length, by e = Σ wᵢ (αᵢ ∂ ln fᵢ + γᵢ ∂ ln Rᵢ)/∂t. So
//! dr/dθ = Σ wᵢ (αᵢ ∂ ln fᵢ + γᵢ ∂ ln Rᵢ)/∂θ + b·∂p/∂θ with b = −r e/(rᵀKr): one row of
//! [`FieldSlopes`](crate::body::metaball::FieldSlopes). The published residual depends on F alone and needs no second derivative.
//!
//! Which limb a line touches is told by [`touched_limb`](super::touched_limb).
//!
//! What is worn or carried lies outside the body, and no part of the body outside the mask. The cost of a line whose border lies outside
//! the body counts w⁺ times, which is 1 where nothing tells of such things. With w⁺ < 1 the body is fitted to an expectile of the
//! residuals instead of their mean (Newey & Powell 1987, *Asymmetric least squares*). As an observation of how residuals err
//! ([`PlacedResidual`]) it stands for as much as the others: by how far clothes hang off is not known.
//!
//! A border pixel has the variance σ² = (σ_px z/f)² + σ_m², in metres at the contact: that of the segmentation, and the model's
//! own mismatch with a body. Neighbours err together: the weight of a row is its length over the correlation length.
//!
//! What is observed are pixels. A distance in metres is one in pixels times Z/f, so σ is s(Z/Z₀), s as above at the depth Z₀ about which the
//! silhouettes show the person, Z the depth of the body's root. With a fixed σ every residual would be smaller before a body that is nearer,
//! and each camera would pull it towards itself, by ∂/∂ ln Z of the cost = Σ w ρ′ r²/σ², as many nats as it shows independent observations:
//! before cameras side by side 4 mm, and where focal lengths are unknown nothing would hold the world's size against it.

use nalgebra::{Vector2, Vector3};

use super::clear::{self, Divided};
use super::contact::RayField;
use super::shared_border::{SharedBorder, WITHIN};
use super::skin_distance::{Derivatives, PosedScale, Residual, SkinScale};
use super::skin_term::{self, SkinTerm, SkinTouch, Touch, TouchPlace};
use super::touched_limb::LimbSearch;
use super::{Clear, Parallax, PlacedResidual, Source, Term};
use crate::body::Posed;
use crate::body::metaball::{Field, FieldSample};
use crate::camera::Camera;
use crate::silhouette::{ContourPoint, Silhouette};
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
    /// w⁺: how many times a line counts where the border lies outside the body.
    pub outward: f64,
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
            outward: 1.0,
            derivatives: Derivatives::Complete,
        }
    }
}

/// Nearer than this share of the depth at which a person is shown no body is.
const NEAREST: f64 = 0.1;

/// One camera's lines of sight.
#[derive(Debug, Clone, PartialEq)]
pub struct RayView {
    origin_world: Vector3<f64>,
    /// Unit vectors.
    directions_world: Vec<Vector3<f64>>,
    lengths_px: Vec<f64>,
    normals_px: Vec<Vector2<f64>>,
    px_per_m: f64,
    axis_world: Vector3<f64>,
    /// Z₀.
    depth_m: f64,
}

impl RayView {
    /// A silhouette thinned to one border point every `spacing_m`, of a body at depth `depth_m`.
    pub fn new(camera: &Camera, silhouette: &Silhouette, depth_m: f64, spacing_m: f64) -> Self {
        let px_per_m = camera.intrinsics.focal_px() / depth_m;
        let contour = silhouette.thinned(spacing_m * px_per_m);
        let direction = |pixel| camera.ray(pixel).direction_world.into_inner();
        Self {
            origin_world: camera.centre_world().coords,
            directions_world: contour.iter().map(|p| direction(&p.pixel)).collect(),
            lengths_px: contour.iter().map(ContourPoint::counted_px).collect(),
            normals_px: contour.iter().map(|p| p.normal).collect(),
            px_per_m,
            axis_world: camera.optical_axis().direction_world.into_inner(),
            depth_m,
        }
    }

    fn only(&self, lines: &[usize]) -> Self {
        Self {
            origin_world: self.origin_world,
            directions_world: lines.iter().map(|&i| self.directions_world[i]).collect(),
            lengths_px: lines.iter().map(|&i| self.lengths_px[i]).collect(),
            normals_px: lines.iter().map(|&i| self.normals_px[i]).collect(),
            px_per_m: self.px_per_m,
            axis_world: self.axis_world,
            depth_m: self.depth_m,
        }
    }

    /// Z of a body's root.
    fn root_depth_m(&self, body: &Posed<'_>) -> f64 {
        let way = body.root_world() - self.origin_world;
        way.dot(&self.axis_world).max(NEAREST * self.depth_m)
    }

    /// Z/Z₀.
    fn nearer(&self, body: &Posed<'_>) -> f64 {
        self.root_depth_m(body) / self.depth_m
    }

    /// s, m.
    fn sigma_m(&self, options: &RayOptions) -> f64 {
        (options.sigma_px / self.px_per_m).hypot(options.sigma_m)
    }

    /// The mean direction, and the greatest angle of a line with it; `None` if there is no line.
    fn cone(&self) -> Option<(Vector3<f64>, f64)> {
        let axis = self.directions_world.iter().sum::<Vector3<f64>>();
        let axis = axis.try_normalize(f64::MIN_POSITIVE)?;
        let angles = self.directions_world.iter().map(|direction| direction.angle(&axis));
        Some((axis, angles.fold(0.0, f64::max)))
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

/// −log p(silhouettes | m, s) of one frame, for a body of metaballs.
#[derive(Debug, Clone)]
pub struct SilhouetteRays {
    views: Vec<RayView>,
    options: RayOptions,
    scale: SkinScale,
}

impl SilhouetteRays {
    /// The term of one frame's views; `scale` is the model's.
    pub fn new(views: Vec<RayView>, options: RayOptions, scale: SkinScale) -> Self {
        Self { views, options, scale }
    }

    /// Number of views.
    pub(super) fn views(&self) -> usize {
        self.views.len()
    }

    /// Number of lines of sight in all views.
    pub fn border_points(&self) -> usize {
        self.views.iter().map(RayView::len).sum()
    }

    /// Whether lines of sight of two views may be at a smaller angle than this.
    pub(super) fn has_views_within(&self, angle_rad: f64) -> bool {
        let cones: Vec<_> = self.views.iter().filter_map(RayView::cone).collect();
        let is_within = |i: usize, j: usize| {
            let ((a, wide), (b, other_wide)) = (&cones[i], &cones[j]);
            a.angle(b) < angle_rad + wide + other_wide
        };
        (0..cones.len()).any(|i| (0..i).any(|j| is_within(i, j)))
    }

    /// Without the lines that do not tell which of two parts they show.
    pub(super) fn without_shared(&self, body: &Posed<'_>) -> Self {
        self.without(&self.shared(body))
    }

    /// The lines that touch a part of a limb beside another part, ascending.
    fn shared(&self, body: &Posed<'_>) -> Vec<(Source, usize)> {
        let (field, border) = (Field::from_body(body), SharedBorder::new(body.model));
        let scale = self.scale.posed(body, &field);
        let mut search = LimbSearch::new(body, &field, &scale, &self.options);
        let mut shared = Vec::new();
        for (source, view) in self.views.iter().enumerate() {
            let mut rays = RayField::new(&field, view.origin_world);
            let within_m = WITHIN * view.sigma_m(&self.options) * view.nearer(body);
            for (line, direction) in view.directions_world.iter().enumerate() {
                if search.shares(&border, &mut rays, direction, within_m) {
                    shared.push((Source::View(source), line));
                }
            }
        }
        shared
    }

    fn without(&self, lines: &[(Source, usize)]) -> Self {
        let views = self.views.iter().enumerate();
        let kept = views.map(|(i, view)| clear::kept(Source::View(i), view.len(), lines));
        self.only(&kept.collect::<Vec<_>>())
    }

    /// Of each view only these lines of sight.
    pub(super) fn only(&self, lines: &[Vec<usize>]) -> Self {
        let views = self.views.iter().zip(lines).map(|(view, lines)| view.only(lines)).collect();
        Self { views, options: self.options, scale: self.scale.clone() }
    }

    /// The residual of every line of sight, view after view; lines with no metaball before the camera are left out.
    pub fn residuals(&self, body: &Posed<'_>) -> Vec<SkinTouch> {
        skin_term::all_touches(self, body)
    }
}

impl SkinTerm for SilhouetteRays {
    fn loss(&self) -> Loss {
        self.options.loss
    }

    fn scale(&self, body: &Posed<'_>, field: &Field) -> PosedScale<'_> {
        self.scale.posed(body, field)
    }

    fn sigma_slope(&self, body: &Posed<'_>, source: Source) -> Vector3<f64> {
        match source {
            Source::View(view) => {
                let view = &self.views[view];
                view.axis_world / view.root_depth_m(body)
            }
            _ => Vector3::zeros(),
        }
    }

    fn touches(
        &self,
        body: &Posed<'_>,
        field: &Field,
        scale: &PosedScale<'_>,
        mut each: impl FnMut(&Touch<'_>, &FieldSample),
    ) {
        let options = &self.options;
        let mut search = LimbSearch::new(body, field, scale, options);

        for (source, view) in self.views.iter().enumerate() {
            let mut rays = RayField::new(field, view.origin_world);
            let nearer = view.nearer(body);
            let sigma_m = view.sigma_m(options) * nearer;
            let per_px = 1.0 / (view.px_per_m * options.correlation_m);
            for (index, direction) in view.directions_world.iter().enumerate() {
                let Some(residual) = search.touch(&mut rays, direction) else { continue };
                let counts = if residual.distance_m > 0.0 { options.outward } else { 1.0 };
                let touch = Touch {
                    source: Source::View(source),
                    index,
                    sigma_m,
                    sigma: sigma_m / nearer * view.px_per_m,
                    weight: view.lengths_px[index] * per_px,
                    counts,
                    outward_px: view.normals_px[index],
                    residual,
                    offsets: &search.touched.offsets,
                    place: TouchPlace::Summit(direction),
                };
                each(&touch, &search.touched.sample);
            }
        }
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
        skin_term::cost(self, body)
    }

    fn linearize(&self, body: &Posed<'_>, equations: &mut NormalEquations) -> f64 {
        skin_term::linearize(self, body, equations)
    }

    fn placed_residuals(&self, body: &Posed<'_>) -> Vec<PlacedResidual> {
        skin_term::placed(self, body)
    }

    fn clear(&self, body: &Posed<'_>) -> Clear<'_> {
        let shared = self.shared(body);
        let is_shared = |source, line| shared.binary_search(&(source, line)).is_ok();
        let Divided { clear, unclear } = Divided::new(self, body, is_shared);
        let only = || -> Box<dyn Term> { Box::new(self.without(&unclear)) };
        Clear { residuals: clear, term: (!unclear.is_empty()).then(only) }
    }

    fn parallax(&self, body: &Posed<'_>) -> Option<Parallax> {
        Parallax::new(self, body)
    }
}
