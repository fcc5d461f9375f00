//! The field of a posed body.

use nalgebra::{Matrix3, Vector3};

use super::FieldSample;
use crate::body::{PartId, Posed};
use crate::math::quadric::Ellipsoid;

/// One primitive of the field: an ellipsoidal Gaussian.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Metaball {
    /// Its ellipsoid d = 1. Alone, the metaball's skin is this ellipsoid shrunk by √(½ ln 2) ≈ 0.589.
    pub ellipsoid: Ellipsoid,
    /// A⁻¹ = (QS)ᵀ(QS) without its translation, 1/m².
    pub precision: Matrix3<f64>,
}

impl Metaball {
    /// The metaball of an ellipsoid; `None` if the ellipsoid is flat.
    pub fn new(ellipsoid: Ellipsoid) -> Option<Self> {
        let precision = ellipsoid.shape.cholesky()?.inverse();
        Some(Self { ellipsoid, precision })
    }

    /// d(x) = (x − c)ᵀ A⁻¹ (x − c), the algebraic ellipsoidal distance (PF02 eq. 6).
    pub fn distance(&self, point_world: &Vector3<f64>) -> f64 {
        let offset = point_world - self.ellipsoid.centre;
        offset.dot(&(self.precision * offset))
    }

    /// f = exp(−2 d) and ∇f = −4 f A⁻¹ (x − c) (PF02 eq. 4).
    fn value_and_gradient(&self, point_world: &Vector3<f64>) -> (f64, Vector3<f64>) {
        let offset = point_world - self.ellipsoid.centre;
        let scaled = self.precision * offset;
        let value = (-2.0 * offset.dot(&scaled)).exp();
        (value, scaled * (-4.0 * value))
    }
}

/// F of a body in one pose: the largest of its limbs' sums Σ fᵢ.
#[derive(Debug, Clone, PartialEq)]
pub struct Field {
    /// The primitives, in the model's order.
    pub metaballs: Vec<Metaball>,
    /// The metaballs of each limb, in the order of [`BodyModel::limbs`](crate::body::BodyModel::limbs).
    pub limbs: Vec<Vec<usize>>,
    /// For each metaball, its index in the list that the field was made from.
    pub(super) sources: Vec<usize>,
}

impl Field {
    /// The field of a posed body's metaballs.
    pub fn from_body(body: &Posed<'_>) -> Self {
        let primitives = &body.model.metaballs;
        let all = Self::new(primitives.iter().map(|m| body.primitive(m)));
        let balls_of = |parts: Vec<PartId>| {
            let is_there = |&i: &usize| parts.contains(&primitives[all.sources[i]].part);
            (0..all.metaballs.len()).filter(is_there).collect()
        };
        let limbs = body.model.limbs().into_iter().map(balls_of).collect();
        Self { limbs, ..all }
    }

    /// The field of the given ellipsoids d = 1, all in one limb; flat ones are left out.
    pub fn new(ellipsoids: impl IntoIterator<Item = Ellipsoid>) -> Self {
        let each = ellipsoids.into_iter().enumerate();
        let (sources, metaballs): (Vec<_>, Vec<_>) =
            each.filter_map(|(i, e)| Some((i, Metaball::new(e)?))).unzip();
        Self { limbs: vec![(0..metaballs.len()).collect()], metaballs, sources }
    }

    /// The index of a metaball in the list that the field was made from, such as
    /// [`BodyModel::metaballs`](crate::body::BodyModel::metaballs).
    pub fn source(&self, metaball: usize) -> Option<usize> {
        self.sources.get(metaball).copied()
    }

    /// F(x) = max over limbs of Σ exp(−2 dᵢ(x)); more than [`THRESHOLD`](super::THRESHOLD) inside the body.
    ///
    /// # Source
    /// PF02 eq. 3, 4; limbs: PFD99 § 3.3.
    pub fn value(&self, point_world: &Vector3<f64>) -> f64 {
        let value = |i: &usize| (-2.0 * self.metaballs[*i].distance(point_world)).exp();
        let sums = self.limbs.iter().map(|limb| limb.iter().map(value).sum());
        sums.fold(0.0, f64::max)
    }

    /// F(x) and ∇F(x) = −4 Σ fᵢ Aᵢ⁻¹ (x − cᵢ), 1/m, which points into the body.
    ///
    /// # Source
    /// PF02 eq. 3, 4, 6 and App. A.1; limbs: PFD99 § 3.3.
    pub fn value_and_gradient(&self, point_world: &Vector3<f64>) -> (f64, Vector3<f64>) {
        let sum = |limb: &Vec<usize>| {
            limb.iter()
                .map(|&i| self.metaballs[i].value_and_gradient(point_world))
                .fold((0.0, Vector3::zeros()), |sum, f| (sum.0 + f.0, sum.1 + f.1))
        };
        let larger = |a: (f64, Vector3<f64>), b: (f64, Vector3<f64>)| if b.0 > a.0 { b } else { a };
        let sums = self.limbs.iter().map(sum);
        sums.fold((0.0, Vector3::zeros()), larger)
    }

    /// ln F and its derivatives in the limb whose sum is largest; `None` without metaballs.
    ///
    /// In logarithms, so that nothing underflows far from the body.
    pub fn sample(&self, point_world: &Vector3<f64>) -> Option<FieldSample> {
        let mut sample = FieldSample::default();
        sample.update(self, point_world).then_some(sample)
    }

    /// A value that F hardly exceeds in any pose: 1.5 times the largest F at any metaball's centre, and at least 1.5.
    pub fn ceiling(&self) -> f64 {
        let centres = self.metaballs.iter().map(|m| m.ellipsoid.centre);
        1.5 * centres.map(|c| self.value(&c)).fold(1.0, f64::max)
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{DVector, Rotation3};
    use rand::{RngExt, SeedableRng};

    use super::*;
    use crate::body::metaball::THRESHOLD;
    use crate::math::central_differences;

    fn ellipsoid(centre: Vector3<f64>, radii: Vector3<f64>, turn: Vector3<f64>) -> Ellipsoid {
        let axes = Rotation3::from_scaled_axis(turn);
        let squared = Matrix3::from_diagonal(&radii.component_mul(&radii));
        Ellipsoid { centre, shape: axes * squared * axes.transpose() }
    }

    #[test]
    fn an_isolated_metaballs_skin_is_its_ellipsoid_shrunk_by_the_root_of_half_log_two() {
        let radii = Vector3::new(0.1, 0.2, 0.4);
        let turn = Vector3::new(0.3, -0.8, 0.5);
        let centre = Vector3::new(1.0, -2.0, 0.5);
        let field = Field::new([ellipsoid(centre, radii, turn)]);
        let shrink = (0.5 * 2.0_f64.ln()).sqrt();
        for (k, radius) in radii.iter().enumerate() {
            let axis = Rotation3::from_scaled_axis(turn) * Vector3::ith(k, 1.0);
            let on_skin = centre + axis * (radius * shrink);
            approx::assert_relative_eq!(field.value(&on_skin), THRESHOLD, epsilon = 1e-12);
        }
        approx::assert_relative_eq!(field.value(&centre), 1.0);
    }

    #[test]
    fn the_gradient_is_that_of_the_value() {
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(1);
        let mut draw = |low, high| Vector3::from_fn(|_, _| rng.random_range(low..high));
        let balls: Vec<_> =
            (0..4).map(|_| ellipsoid(draw(-0.2, 0.2), draw(0.1, 0.4), draw(-2.0, 2.0))).collect();
        let field = Field::new(balls);
        for _ in 0..20 {
            let point = draw(-0.3, 0.3);
            let (value, gradient) = field.value_and_gradient(&point);
            approx::assert_relative_eq!(value, field.value(&point), epsilon = 1e-14);
            let numeric = central_differences(3, 1e-3, |delta| {
                let moved = point + Vector3::new(delta[0], delta[1], delta[2]);
                DVector::from_element(1, field.value(&moved))
            });
            for (n, g) in numeric.iter().zip(&gradient) {
                approx::assert_relative_eq!(n, g, epsilon = 1e-8);
            }
        }
    }

    #[test]
    fn a_flat_ellipsoid_is_no_metaball() {
        let flat = Vector3::new(0.1, 0.0, 0.1);
        let field = Field::new([ellipsoid(Vector3::zeros(), flat, Vector3::zeros())]);
        assert!(field.metaballs.is_empty());
        approx::assert_relative_eq!(field.value(&Vector3::zeros()), 0.0);
    }
}
