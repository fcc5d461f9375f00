//! The field and its derivatives in space at one point.
//!
//! With wᵢ = fᵢ/F and uᵢ = Aᵢ⁻¹(x − cᵢ):
//!
//! - ln F = −2 min d + ln Σ exp(−2 (dᵢ − min d)), which does not underflow;
//! - ∇ ln F = −4 Σ wᵢ uᵢ (PF02 App. A.1);
//! - ∇² ln F = Σ wᵢ (16 uᵢuᵢᵀ − 4 Aᵢ⁻¹) − ∇ ln F ∇ ln Fᵀ (PF02 eq. A.4).

use nalgebra::{Matrix3, Vector3};

use super::Field;

/// Metaballs whose fᵢ is less than e⁻³² of the largest are left out: half of that exponent.
pub(super) const NEGLIGIBLE: f64 = 16.0;

/// What one metaball contributes at a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Share {
    /// Index in [`Field::metaballs`].
    pub metaball: usize,
    /// w = f/F.
    pub weight: f64,
    /// u = A⁻¹(x − c), 1/m.
    pub pull: Vector3<f64>,
}

/// The field of one limb at one point, in logarithms.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct FieldSample {
    /// x.
    pub point_world: Vector3<f64>,
    /// The limb: index in [`Field::limbs`].
    pub limb: usize,
    /// ln F.
    pub log_value: f64,
    /// ∇ ln F, 1/m.
    pub log_gradient: Vector3<f64>,
    /// The metaballs that contribute.
    pub shares: Vec<Share>,
}

impl FieldSample {
    /// ∇² ln F, 1/m²; `field` is the one that was sampled.
    pub fn log_hessian(&self, field: &Field) -> Matrix3<f64> {
        let mut hessian = self.log_gradient * -self.log_gradient.transpose();
        for Share { metaball, weight, pull } in &self.shares {
            hessian += pull * (pull * (16.0 * weight)).transpose();
            hessian -= field.metaballs[*metaball].precision * (4.0 * weight);
        }
        hessian
    }

    /// The second derivative of ln F along a unit vector r, 1/m²: rᵀ ∇² ln F r.
    pub(crate) fn log_curvature(&self, field: &Field, r: &Vector3<f64>) -> f64 {
        let each = self.shares.iter().map(|Share { metaball, weight, pull }| {
            let precision = &field.metaballs[*metaball].precision;
            weight * (16.0 * pull.dot(r).powi(2) - 4.0 * r.dot(&(precision * r)))
        });
        each.sum::<f64>() - self.log_gradient.dot(r).powi(2)
    }

    /// The metaball of largest weight; `None` before any update.
    pub fn heaviest(&self) -> Option<usize> {
        let heavier = |a: &&Share, b: &&Share| a.weight.total_cmp(&b.weight);
        self.shares.iter().max_by(heavier).map(|s| s.metaball)
    }

    /// Samples the limb whose sum is largest; `false`, and nothing changed, if there is no metaball.
    pub fn update(&mut self, field: &Field, point_world: &Vector3<f64>) -> bool {
        let distance = |i: &usize| field.metaballs[*i].distance(point_world);
        let mut best: Option<(usize, f64)> = None;

        for (k, limb) in field.limbs.iter().enumerate() {
            let least = limb.iter().map(distance).fold(f64::INFINITY, f64::min);
            if least.is_finite() {
                let share = |i: &usize| (-2.0 * (distance(i) - least)).exp();
                let log_value = limb.iter().map(share).sum::<f64>().ln() - 2.0 * least;
                if best.is_none_or(|b| log_value > b.1) {
                    best = Some((k, log_value));
                }
            }
        }

        let Some((limb, _)) = best else { return false };
        self.update_limb(field, limb, point_world, &field.limbs[limb]);
        true
    }

    /// Samples one limb from those of its metaballs that `metaballs` lists.
    pub(crate) fn update_limb(
        &mut self,
        field: &Field,
        limb: usize,
        point_world: &Vector3<f64>,
        metaballs: &[usize],
    ) {
        self.limb = limb;
        self.point_world = *point_world;
        self.shares.clear();

        // d and u of each; the weight is d until the least is known
        let mut least = f64::INFINITY;
        for &metaball in metaballs {
            let ball = &field.metaballs[metaball];
            let offset = point_world - ball.ellipsoid.centre;
            let pull = ball.precision * offset;
            let distance = offset.dot(&pull);
            least = least.min(distance);
            self.shares.push(Share { metaball, weight: distance, pull });
        }

        // wᵢ times a common factor, which cancels
        self.shares.retain(|s| s.weight - least < NEGLIGIBLE);
        let mut sum = 0.0;
        for share in &mut self.shares {
            share.weight = (-2.0 * (share.weight - least)).exp();
            sum += share.weight;
        }

        self.log_value = sum.ln() - 2.0 * least;
        self.log_gradient = Vector3::zeros();
        for share in &mut self.shares {
            share.weight /= sum;
            self.log_gradient -= share.pull * (4.0 * share.weight);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::quadric::Ellipsoid;

    fn ball(x: f64) -> Ellipsoid {
        Ellipsoid { centre: Vector3::new(x, 0.0, 0.0), shape: Matrix3::identity() * 0.01 }
    }

    #[test]
    fn the_logarithm_is_right_where_the_field_underflows() {
        let field = Field::new([ball(0.0), ball(0.0)]);
        let x = Vector3::new(30.0, 0.0, 0.0);
        let sample = field.sample(&x).unwrap();
        assert!(sample.log_value.exp() < f64::MIN_POSITIVE);
        let expected = -2.0 * 900.0 / 0.01 + 2.0_f64.ln();
        approx::assert_relative_eq!(sample.log_value, expected, max_relative = 1e-14);
        approx::assert_relative_eq!(
            sample.log_gradient.x,
            -4.0 * 30.0 / 0.01,
            max_relative = 1e-14
        );
    }

    #[test]
    fn a_point_belongs_to_the_limb_whose_sum_is_largest() {
        let mut field = Field::new([ball(0.0), ball(0.1), ball(0.11)]);
        field.limbs = vec![vec![0], vec![1, 2], Vec::new()];
        let sample = field.sample(&Vector3::new(0.04, 0.0, 0.0)).unwrap();
        assert_eq!((sample.limb, sample.shares.len()), (1, 2));
        let beyond = field.sample(&Vector3::new(-0.01, 0.0, 0.0)).unwrap();
        assert_eq!((beyond.limb, beyond.heaviest()), (0, Some(0)));
    }

    #[test]
    fn the_curvature_along_a_line_is_that_of_the_matrix_of_second_derivatives() {
        let field = Field::new([ball(0.0), ball(0.1), ball(0.13)]);
        let sample = field.sample(&Vector3::new(0.05, 0.04, -0.02)).unwrap();
        for r in [Vector3::x(), Vector3::y(), Vector3::new(0.6, 0.0, -0.8)] {
            let expected = r.dot(&(sample.log_hessian(&field) * r));
            let found = sample.log_curvature(&field, &r);
            approx::assert_relative_eq!(found, expected, max_relative = 1e-12);
        }
    }

    #[test]
    fn no_metaball_has_no_sample() {
        assert_eq!(Field::new([]).sample(&Vector3::zeros()), None);
    }
}
