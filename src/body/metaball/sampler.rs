//! The field at many points: distances to all metaballs at once, then only the metaballs that contribute.

use nalgebra::Vector3;

use super::sample::NEGLIGIBLE;
use super::{Field, FieldSample};

/// d of a limb's nearest metaball below which a point counts as near its skin, where d of a metaball alone is 0.35. There the skin of
/// a metaball that is left out is farther away than that of the nearest, even if its radii are a tenth of the nearest's.
const NEAR: f64 = 0.8;

/// A field laid out for sampling at many points: one array for each number of a metaball.
#[derive(Debug, Clone)]
pub struct Sampler<'f> {
    field: &'f Field,
    /// A⁻¹: xx, yy, zz, xy, xz, yz.
    precision: [Vec<f64>; 6],
    centre: [Vec<f64>; 3],
    /// d at the current point.
    distances: Vec<f64>,
    near: Vec<usize>,
}

impl<'f> Sampler<'f> {
    /// Lays out a field.
    pub fn new(field: &'f Field) -> Self {
        const ENTRIES: [(usize, usize); 6] = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)];
        let balls = || field.metaballs.iter();
        Self {
            field,
            precision: ENTRIES.map(|entry| balls().map(|m| m.precision[entry]).collect()),
            centre: [0, 1, 2].map(|k| balls().map(|m| m.ellipsoid.centre[k]).collect()),
            distances: vec![0.0; field.metaballs.len()],
            near: Vec::new(),
        }
    }

    /// Samples the limb whose sum is largest; `false`, and nothing changed, if there is no metaball.
    pub fn sample(&mut self, point_world: &Vector3<f64>, sample: &mut FieldSample) -> bool {
        self.measure(point_world);
        let Some((limb, least)) = self.largest() else {
            return false;
        };

        let reach = least + NEGLIGIBLE;
        let contributes = |i: &&usize| self.distances[**i] < reach;
        self.near.clear();
        self.near.extend(self.field.limbs[limb].iter().filter(contributes));
        sample.update_limb(self.field, limb, point_world, &self.near);
        true
    }

    /// Measures a point for [`limb_value`](Self::limb_value) and [`sample_limb`](Self::sample_limb).
    pub fn turn_to(&mut self, point_world: &Vector3<f64>) {
        self.measure(point_world);
    }

    /// ln F of a limb at the point that was measured, and its largest metaball there; `None` for a limb without metaballs.
    pub fn limb_value(&self, limb: usize) -> Option<(f64, usize)> {
        let (_, least) = self.least(limb)?;
        let nearest = self.field.limbs[limb].iter().find(|i| self.distances[**i] <= least)?;
        Some((self.log_sum(limb, least), *nearest))
    }

    /// Samples a limb at the point that was measured. It returns the metaballs that count there and at the nearest place of the skin:
    /// of a point far from the skin all of the limb's.
    pub fn sample_limb(
        &mut self,
        limb: usize,
        point_world: &Vector3<f64>,
        sample: &mut FieldSample,
    ) -> &[usize] {
        let least = self.least(limb).map_or(f64::INFINITY, |(_, least)| least);
        let reach = if least < NEAR { least + NEGLIGIBLE } else { f64::INFINITY };
        let distances = &self.distances;
        self.near.clear();
        self.near.extend(self.field.limbs[limb].iter().filter(|i| distances[**i] < reach));
        sample.update_limb(self.field, limb, point_world, &self.near);
        &self.near
    }

    /// d of every metaball.
    fn measure(&mut self, point_world: &Vector3<f64>) {
        let n = self.distances.len();
        let [p0, p1, p2, p3, p4, p5] = self.precision.each_ref().map(|p| &p[..n]);
        let [c0, c1, c2] = self.centre.each_ref().map(|c| &c[..n]);
        let distances = &mut self.distances[..n];
        for i in 0..n {
            let x = point_world.x - c0[i];
            let y = point_world.y - c1[i];
            let z = point_world.z - c2[i];
            distances[i] = x * (p0[i] * x + 2.0 * (p3[i] * y + p4[i] * z))
                + y * (p1[i] * y + 2.0 * p5[i] * z)
                + z * p2[i] * z;
        }
    }

    /// A limb and its least d.
    fn least(&self, limb: usize) -> Option<(usize, f64)> {
        let balls = self.field.limbs.get(limb)?.iter();
        let least = balls.map(|&i| self.distances[i]).fold(f64::INFINITY, f64::min);
        least.is_finite().then_some((limb, least))
    }

    /// The limb whose sum is largest, and its least d.
    fn largest(&self) -> Option<(usize, f64)> {
        let limbs = 0..self.field.limbs.len();
        let first = limbs.filter_map(|l| self.least(l)).min_by(|a, b| a.1.total_cmp(&b.1))?;

        // the sums of the other limbs, where they could be larger
        let mut best = (first, self.log_sum(first.0, first.1));
        for limb in 0..self.field.limbs.len() {
            let Some(other) = self.least(limb).filter(|l| l.0 != first.0) else {
                continue;
            };
            // no sum is more than that of all its balls at the least distance
            let most = (self.field.limbs[limb].len() as f64).ln() - 2.0 * other.1;
            if most > best.1 {
                let value = self.log_sum(other.0, other.1);
                if value > best.1 {
                    best = (other, value);
                }
            }
        }
        Some(best.0)
    }

    /// ln F of a limb, whose least d is `least`.
    fn log_sum(&self, limb: usize, least: f64) -> f64 {
        let far = |i: &usize| self.distances[*i] - least;
        let balls = self.field.limbs[limb].iter().map(far);
        let near = balls.filter(|d| *d < NEGLIGIBLE);
        near.map(|d| (-2.0 * d).exp()).sum::<f64>().ln() - 2.0 * least
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Matrix3;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::*;
    use crate::math::quadric::Ellipsoid;

    #[test]
    fn it_samples_what_the_field_says() {
        let mut rng = ChaCha8Rng::seed_from_u64(90);
        let mut draw = |reach: f64| Vector3::from_fn(|_, _| rng.random_range(-reach..reach));
        let ball = |draw: &mut dyn FnMut(f64) -> Vector3<f64>| {
            let root = Matrix3::from_columns(&[draw(0.2), draw(0.2), draw(0.2)]);
            Ellipsoid {
                centre: draw(0.5),
                shape: root * root.transpose() + Matrix3::identity() * 1e-3,
            }
        };
        let balls: Vec<_> = (0..10).map(|_| ball(&mut draw)).collect();
        let mut field = Field::new(balls);
        field.limbs = vec![vec![0, 1, 2, 3], vec![4, 5, 0], Vec::new(), vec![6, 7, 8, 9]];
        let mut sampler = Sampler::new(&field);
        let mut sample = FieldSample::default();
        for _ in 0..200 {
            let x = draw(1.0);
            assert!(sampler.sample(&x, &mut sample));
            let expected = field.sample(&x).unwrap();
            assert_eq!(sample.limb, expected.limb);
            approx::assert_relative_eq!(
                sample.log_value,
                expected.log_value,
                max_relative = 1e-12,
                epsilon = 1e-12
            );
            approx::assert_relative_eq!(
                sample.log_hessian(&field),
                expected.log_hessian(&field),
                max_relative = 1e-9,
                epsilon = 1e-6
            );
        }
        assert!(!Sampler::new(&Field::new([])).sample(&Vector3::zeros(), &mut sample));
    }
}
