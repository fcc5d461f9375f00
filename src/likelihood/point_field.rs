//! Points of the surface against the skin (PF02 § 3.1, eq. 7; PFD99 eq. 13).
//!
//! The residual is the skin distance at the point, see [`SkinScale`]; the point itself does not move, so
//! dr/dθ = Σ wᵢ αᵢ ∂(ln fᵢ)/∂θ.
//!
//! A point has the variance σ² = σᵢ² + σ_m²: that of its own error, and of the skin's mismatch with the body. The mismatch at
//! least is common to neighbours: space is cut into cells of the correlation length, and the points of a cell share the
//! weight of one observation. So a dense cloud, or a dense place in one, says no more than a sparse one.

use nalgebra::{Point3, Vector2};

use super::skin_distance::{Derivatives, PosedScale, Residual, SkinScale};
use super::skin_term::{self, SkinTerm, SkinTouch, Touch};
use super::{PlacedResidual, Source, Term};
use crate::body::Posed;
use crate::body::metaball::{Field, FieldSample, Sampler};
use crate::solver::{Loss, NormalEquations};
use crate::stereo::{CloudPoint, Spread};

/// Settings of the point likelihood.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct PointOptions {
    /// Which residual.
    pub residual: Residual,
    /// σ_m: standard deviation of the body's surface about the skin, m.
    pub sigma_m: f64,
    /// Length over which errors go together, m; 0 makes every point an observation of its own.
    pub correlation_m: f64,
    /// Robust loss, in standard deviations.
    pub loss: Loss,
    /// Which derivatives.
    pub derivatives: Derivatives,
}

impl Default for PointOptions {
    fn default() -> Self {
        Self {
            residual: Residual::Metric,
            sigma_m: 0.01,
            correlation_m: 0.1,
            loss: Loss::Cauchy(3.0),
            derivatives: Derivatives::Complete,
        }
    }
}

/// A point measured on the surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfacePoint {
    /// Where.
    pub position_world: Point3<f64>,
    /// σᵢ: standard deviation of a coordinate, m; 0 where it is not known.
    pub sigma_m: f64,
}

impl From<&CloudPoint> for SurfacePoint {
    /// A covariance is replaced by its mean over all directions: the variance along the skin's normal would change with the pose.
    fn from(point: &CloudPoint) -> Self {
        let sigma_m = match point.spread {
            Spread::Unknown => 0.0,
            Spread::Isotropic(sigma_m) => sigma_m,
            Spread::Full(covariance) => (covariance.trace() / 3.0).sqrt(),
        };
        Self { position_world: point.position_world, sigma_m }
    }
}

/// −log p(points | m, s) of one frame.
#[derive(Debug, Clone)]
pub struct PointField {
    points: Vec<SurfacePoint>,
    weights: Vec<f64>,
    options: PointOptions,
    scale: SkinScale,
}

impl PointField {
    /// The term of one frame's points; each belongs to the limb that is largest at it. `scale` is the model's.
    pub fn new(points: Vec<SurfacePoint>, options: PointOptions, scale: SkinScale) -> Self {
        Self { weights: weights(&points, options.correlation_m), points, options, scale }
    }

    /// The residual of every point; none for a body without metaballs.
    pub fn residuals(&self, body: &Posed<'_>) -> Vec<SkinTouch> {
        skin_term::all_touches(self, body)
    }
}

impl SkinTerm for PointField {
    fn loss(&self) -> Loss {
        self.options.loss
    }

    fn scale(&self, body: &Posed<'_>, field: &Field) -> PosedScale<'_> {
        self.scale.posed(body, field)
    }

    fn touches(
        &self,
        body: &Posed<'_>,
        field: &Field,
        scale: &PosedScale<'_>,
        mut each: impl FnMut(&Touch<'_>, &FieldSample),
    ) {
        let options = &self.options;
        let mut sampler = Sampler::new(field);
        let mut sample = FieldSample::default();
        let mut offsets = Vec::new();

        for (index, (point, &weight)) in self.points.iter().zip(&self.weights).enumerate() {
            if !sampler.sample(&point.position_world.coords, &mut sample) {
                continue;
            }
            let metaballs = &field.limbs[sample.limb];
            skin_term::displace(body, field, metaballs, &mut sample, &mut offsets);

            let sigma_m = point.sigma_m.hypot(options.sigma_m);
            let touch = Touch {
                source: Source::Cloud,
                index,
                sigma_m,
                sigma: sigma_m,
                weight,
                outward_px: Vector2::zeros(),
                residual: scale.residual(options.residual, options.derivatives, &sample),
                offsets: &offsets,
                line: None,
            };
            each(&touch, &sample);
        }
    }
}

impl Term for PointField {
    fn name(&self) -> &'static str {
        "points"
    }

    fn observations(&self) -> f64 {
        self.weights.iter().sum()
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
}

/// One for each cell of space, shared by its points.
fn weights(points: &[SurfacePoint], cell_m: f64) -> Vec<f64> {
    if cell_m.is_nan() || cell_m <= 0.0 {
        return vec![1.0; points.len()];
    }
    let cell = |p: &SurfacePoint| p.position_world.coords.map(|x| (x / cell_m).floor() as i64);
    let mut cells: Vec<([i64; 3], usize)> =
        points.iter().enumerate().map(|(i, p)| (cell(p).into(), i)).collect();
    cells.sort_unstable();
    let mut weights = vec![1.0; points.len()];
    for shared in cells.chunk_by(|a, b| a.0 == b.0) {
        for (_, index) in shared {
            weights[*index] = 1.0 / shared.len() as f64;
        }
    }
    weights
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(x: f64) -> SurfacePoint {
        SurfacePoint { position_world: Point3::new(x, -0.05, 1.0), sigma_m: 0.002 }
    }

    #[test]
    fn the_points_of_a_cell_share_one_observation() {
        let points = [0.01, 0.55, 0.03, 0.06, -0.01].map(point);
        assert_eq!(weights(&points, 0.1), [1.0 / 3.0, 1.0, 1.0 / 3.0, 1.0 / 3.0, 1.0]);
        assert_eq!(weights(&points, 0.0), [1.0; 5]);
    }

    #[test]
    fn a_dense_cloud_says_no_more_than_a_sparse_one() {
        let cloud = |count: usize| {
            let points: Vec<_> = (0..count).map(|i| point(i as f64 / count as f64)).collect();
            weights(&points, 0.1).iter().sum::<f64>()
        };
        approx::assert_relative_eq!(cloud(100), 10.0, epsilon = 1e-9);
        approx::assert_relative_eq!(cloud(10_000), 10.0, epsilon = 1e-9);
    }
}
