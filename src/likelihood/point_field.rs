//! Points of the surface against the skin (PF02 § 3.1, eq. 7; PFD99 eq. 13).
//!
//! The residual is the signed distance r of the point from the nearest place of the skin, its foot, see [`foot`](super::foot).
//! A point errs by its covariance C, and the body's surface about the skin by σ_m. What of both is felt is along the normal n at
//! the foot:
//!
//! σ² = nᵀCn + σ_m².
//!
//! A point of cameras side by side errs in depth, along their line of sight v: C ≈ σ_z² vvᵀ. Then r = Δz n·v, σ = σ_z n·v, and
//! r/σ = Δz/σ_z is how far the depth is off, whichever way the surface faces: the likelihood of a depth at a given pixel. (So
//! there is no ln σ in it. Over a given piece of the *surface* there would be one; but the points are given by the pixels, and pixels
//! see a piece of surface in proportion to n·v, which takes it away.) Were σ the mean over all directions, σ_z/√3, the points of
//! surfaces that face the cameras would be trusted √3 times too much, and those of slanting surfaces too little.
//!
//! n changes with the state. Its change is carried, not held: r/σ changes by
//!
//! σ d(r/σ) = dr − (r/σ²) (Cn)·dn,
//!
//! which is one row of the foot's, exactly. So `linearize` tells the slope of what `cost` returns.
//!
//! A point is compared with the limb whose surface it is least outside of, anew in every evaluation. **Differs** from PFD99 § 3.3, where
//! points are assigned to limbs and assigned anew every few iterations: with that, tracks lost limbs;
//! [decision 0007](../../docs/decisions/0007-limbs-and-the-skin-distance.md) has the numbers.
//!
//! The skin's mismatch at least is common to neighbours: space is cut into cells of the correlation length, and the points of a cell
//! share the weight of one observation. So a dense cloud, or a dense place in one, says no more than a sparse one. But a cell with
//! far fewer points than the others is hardly one that the surface goes through: with a weight of its own, each stray that is
//! alone in its cell would count as much as all points of a piece of surface. A tenth of the points lies in cells with fewer points
//! than some number; cells with fewer share so much less than one observation.

use nalgebra::Vector2;

use super::clear::{self, Divided};
use super::nearest_limb::NearestLimb;
use super::skin_distance::{PosedScale, SkinScale};
use super::skin_term::{self, SkinTerm, SkinTouch, Touch};
use super::{Clear, PlacedResidual, PointOptions, Source, SurfacePoint, Term};
use crate::body::Posed;
use crate::body::metaball::{Field, FieldSample};
use crate::solver::{Loss, NormalEquations};

/// −log p(points | m, s) of one frame.
#[derive(Debug, Clone)]
pub struct PointField {
    points: Vec<SurfacePoint>,
    weights: Vec<f64>,
    options: PointOptions,
    scale: SkinScale,
}

impl PointField {
    /// The term of one frame's points; each is compared with the limb whose surface it is least outside of. `scale` is the model's.
    pub fn new(points: Vec<SurfacePoint>, options: PointOptions, scale: SkinScale) -> Self {
        let weights = weights(&points, options.correlation_m);
        Self { weights, points, options, scale }
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
        let mut nearest = NearestLimb::new(body, field, scale, self.options);
        for (index, (point, &weight)) in self.points.iter().zip(&self.weights).enumerate() {
            let Some(met) = nearest.meet(point) else { continue };
            let touch = Touch {
                source: Source::Cloud,
                index,
                sigma_m: met.sigma_m,
                sigma: met.sigma_m,
                weight,
                counts: 1.0,
                outward_px: Vector2::zeros(),
                residual: met.residual,
                offsets: &nearest.met.offsets,
                place: met.place,
            };
            each(&touch, &nearest.met.sample);
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

    fn clear(&self, body: &Posed<'_>) -> Clear<'_> {
        let Divided { clear, unclear } = Divided::new(self, body, |_, _| false);
        let kept = clear::kept(Source::Cloud, self.points.len(), &unclear);
        let only = || -> Box<dyn Term> {
            Box::new(Self {
                points: kept.iter().map(|&i| self.points[i]).collect(),
                weights: kept.iter().map(|&i| self.weights[i]).collect(),
                options: self.options,
                scale: self.scale.clone(),
            })
        };
        Clear { residuals: clear, term: (!unclear.is_empty()).then(only) }
    }
}

/// The share of the points that lie in cells of fewer points than usual.
const SPARSE: f64 = 0.1;

/// One for each cell of space, shared by its points; less where a cell has fewer points than usual.
fn weights(points: &[SurfacePoint], cell_m: f64) -> Vec<f64> {
    if cell_m.is_nan() || cell_m <= 0.0 {
        return vec![1.0; points.len()];
    }
    let cell = |p: &SurfacePoint| p.position_world.coords.map(|x| (x / cell_m).floor() as i64);
    let mut cells: Vec<([i64; 3], usize)> =
        points.iter().enumerate().map(|(i, p)| (cell(p).into(), i)).collect();
    cells.sort_unstable();

    // how many points are with each, itself included
    let mut counts = vec![1; points.len()];
    for shared in cells.chunk_by(|a, b| a.0 == b.0) {
        for (_, index) in shared {
            counts[*index] = shared.len();
        }
    }
    let mut sorted = counts.clone();
    sorted.sort_unstable();
    let usual = sorted.get((SPARSE * sorted.len() as f64) as usize).copied().unwrap_or(1);
    counts.into_iter().map(|count| 1.0 / count.max(usual) as f64).collect()
}

#[cfg(test)]
mod tests {
    use nalgebra::Point3;

    use super::*;

    fn point(x: f64) -> SurfacePoint {
        SurfacePoint::isotropic(Point3::new(x, -0.05, 1.0), 0.002)
    }

    #[test]
    fn the_points_of_a_cell_share_one_observation() {
        let points = [0.01, 0.55, 0.03, 0.06, -0.01].map(point);
        assert_eq!(weights(&points, 0.1), [1.0 / 3.0, 1.0, 1.0 / 3.0, 1.0 / 3.0, 1.0]);
        assert_eq!(weights(&points, 0.0), [1.0; 5]);
    }

    #[test]
    fn a_point_alone_says_less_than_a_cell_of_many() {
        // 9 cells of 20 points, and 5 points alone
        let surface = (0..180).map(|i| point(0.005 * f64::from(i) + 0.001));
        let strays = (0..5).map(|i| point(5.05 + f64::from(i)));
        let weights = weights(&surface.chain(strays).collect::<Vec<_>>(), 0.1);
        assert_eq!(weights, [0.05; 185]);
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
