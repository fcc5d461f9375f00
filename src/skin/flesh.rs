//! The part of the field that one tube's skin belongs to.

use nalgebra::Vector3;

use super::plan::Chain;
use crate::body::metaball::{Field, THRESHOLD};
use crate::body::{PartId, Posed};

/// Step with which a ray looks for the skin, metres.
const STEP: f64 = 0.005;
/// How exactly the skin is found on a ray, metres.
const EXACT: f64 = 1e-6;
/// The farthest that a point is moved onto the skin, metres.
const FARTHEST: f64 = 0.02;

/// F of some limbs: the largest of their sums.
#[derive(Debug, Clone)]
pub(super) struct Flesh {
    limbs: Vec<Limb>,
}

/// The metaballs of one limb.
#[derive(Debug, Clone)]
struct Limb {
    /// Those of the chain.
    own: Field,
    /// Those of the part that the chain grows out of.
    base: Field,
}

/// The flesh that a tube is sampled in.
#[derive(Debug, Clone, Copy)]
pub(super) struct TubeFlesh<'a> {
    /// The tube's own.
    pub(super) own: &'a Flesh,
    /// That of the tube and of what it grows out of: for the joint between the two.
    pub(super) with_base: &'a Flesh,
}

/// Where a ray ended.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Hit {
    /// On the skin, at this distance.
    Skin(f64),
    /// Still in the flesh, at this distance: at its farthest, or where the flesh that the chain grows out of begins.
    Flesh(f64),
    /// It began outside.
    Nothing,
}

impl Flesh {
    /// The limbs that lie within a chain, or within it and the part that it grows out of.
    pub(super) fn new(body: &Posed<'_>, chain: &Chain) -> Self {
        let is_own = |part: &PartId| chain.parts.contains(part);
        let lies_within = |limb: &Vec<PartId>| {
            let known = |part: &PartId| is_own(part) || chain.base == Some(*part);
            limb.iter().any(is_own) && limb.iter().all(known)
        };

        let field = |parts: Vec<PartId>| {
            let balls = body.model.metaballs.iter();
            let used = balls.filter(|ball| parts.contains(&ball.part));
            Field::new(used.map(|ball| body.primitive(ball)))
        };

        let limbs = body.model.limbs().into_iter().filter(lies_within);
        let limbs = limbs.map(|limb| {
            let (own, base) = limb.into_iter().partition(is_own);
            Limb { own: field(own), base: field(base) }
        });
        Self { limbs: limbs.collect() }
    }

    /// This and other limbs.
    pub(super) fn with(&self, other: &Self) -> Self {
        Self { limbs: [self.limbs.clone(), other.limbs.clone()].concat() }
    }

    /// Without the part that it grows out of.
    pub(super) fn alone(&self) -> Self {
        let alone = |limb: &Limb| Limb { own: limb.own.clone(), base: Field::new([]) };
        Self { limbs: self.limbs.iter().map(alone).collect() }
    }

    /// F.
    pub(super) fn value(&self, point: &Vector3<f64>) -> f64 {
        let sums = self.limbs.iter().map(|limb| limb.own.value(point) + limb.base.value(point));
        sums.fold(0.0, f64::max)
    }

    /// F and ∇F.
    pub(super) fn value_and_gradient(&self, point: &Vector3<f64>) -> (f64, Vector3<f64>) {
        let sums = self.limbs.iter().map(|limb| {
            let own = limb.own.value_and_gradient(point);
            let base = limb.base.value_and_gradient(point);
            (own.0 + base.0, own.1 + base.1)
        });
        let larger = |a: (f64, _), b: (f64, _)| if b.0 > a.0 { b } else { a };
        sums.fold((0.0, Vector3::zeros()), larger)
    }

    /// The share of the chain's own metaballs in F.
    pub(super) fn own_share(&self, point: &Vector3<f64>) -> f64 {
        let own = self.limbs.iter().map(|limb| limb.own.value(point));
        own.fold(0.0, f64::max) / self.value(point).max(f64::MIN_POSITIVE)
    }

    /// Whether the flesh that the chain grows out of takes over here: it makes most of F, and F rises along the ray.
    fn ends_at(&self, point: &Vector3<f64>, ray: &Vector3<f64>) -> bool {
        self.own_share(point) < 0.5 && self.value_and_gradient(point).1.dot(ray) > 0.0
    }

    /// Casts a ray from within the flesh: to the skin, to where flesh that is not the chain's own begins, or to the
    /// distance `farthest`.
    pub(super) fn cast(&self, origin: &Vector3<f64>, ray: &Vector3<f64>, farthest: f64) -> Hit {
        if self.value(origin) < THRESHOLD {
            return Hit::Nothing;
        }

        let mut inside = 0.0;
        while inside < farthest {
            let next = (inside + STEP).min(farthest);
            let point = origin + ray * next;
            if self.value(&point) < THRESHOLD {
                return Hit::Skin(self.crossing(origin, ray, [inside, next]));
            }
            if self.ends_at(&point, ray) {
                return Hit::Flesh(next);
            }

            inside = next;
        }
        Hit::Flesh(farthest)
    }

    /// F = T between a distance inside and one outside: regula falsi that keeps its bracket (Illinois).
    fn crossing(&self, origin: &Vector3<f64>, ray: &Vector3<f64>, bracket: [f64; 2]) -> f64 {
        let excess = |t: f64| self.value(&(origin + ray * t)) - THRESHOLD;
        let [mut low, mut high] = bracket;
        let (mut above, mut below) = (excess(low), excess(high));

        for _ in 0..30 {
            let middle = low + (high - low) * above / (above - below);
            let value = excess(middle);
            if high - low < EXACT || value.abs() < 1e-9 {
                return middle;
            }

            // the end that stays has its value halved, else it would stay for ever
            if value > 0.0 {
                (low, above) = (middle, value);
                below *= 0.5;
            } else {
                (high, below) = (middle, value);
                above *= 0.5;
            }
        }
        0.5 * (low + high)
    }

    /// A point moved along ∇F onto the skin; `None` if that is more than 2 cm away, or nowhere.
    pub(super) fn settle(&self, point: &Vector3<f64>) -> Option<Vector3<f64>> {
        let mut moved = *point;
        for _ in 0..12 {
            let (value, gradient) = self.value_and_gradient(&moved);
            if (value - THRESHOLD).abs() < 1e-9 {
                break;
            }
            // Newton's step along ∇F, no longer than a ray's
            let slope = gradient.norm_squared();
            let step = gradient * ((THRESHOLD - value) / slope.max(1e-6));
            moved += step * (STEP / step.norm()).min(1.0);
        }

        let is_there = (self.value(&moved) - THRESHOLD).abs() < 1e-4;
        (is_there && (moved - point).norm() < FARTHEST).then_some(moved)
    }
}
