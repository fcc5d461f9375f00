//! The length that turns a metaball's distance into metres: how far its skin is from its centre, at the place looked at.
//!
//! For metaball i, R = R̄·exp(G), G = Σₖ qₖ gₖ, gₖ = ln(aₖ/āₖ). R̄ is measured on the mean body at rest (ā are its radii). A
//! body with other radii has another R *along the skin's normal*, of which qₖ are the squared components: with
//! u = A⁻¹(x − c) in the metaball's axes,
//!
//! qₖ = (uₖ² + δ/3)/e, e = ‖u‖² + δ.
//!
//! δ, small against ‖u‖² at the skin, makes R smooth at the centre. Derivatives:
//!
//! - ∂G/∂uₖ = 2uₖ(gₖ − G)/e, so ∇G = A⁻¹ ∂G/∂u,
//! - ∂G/∂ ln aₖ = qₖ − 4uₖ²(gₖ − G)/e.
//!
//! Why not simpler? With a constant R a fatter body makes every residual smaller: fits to points inflated. With an R that
//! grows with every radius, not only with those along the normal, a body can shrink a residual by growing thin across an
//! outlier. With an R that depends on the direction on the mean body already, a fit turns limbs to where R is small: the
//! basin of convergence shrank.

use nalgebra::{Matrix3, Vector3};

use crate::body::metaball::Metaball;

/// δ·m̄², m̄² the mean of the squared radii: d at which the direction begins to be felt, a seventh of that of the skin of
/// one metaball.
const SMOOTHING: f64 = 0.05;

/// R̄ of one metaball, and the radii with which it was measured.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct MeanLength {
    /// R̄, m.
    pub(super) length_m: f64,
    /// ā, m.
    pub(super) radii: Vector3<f64>,
}

/// R of one metaball of a body in a pose.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct LocalLength {
    length_m: f64,
    /// The metaball's axes in the world, as columns.
    axes_world: Matrix3<f64>,
    /// g.
    growth: Vector3<f64>,
    /// δ, 1/m².
    smoothing: f64,
}

/// ∂ ln R.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct LengthSlopes {
    /// ∇G: in the place, relative to the metaball; world, 1/m.
    pub(super) place: Vector3<f64>,
    /// In ln a of each radius.
    pub(super) radii: Vector3<f64>,
}

impl MeanLength {
    /// R of the same metaball with other radii.
    pub(super) fn with_radii(&self, radii: &Vector3<f64>, axes_world: Matrix3<f64>) -> LocalLength {
        LocalLength {
            length_m: self.length_m,
            axes_world,
            growth: radii.zip_map(&self.radii, |a, mean| (a / mean).ln()),
            smoothing: 3.0 * SMOOTHING / self.radii.norm_squared(),
        }
    }
}

impl LocalLength {
    /// The least and the greatest R, m: G is a mean of the g.
    pub(super) fn range_m(&self) -> (f64, f64) {
        (self.length_m * self.growth.min().exp(), self.length_m * self.growth.max().exp())
    }

    /// R, m; `pull` is A⁻¹(x − c).
    pub(super) fn value_m(&self, pull: &Vector3<f64>) -> f64 {
        let (_, _, growth) = self.shares(pull);
        self.length_m * growth.exp()
    }

    /// R, m, and ∂ ln R.
    pub(super) fn linearize(
        &self,
        pull: &Vector3<f64>,
        metaball: &Metaball,
    ) -> (f64, LengthSlopes) {
        let (u, q, growth) = self.shares(pull);
        let e = u.norm_squared() + self.smoothing;
        let by_u = u.zip_map(&self.growth, |u, g| 2.0 * u * (g - growth) / e);
        let slopes = LengthSlopes {
            place: metaball.precision * (self.axes_world * by_u),
            radii: q - 2.0 * u.component_mul(&by_u),
        };
        (self.length_m * growth.exp(), slopes)
    }

    /// u, q and G.
    fn shares(&self, pull: &Vector3<f64>) -> (Vector3<f64>, Vector3<f64>, f64) {
        let u = self.axes_world.tr_mul(pull);
        let e = u.norm_squared() + self.smoothing;
        let q = u.map(|u| (u * u + self.smoothing / 3.0) / e);
        (u, q, q.dot(&self.growth))
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Rotation3;

    use super::*;
    use crate::math::quadric::Ellipsoid;

    const MEAN: MeanLength = MeanLength { length_m: 0.1, radii: Vector3::new(0.05, 0.1, 0.2) };

    fn axes() -> Matrix3<f64> {
        Rotation3::from_scaled_axis(Vector3::new(0.4, -1.0, 0.3)).into_inner()
    }

    /// ln R and its slopes at an offset from the centre along the metaball's axes.
    fn at(radii: Vector3<f64>, offset: Vector3<f64>) -> (f64, LengthSlopes) {
        let ball = Metaball::new(Ellipsoid {
            centre: Vector3::zeros(),
            shape: axes()
                * Matrix3::from_diagonal(&radii.component_mul(&radii))
                * axes().transpose(),
        })
        .unwrap();
        let local = MEAN.with_radii(&radii, axes());
        let pull = ball.precision * (axes() * offset);
        let (length_m, slopes) = local.linearize(&pull, &ball);
        (length_m.ln(), slopes)
    }

    #[test]
    fn on_the_mean_body_it_is_the_same_everywhere() {
        for offset in [Vector3::zeros(), Vector3::new(0.1, -0.3, 0.0)] {
            let (length, slopes) = at(MEAN.radii, offset);
            approx::assert_relative_eq!(length.exp(), 0.1, max_relative = 1e-12);
            approx::assert_abs_diff_eq!(slopes.place.norm(), 0.0, epsilon = 1e-9);
        }
    }

    #[test]
    fn it_grows_with_the_radius_that_the_place_is_along() {
        let wide = Vector3::new(0.05, 0.2, 0.2);
        let along = |k: usize| at(wide, Vector3::ith(k, 1.0)).0.exp();
        approx::assert_relative_eq!(along(0), 0.1, max_relative = 0.02);
        approx::assert_relative_eq!(along(1), 0.2, max_relative = 0.02);
        approx::assert_relative_eq!(along(2), 0.1, max_relative = 0.05);
    }

    #[test]
    fn its_slopes_are_those_of_its_value() {
        let radii = Vector3::new(0.08, 0.06, 0.3);
        let step = 1e-6;
        for offset in [[0.0, 0.0, 1e-9], [0.02, 0.1, -0.2], [0.3, -0.01, 1.0]] {
            let offset = Vector3::from(offset);
            let (_, slopes) = at(radii, offset);
            let place = axes().tr_mul(&slopes.place);
            for k in 0..3 {
                let moved = |h: f64| at(radii, offset + Vector3::ith(k, h)).0;
                let numeric = (moved(step) - moved(-step)) / (2.0 * step);
                approx::assert_relative_eq!(place[k], numeric, epsilon = 1e-6, max_relative = 1e-6);
                let grown = |h: f64| {
                    let mut grown = radii;
                    grown[k] *= f64::exp(h);
                    at(grown, offset).0
                };
                let numeric = (grown(step) - grown(-step)) / (2.0 * step);
                approx::assert_relative_eq!(
                    slopes.radii[k],
                    numeric,
                    epsilon = 1e-7,
                    max_relative = 1e-6
                );
            }
        }
    }
}
