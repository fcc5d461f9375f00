//! Where a line of sight comes closest to the skin of a limb: x* = argmax F on the ray (PF02 § 3.2).
//!
//! On the ray o + t r each distance is a parabola, dᵢ(t) = dᵢ₀ + aᵢ (t − tᵢ)². With P = Aᵢ⁻¹ and e = cᵢ − o:
//! aᵢ = rᵀPr, tᵢ = rᵀPe/aᵢ, dᵢ₀ = eᵀPe − aᵢ tᵢ²; Pe and eᵀPe are the same for all rays of a camera. So ln F
//! is a mixture in one dimension. It is climbed from the ball that the ray comes nearest to, first by mean
//! shift, t ← Σ w a tᵢ/Σ w a (a step that never lowers F), then by Newton.
//!
//! **Differs**: PF02 § 3.2 writes of the "lowest value" of F on the ray. Only the distance is lowest there; F is largest.

mod climb;

use std::ops::Range;

use nalgebra::Vector3;

use self::climb::{Bumps, LANES, climb, sum_of_summits};
use crate::body::metaball::Field;

/// Metaballs whose fᵢ is nowhere on the ray more than e⁻¹⁸, 10⁻⁸, of the largest summit move no contact that one could see: half of that
/// exponent.
const FAINT: f64 = 9.0;

/// A field as seen from one point. Its metaballs stand limb after limb, so that each limb is a run of numbers.
#[derive(Debug, Clone)]
pub(super) struct RayField {
    origin_world: Vector3<f64>,
    /// Index in [`Field::metaballs`].
    balls: Vec<usize>,
    /// The run of each limb.
    limbs: Vec<Range<usize>>,
    seen: SeenBalls,
    on_ray: Approach,
    /// The least dᵢ₀ of each limb.
    leasts: Vec<f64>,
    /// The metaballs of the limb that is being climbed.
    bumps: Bumps,
}

/// Metaballs as seen from a point: one number for each.
#[derive(Debug, Clone)]
struct SeenBalls {
    /// P: xx, yy, zz, xy, xz, yz.
    precision: [Vec<f64>; 6],
    /// Pe.
    pull: [Vec<f64>; 3],
    /// eᵀPe.
    constant: Vec<f64>,
}

/// How near a ray comes to each metaball.
#[derive(Debug, Clone)]
struct Approach {
    /// a.
    sharpness: Vec<f64>,
    /// tᵢ.
    at: Vec<f64>,
    /// dᵢ₀, infinite behind the origin.
    nearest: Vec<f64>,
}

impl RayField {
    pub(super) fn new(field: &Field, origin_world: Vector3<f64>) -> Self {
        const ENTRIES: [(usize, usize); 6] = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)];
        let balls: Vec<usize> = field.limbs.iter().flatten().copied().collect();
        let mut end = 0;
        let run = |limb: &Vec<usize>| {
            let start = end;
            end += limb.len();
            start..end
        };
        let limbs = field.limbs.iter().map(run).collect();

        let each = || balls.iter().map(|&ball| &field.metaballs[ball]);
        let precision = ENTRIES.map(|entry| each().map(|m| m.precision[entry]).collect());
        let offsets: Vec<_> = each().map(|m| m.ellipsoid.centre - origin_world).collect();
        let pulls: Vec<_> = each().zip(&offsets).map(|(m, offset)| m.precision * offset).collect();
        let constant = pulls.iter().zip(&offsets).map(|(pull, offset)| pull.dot(offset)).collect();

        let count = balls.len();
        Self {
            origin_world,
            balls,
            limbs,
            seen: SeenBalls {
                precision,
                pull: [0, 1, 2].map(|k| pulls.iter().map(|p| p[k]).collect()),
                constant,
            },
            on_ray: Approach {
                sharpness: vec![0.0; count],
                at: vec![0.0; count],
                nearest: vec![0.0; count],
            },
            leasts: Vec::with_capacity(field.limbs.len()),
            bumps: Bumps::default(),
        }
    }

    /// A point of the ray.
    pub(super) fn point(&self, direction: &Vector3<f64>, t: f64) -> Vector3<f64> {
        self.origin_world + direction * t
    }

    /// Turns to another ray; the limb that it comes nearest to, in units of its metaballs.
    ///
    /// Metaballs that the ray comes closest to behind its origin do not count; `None` if none is left.
    pub(super) fn turn_to(&mut self, direction: &Vector3<f64>) -> Option<usize> {
        approach(&self.seen, direction, &mut self.on_ray);
        let nearest = &self.on_ray.nearest;
        self.leasts.clear();
        self.leasts.extend(self.limbs.iter().map(|run| least(&nearest[run.clone()])));

        let nearer = |a: &usize, b: &usize| self.leasts[*a].total_cmp(&self.leasts[*b]);
        let nearest = (0..self.leasts.len()).min_by(nearer)?;
        self.leasts[nearest].is_finite().then_some(nearest)
    }

    /// Where on the ray the F of a limb is largest; `None` if no metaball of it is before the origin, or if ln F is known to be at
    /// most a value that is not `enough`.
    pub(super) fn contact(&mut self, limb: usize, enough: impl Fn(f64) -> bool) -> Option<f64> {
        let least = self.leasts[limb];
        let run = self.limbs[limb].clone();
        // nowhere is F more than the sum of all summits
        if !least.is_finite() || !enough((run.len() as f64).ln() - 2.0 * least) {
            return None;
        }

        // the metaballs that are not too faint at the nearest one
        let start = self.gather(run, least);
        if !enough(sum_of_summits(&mut self.bumps).ln() - 2.0 * least) {
            return None;
        }
        let summit = climb(&mut self.bumps, start);
        enough(summit.log_value - 2.0 * least).then_some(summit.at)
    }

    /// Gathers the metaballs of a run that are not too faint beside the nearest one, whose place is returned.
    fn gather(&mut self, run: Range<usize>, least: f64) -> f64 {
        let on_ray = &self.on_ray;
        self.bumps.clear();
        let mut start = 0.0;
        for i in run {
            let nearest = on_ray.nearest[i] - least;
            if nearest >= FAINT {
                continue;
            }
            self.bumps.push(nearest, on_ray.at[i], on_ray.sharpness[i]);
            if nearest <= 0.0 {
                start = on_ray.at[i];
            }
        }
        self.bumps.fill();
        start
    }

    /// The metaballs of a limb that contribute where the present ray touches it.
    pub(super) fn near(&self, limb: usize, near: &mut Vec<usize>) {
        let reach = self.leasts[limb] + FAINT;
        let run = self.limbs[limb].clone();
        let all = self.balls[run.clone()].iter().zip(&self.on_ray.nearest[run]);
        near.clear();
        near.extend(all.filter(|(_, nearest)| **nearest < reach).map(|(ball, _)| *ball));
    }
}

/// How near a ray comes to every metaball. The bits are the same for every instruction set; only the width of the loop differs.
#[multiversion::multiversion(targets("x86_64+avx2"))]
fn approach(balls: &SeenBalls, direction: &Vector3<f64>, on_ray: &mut Approach) {
    let (x, y, z) = (direction.x, direction.y, direction.z);
    let squares = [x * x, y * y, z * z, 2.0 * x * y, 2.0 * x * z, 2.0 * y * z];

    // slices of one length: the loop needs no checks of bounds and is vectorised
    let n = balls.constant.len();
    let [p0, p1, p2, p3, p4, p5] = balls.precision.each_ref().map(|p| &p[..n]);
    let [q0, q1, q2] = balls.pull.each_ref().map(|p| &p[..n]);
    let constant = &balls.constant[..n];
    let (sharpness, at) = (&mut on_ray.sharpness[..n], &mut on_ray.at[..n]);
    let nearest = &mut on_ray.nearest[..n];

    for i in 0..n {
        let a = (p0[i] * squares[0] + p1[i] * squares[1] + p2[i] * squares[2])
            + (p3[i] * squares[3] + p4[i] * squares[4] + p5[i] * squares[5]);
        let along = q0[i] * x + q1[i] * y + q2[i] * z;
        let t = along / a;
        sharpness[i] = a;
        at[i] = t;
        let d = constant[i] - along * t;
        nearest[i] = if t > 0.0 { d } else { f64::INFINITY };
    }
}

/// The least of some numbers, none of which is NaN.
fn least(numbers: &[f64]) -> f64 {
    let lesser = |a: f64, b: f64| if b < a { b } else { a };
    let (blocks, rest) = numbers.as_chunks::<LANES>();
    let mut lanes = [f64::INFINITY; LANES];
    for block in blocks {
        lanes = std::array::from_fn(|k| lesser(lanes[k], block[k]));
    }
    lanes.into_iter().chain(rest.iter().copied()).fold(f64::INFINITY, lesser)
}

#[cfg(test)]
mod tests {
    use nalgebra::{Matrix3, Unit};
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::*;
    use crate::math::quadric::Ellipsoid;

    fn balls(rng: &mut ChaCha8Rng, count: usize) -> Field {
        let ball = |_| {
            let mut draw = |reach: f64| Vector3::from_fn(|_, _| rng.random_range(-reach..reach));
            let root = Matrix3::from_columns(&[draw(0.1), draw(0.1), draw(0.1)]);
            Ellipsoid {
                centre: Vector3::new(4.0, 0.0, 1.0) + draw(0.3),
                shape: root * root.transpose() + Matrix3::identity() * 2e-3,
            }
        };
        Field::new((0..count).map(ball).collect::<Vec<_>>())
    }

    #[test]
    fn at_the_contact_the_field_rises_in_no_direction_of_the_ray() {
        let mut rng = ChaCha8Rng::seed_from_u64(80);
        for _ in 0..300 {
            let field = balls(&mut rng, 12);
            let mut rays = RayField::new(&field, Vector3::new(0.0, 0.0, 1.0));
            let aside = |rng: &mut ChaCha8Rng| rng.random_range(-0.1..0.1);
            let direction = Vector3::new(1.0, aside(&mut rng), aside(&mut rng));
            let direction = Unit::new_normalize(direction).into_inner();
            let limb = rays.turn_to(&direction).unwrap();
            let t = rays.contact(limb, |_| true).unwrap();
            let sample = field.sample(&rays.point(&direction, t)).unwrap();
            let slope = sample.log_gradient.dot(&direction);
            let bend = direction.dot(&(sample.log_hessian(&field) * direction));
            assert!((slope / bend).abs() < 1e-8 && bend < 0.0, "{slope} {bend}");
        }
    }

    #[test]
    fn the_contact_is_where_marching_finds_the_highest_of_each_limb() {
        let mut rng = ChaCha8Rng::seed_from_u64(81);
        for _ in 0..100 {
            let mut field = balls(&mut rng, 7);
            // one ball has one summit
            field.limbs = (0..7).map(|i| vec![i]).chain([Vec::new()]).collect();
            let origin = Vector3::new(0.0, 0.0, 1.0);
            let mut rays = RayField::new(&field, origin);
            let direction = Vector3::new(1.0, rng.random_range(-0.1..0.1), 0.02);
            let nearest = rays.turn_to(&direction).unwrap();

            let mut values = Vec::new();
            for limb in 0..7 {
                let alone = Field::new([field.metaballs[limb].ellipsoid]);
                let at = |t: f64| alone.sample(&(origin + direction * t)).unwrap().log_value;
                let marched = (0..1000).map(|i| at(3.0 + 2e-3 * f64::from(i)));
                let highest = marched.fold(f64::NEG_INFINITY, f64::max);
                let found = at(rays.contact(limb, |_| true).unwrap());
                assert!(found >= highest, "{found} {highest}");
                values.push(found);

                // and what is said to be the most is no less
                assert!(rays.contact(limb, |most| most >= found - 1e-9).is_some());
                assert!(rays.contact(limb, |most| most > found + 1e-9).is_none());
            }
            assert!(values.iter().all(|value| *value <= values[nearest]), "{values:?}");
            assert_eq!(rays.contact(7, |_| true), None);
        }
    }

    #[test]
    fn what_is_behind_the_camera_has_no_contact() {
        let field = balls(&mut ChaCha8Rng::seed_from_u64(82), 5);
        let mut rays = RayField::new(&field, Vector3::new(6.0, 0.0, 1.0));
        assert_eq!(rays.turn_to(&Vector3::x()), None);
    }
}
