//! Points of the surface against the skin (PF02 § 3.1, eq. 7; PFD99 eq. 13).
//!
//! The residual is the skin distance at the point, see [`SkinScale`]; the point itself does not move, so
//! dr/dθ = Σ wᵢ αᵢ ∂(ln fᵢ)/∂θ.
//!
//! A point errs by σ² = σᵢ² + σ_m²: its own error, and the skin's mismatch with the body. Neighbours err together,
//! by the mismatch at least: space is cut into cells of the correlation length, and the points of a cell share the
//! weight of one observation. So a dense cloud says no more than a sparse one, and a dense place in it neither.

use nalgebra::{Point3, Vector3};

use super::Term;
use super::association::associate;
use super::limb_sums::LimbSums;
use super::skin_distance::{Derivatives, Residual, SkinResidual, SkinScale};
use crate::body::Posed;
use crate::body::metaball::{Field, FieldRow, FieldSample, FieldSlopes, Sampler};
use crate::solver::{Loss, NormalEquations};

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

/// The residual of one point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PointResidual {
    /// Which point, in the order given.
    pub point: usize,
    /// Distance from the skin, positive outside, m.
    pub residual_m: f64,
    /// Its standard deviation, m.
    pub sigma_m: f64,
    /// Number of independent observations that it stands for.
    pub weight: f64,
    /// The metaball of largest weight: index in [`Field::metaballs`].
    pub metaball: usize,
}

/// −log p(points | m, s) of one frame.
#[derive(Debug, Clone)]
pub struct PointField {
    points: Vec<SurfacePoint>,
    weights: Vec<f64>,
    /// Limb of each point; empty where the largest counts.
    limbs: Vec<usize>,
    options: PointOptions,
    scale: SkinScale,
}

/// One point at one state.
struct Touch {
    point: usize,
    sigma_m: f64,
    weight: f64,
    residual: SkinResidual,
}

impl PointField {
    /// The term of one frame's points, each of which belongs to the limb that is largest at it; `scale` is the
    /// model's.
    pub fn new(points: Vec<SurfacePoint>, options: PointOptions, scale: SkinScale) -> Self {
        Self {
            weights: weights(&points, options.correlation_m),
            points,
            limbs: Vec::new(),
            options,
            scale,
        }
    }

    /// Lets every point belong to the limb that is largest at it in this pose, until it is called again.
    pub fn associate(&mut self, body: &Posed<'_>) {
        let points = self.points.iter().map(|p| p.position_world);
        self.limbs = associate(body, points).iter().map(|b| b.limb).collect();
    }

    /// Number of independent observations that the points stand for.
    pub fn effective_observations(&self) -> f64 {
        self.weights.iter().sum()
    }

    /// Every point's residual; none for a body without metaballs.
    pub fn residuals(&self, body: &Posed<'_>) -> Vec<PointResidual> {
        let mut all = Vec::with_capacity(self.points.len());
        self.touches(&Field::of(body), |touch, sample| {
            all.push(PointResidual {
                point: touch.point,
                residual_m: touch.residual.distance_m,
                sigma_m: touch.sigma_m,
                weight: touch.weight,
                metaball: sample.heaviest().unwrap_or_default(),
            });
        });
        all
    }

    fn touches(&self, field: &Field, mut each: impl FnMut(&Touch, &FieldSample)) {
        let kind = (self.options.residual, self.options.derivatives);
        let mut sampler = Sampler::new(field);
        let mut sample = FieldSample::default();
        for (index, (point, &weight)) in self.points.iter().zip(&self.weights).enumerate() {
            let limb = self.limbs.get(index).copied();
            if !sampler.sample(&point.position_world.coords, limb, &mut sample) {
                continue;
            }
            let residual = self.scale.residual(kind, field, &sample);
            let touch = Touch {
                point: index,
                sigma_m: point.sigma_m.hypot(self.options.sigma_m),
                weight,
                residual,
            };
            each(&touch, &sample);
        }
    }
}

impl Touch {
    /// (ρ, what a row weighs in units of 1/m²), ρ with its weight.
    fn loss(&self, loss: Loss) -> (f64, f64) {
        let (rho, slope) = loss.evaluate(self.residual.distance_m / self.sigma_m);
        let precision = 1.0 / (self.sigma_m * self.sigma_m);
        (self.weight * rho, self.weight * slope * precision)
    }
}

impl Term for PointField {
    fn name(&self) -> &'static str {
        "points"
    }

    fn cost(&self, body: &Posed<'_>) -> f64 {
        let mut cost = 0.0;
        self.touches(&Field::of(body), |touch, _| {
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
        self.touches(&field, |touch, sample| {
            let (rho, weight) = touch.loss(self.options.loss);
            cost += 0.5 * rho;
            let r = touch.residual;
            let alpha = |i| r.alpha + r.gamma * self.scale.length_m(&field, i);
            slopes.row(sample, alpha, &Vector3::zeros(), &mut row);
            sums.add(sample.limb, &row.values, r.distance_m, weight);
        });
        sums.add_to(&slopes, equations);
        cost
    }
}

/// One for each cell of space, shared by its points.
fn weights(points: &[SurfacePoint], cell_m: f64) -> Vec<f64> {
    if cell_m.is_nan() || cell_m <= 0.0 {
        return vec![1.0; points.len()];
    }
    let cell = |p: &SurfacePoint| p.position_world.coords.map(|x| (x / cell_m).floor() as i64);
    let mut cells: Vec<([i64; 3], usize)> = points
        .iter()
        .enumerate()
        .map(|(i, p)| (cell(p).into(), i))
        .collect();
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
        SurfacePoint {
            position_world: Point3::new(x, -0.05, 1.0),
            sigma_m: 0.002,
        }
    }

    #[test]
    fn the_points_of_a_cell_share_one_observation() {
        let points = [0.01, 0.55, 0.03, 0.06, -0.01].map(point);
        assert_eq!(
            weights(&points, 0.1),
            [1.0 / 3.0, 1.0, 1.0 / 3.0, 1.0 / 3.0, 1.0]
        );
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
