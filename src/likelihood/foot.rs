//! The nearest point of the skin: a true distance, and how it changes.
//!
//! The foot y of a point x on a limb's skin F = T is where the normal n = −∇F/‖∇F‖ points along x − y = r n; r is the signed
//! distance, positive outside. With L = ln F, g = ∇L, H = ∇²L and P = I − nnᵀ, the skin bends by S = −PHP/‖g‖ (dn = S dy along
//! it; positive where it is convex).
//!
//! **The foot** is found by Newton from x, two corrections at once in each step:
//!
//! - along n by (ψ − ψ_T)/‖∇ψ‖, ψ = √(c − ½L) as in [`SkinScale`](super::SkinScale): of one ball, ψ is nearly linear in the
//!   distance, so this is right from afar too;
//! - along the skin by M⁻¹ P(x − y), M = I + rS. Outside a convex limb M ≥ I. Inside, M is singular at the centres of curvature: its
//!   eigenvalues are taken by their size, [`LEAST_BEND`] at least, so that the way leads to a nearest point, not to a farthest. No
//!   step goes farther along the skin than half its least radius of curvature, beyond which the skin is not what S says: from
//!   afar, steps along a long limb went to and fro without that.
//!
//! From afar, both at once may go to and fro between places of a skin that bends much. So after twelve steps the way goes from place to
//! place of the skin itself, and only to nearer ones.
//!
//! **Derivatives.** y lies on the skin: ∂L + g·dy = 0, and dy = −dr n − r dn for a point that stays where it is. So
//!
//! dr/dθ = −(1/‖g‖) ∂L/∂θ,  dn = M⁻¹P v,  v = −(1/‖g‖)(∂g − H n dr),
//!
//! ∂ at the fixed place y: no iteration is differentiated. Whatever is made of r, n and y, and changes by A dr + q·dn + s·dy at most,
//! has one row of [`FieldSlopes`](crate::body::metaball::FieldSlopes): with q′ = q − r s and u = M⁻¹P q′,
//!
//! (A − s·n) dr + q′·dn = α ∂L + b·∂g,  α = −(A − s·n + u·Hn/‖g‖)/‖g‖,  b = −u/‖g‖.
//!
//! # Source
//! The gradient of a distance is the normal at the foot (envelope theorem); Newton and its rows are ours.

use nalgebra::{Matrix2, Matrix3, Matrix3x2, Vector2, Vector3};

use super::skin_distance::SkinScale;
use crate::body::metaball::{Field, FieldSample};

/// Steps at most of both corrections at once. Points within a limb's radius of the skin take four, those a metre away ten.
const MOST_STEPS: usize = 12;
/// Steps at most from place to place of the skin, of those that went to and fro.
const MOST_PLACES: usize = 40;
/// A way along the skin that leads no nearer is tried by halves, down to this share of it.
const LEAST_SHARE: f64 = 1e-3;
/// Of steps that are shorter than this, distances cannot tell whether they lead nearer, metres; Newton's do.
const SMALL_STEP_M: f64 = 1e-6;
/// Steps along n at most that lead to the skin.
const MOST_OUT: usize = 20;
/// A step that is shorter than this is not taken any more, metres: it errs the normal by itself over a radius, and what that changes
/// with the body is told by no derivative. At 1e-8 they were 1e-4 off.
const LAST_STEP_M: f64 = 1e-11;
/// Least size of an eigenvalue of M in a step.
const LEAST_BEND: f64 = 0.03;
/// No step along the skin turns the normal by more than this, rad.
const MOST_TURN: f64 = 0.5;
/// Least eigenvalue of M with which the normal's change is told; below it the point lies at a centre of curvature, where the
/// foot jumps.
const LEAST_TOLD: f64 = 0.02;
/// No step is longer, metres: ψ has no slope at the middle of a limb.
const LONGEST_M: f64 = 0.2;

/// The foot of a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Foot {
    /// r, metres.
    pub(super) distance_m: f64,
    /// n, outwards.
    pub(super) normal: Vector3<f64>,
}

/// A change A dr + q·dn + s·dy as one row: see the module.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct FootRow {
    /// α.
    pub(super) alpha: f64,
    /// b.
    pub(super) b: Vector3<f64>,
}

impl Foot {
    /// Moves a sample of a limb from a point to its foot; `metaballs` are those of the limb that count at both.
    pub(super) fn find(
        field: &Field,
        scale: &SkinScale,
        metaballs: &[usize],
        sample: &mut FieldSample,
    ) -> Option<Self> {
        let x = sample.point_world;
        let limb = sample.limb;
        let skin = Skin { field, scale, metaballs, limb };
        for step in 0..MOST_STEPS {
            let y = sample.point_world;
            let (normal, out_m) = skin.normal(sample);
            let distance_m = (x - y).dot(&normal) - out_m;
            let bend = Bend::new(field, sample, &normal);
            let along = bend.along_skin(&(x - y), distance_m);
            if out_m.abs().max(along.norm()) < LAST_STEP_M && step > 0 {
                return distance_m.is_finite().then_some(Self { distance_m, normal });
            }
            let sink_m = bend.sink_m(&along).clamp(-LONGEST_M, LONGEST_M);
            sample.update_limb(field, limb, &(y + normal * (out_m - sink_m) + along), metaballs);
        }
        skin.nearest(&x, sample)
    }

    /// The row of A dr + q·dn + s·dy; `sample` is that of the foot.
    pub(super) fn row(
        &self,
        field: &Field,
        sample: &FieldSample,
        a: f64,
        (q, s): (&Vector3<f64>, &Vector3<f64>),
    ) -> FootRow {
        let per_slope = 1.0 / sample.log_gradient.norm();
        let log_hessian = sample.log_hessian(field);
        let bend = Bend::of(&log_hessian, sample, &self.normal);
        let u = bend.inverse(&(q - s * self.distance_m), self.distance_m);
        let of_distance = a - s.dot(&self.normal) + u.dot(&(log_hessian * self.normal)) * per_slope;
        FootRow { alpha: -of_distance * per_slope, b: -u * per_slope }
    }
}

/// The skin of a limb.
struct Skin<'a> {
    field: &'a Field,
    scale: &'a SkinScale,
    metaballs: &'a [usize],
    limb: usize,
}

impl Skin<'_> {
    /// The outward normal at a sample, and the way along it to the skin, metres.
    fn normal(&self, sample: &FieldSample) -> (Vector3<f64>, f64) {
        let slope = sample.log_gradient.norm();
        let normal = sample.log_gradient.try_normalize(1e-9).map(|inwards| -inwards);
        let out_m = self.scale.way_to_skin_m(sample.log_value, slope).clamp(-LONGEST_M, LONGEST_M);
        // the middle of a limb has no normal: any way out will do
        (normal.unwrap_or_else(Vector3::z), out_m)
    }

    /// Moves a sample to a place, and from there along normals to the skin; the normal there.
    fn land(&self, place: &Vector3<f64>, sample: &mut FieldSample) -> Vector3<f64> {
        sample.update_limb(self.field, self.limb, place, self.metaballs);
        for _ in 0..MOST_OUT {
            let (normal, out_m) = self.normal(sample);
            if out_m.abs() < LAST_STEP_M {
                return normal;
            }
            let out = sample.point_world + normal * out_m;
            sample.update_limb(self.field, self.limb, &out, self.metaballs);
        }
        self.normal(sample).0
    }

    /// The foot of x, from place to place of the skin, each nearer to x than the one before.
    fn nearest(&self, x: &Vector3<f64>, sample: &mut FieldSample) -> Option<Foot> {
        let mut normal = self.land(&{ sample.point_world }, sample);
        for _ in 0..MOST_PLACES {
            let y = sample.point_world;
            let distance_m = (x - y).dot(&normal);
            let bend = Bend::new(self.field, sample, &normal);
            let whole = bend.along_skin(&(x - y), distance_m);
            let mut share = if whole.norm() < LAST_STEP_M { 0.0 } else { 1.0 };
            let is_nearer = |place: &Vector3<f64>| {
                whole.norm() < SMALL_STEP_M || (x - place).norm() <= (x - y).norm()
            };
            loop {
                if share < LEAST_SHARE {
                    // no place nearby is nearer
                    self.land(&y, sample);
                    return distance_m.is_finite().then_some(Foot { distance_m, normal });
                }
                let along = whole * share;
                let next = self.land(&(y + along - normal * bend.sink_m(&along)), sample);
                if is_nearer(&sample.point_world) {
                    normal = next;
                    break;
                }
                share *= 0.5;
            }
        }
        let distance_m = (x - sample.point_world).dot(&normal);
        distance_m.is_finite().then_some(Foot { distance_m, normal })
    }
}

/// How the skin bends at a place.
struct Bend {
    /// Two directions along the skin.
    tangents: Matrix3x2<f64>,
    /// S in them, 1/m.
    local: Matrix2<f64>,
    /// S, 1/m.
    shape: Matrix3<f64>,
}

impl Bend {
    fn new(field: &Field, sample: &FieldSample, normal: &Vector3<f64>) -> Self {
        Self::of(&sample.log_hessian(field), sample, normal)
    }

    /// The same, from ∇² ln F there.
    fn of(log_hessian: &Matrix3<f64>, sample: &FieldSample, normal: &Vector3<f64>) -> Self {
        let aside = if normal.x.abs() < 0.7 { Vector3::x() } else { Vector3::y() };
        let first = normal.cross(&aside);
        let first = first / first.norm();
        let tangents = Matrix3x2::from_columns(&[first, normal.cross(&first)]);
        let per_slope = 1.0 / sample.log_gradient.norm().max(1e-9);
        let local = -(tangents.transpose() * log_hessian * tangents) * per_slope;
        Self { shape: tangents * local * tangents.transpose(), tangents, local }
    }

    /// By how much the skin falls away below a step along it, metres.
    fn sink_m(&self, along: &Vector3<f64>) -> f64 {
        0.5 * along.dot(&(self.shape * along))
    }

    /// M⁻¹P of a vector, for a step.
    fn along_skin(&self, way: &Vector3<f64>, distance_m: f64) -> Vector3<f64> {
        let step = self.solve(way, distance_m, |m| 1.0 / m.abs().max(LEAST_BEND));
        let turn = step.norm() * self.local.norm();
        if turn > MOST_TURN { step * (MOST_TURN / turn) } else { step }
    }

    /// M⁻¹P of a vector; 0 across a direction in which the foot jumps.
    fn inverse(&self, way: &Vector3<f64>, distance_m: f64) -> Vector3<f64> {
        if *way == Vector3::zeros() {
            return *way;
        }
        self.solve(way, distance_m, |m| if m.abs() > LEAST_TOLD { 1.0 / m } else { 0.0 })
    }

    /// P of a vector, with each part along an eigenvector of M multiplied by a function of the eigenvalue.
    fn solve(
        &self,
        way: &Vector3<f64>,
        distance_m: f64,
        gain: impl Fn(f64) -> f64,
    ) -> Vector3<f64> {
        let along = self.tangents.tr_mul(way);
        let m = Matrix2::identity() + self.local * distance_m;

        // eigenvalues mean ± half, the first along (cos, sin) of half the angle
        let (mean, across) = (0.5 * (m.m11 + m.m22), Vector2::new(0.5 * (m.m11 - m.m22), m.m12));
        let half = across.norm();
        let (sin, cos) = (0.5 * across.y.atan2(across.x)).sin_cos();
        let first = Vector2::new(cos, sin);
        let second = Vector2::new(-sin, cos);
        let solved = first * (gain(mean + half) * first.dot(&along))
            + second * (gain(mean - half) * second.dot(&along));
        self.tangents * solved
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Rotation3;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::*;
    use crate::body::metaball::THRESHOLD;
    use crate::math::quadric::Ellipsoid;

    fn ellipsoid(centre: Vector3<f64>, radii: Vector3<f64>, turn: Vector3<f64>) -> Ellipsoid {
        let axes = Rotation3::from_scaled_axis(turn);
        let squared = Matrix3::from_diagonal(&radii.component_mul(&radii));
        Ellipsoid { centre, shape: axes * squared * axes.transpose() }
    }

    fn found(field: &Field, x: Vector3<f64>) -> (Foot, FieldSample) {
        let scale = SkinScale::of_field(field);
        let mut sample = field.sample(&x).unwrap();
        let foot = Foot::find(field, &scale, &field.limbs[0], &mut sample).unwrap();
        (foot, sample)
    }

    /// A limb of three overlapping balls.
    fn limb() -> Field {
        let ball = |x: f64| {
            ellipsoid(
                Vector3::new(x, 0.0, 0.0),
                Vector3::new(0.16, 0.08, 0.07),
                Vector3::new(0.0, 0.2, 0.1),
            )
        };
        Field::new([ball(-0.1), ball(0.0), ball(0.12)])
    }

    #[test]
    fn of_a_round_ball_it_is_the_distance_from_the_centre_less_the_radius() {
        let radius = 0.05;
        let full = radius / (0.5 * 2.0_f64.ln()).sqrt();
        let field =
            Field::new([ellipsoid(Vector3::zeros(), Vector3::repeat(full), Vector3::zeros())]);
        let way = Vector3::new(0.6, 0.0, -0.8);
        for distance in [1e-3, 0.02, 0.049, 0.051, 0.08, 0.3, 2.0] {
            let (foot, sample) = found(&field, way * distance);
            approx::assert_abs_diff_eq!(foot.distance_m, distance - radius, epsilon = 1e-9);
            approx::assert_abs_diff_eq!(foot.normal, way, epsilon = 1e-6);
            approx::assert_abs_diff_eq!(sample.log_value, THRESHOLD.ln(), epsilon = 1e-4);
        }
        assert!(found(&field, Vector3::zeros()).0.distance_m.is_finite());
    }

    #[test]
    fn no_place_of_the_skin_is_nearer() {
        let field = limb();
        let mut rng = ChaCha8Rng::seed_from_u64(4);
        let mut draw = |reach: f64| Vector3::from_fn(|_, _| rng.random_range(-reach..reach));
        let skin: Vec<Vector3<f64>> =
            (0..4000).map(|_| found(&field, draw(0.4)).1.point_world).collect();
        for _ in 0..200 {
            let x = draw(0.5);
            let (foot, _) = found(&field, x);
            if foot.distance_m < -0.03 {
                continue;
            }
            let nearest = skin.iter().map(|y| (x - y).norm()).fold(f64::INFINITY, f64::min);
            assert!(foot.distance_m.abs() < nearest + 1e-6, "{x} {foot:?} {nearest}");
            assert_eq!(foot.distance_m > 0.0, field.value(&x) < THRESHOLD, "{x}");
        }
    }

    #[test]
    fn its_row_is_its_change_when_the_point_moves() {
        // the body moving is the point moving the other way: ∂L = −g·d, ∂g = −H d for a body that moves by d
        let field = limb();
        let (q, s) = (Vector3::new(0.02, -0.01, 0.03), Vector3::new(0.4, 0.2, -0.3));
        for x in [[0.05, 0.1, 0.03], [0.2, 0.02, -0.05], [-0.1, 0.02, 0.025], [0.0, 0.6, 0.1]] {
            let x = Vector3::from(x);
            let (foot, sample) = found(&field, x);
            let row = foot.row(&field, &sample, 1.0, (&q, &s));
            for k in 0..3 {
                let d = Vector3::ith(k, 1.0);
                let analytic = row.alpha * -sample.log_gradient.dot(&d)
                    - row.b.dot(&(sample.log_hessian(&field) * d));
                let step = 1e-4;
                // in the world of the body the foot moves by dy − d
                let value = |h: f64| {
                    let (foot, sample) = found(&field, x - d * h);
                    let y = sample.point_world + d * h;
                    foot.distance_m + q.dot(&foot.normal) + s.dot(&y)
                };
                let numeric = (value(step) - value(-step)) / (2.0 * step);
                approx::assert_abs_diff_eq!(analytic, numeric, epsilon = 1e-3);
            }
        }
    }
}
