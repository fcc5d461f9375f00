//! Where the skin folds: about the joint of a hinge, such as knee and elbow.
//!
//! Flesh there follows both bones by shares that differ between people, garments and makers of bodies, and it folds. A metaball turns with
//! one bone. Flesh that follows the other by a share w which the model has not is moved by w θ h, where the joint is bent by θ and
//! lies h away. That is little, but it is the same whenever the joint is bent alike, and so it looks like a joint that lies elsewhere:
//! a skin that is the model's own, but follows both bones by the shares of their metaballs, misfits by 1 to 3 mm, and draws
//! the knee a centimetre backwards and down (see docs/decisions, 0032).
//!
//! So data that touch a fold say nothing in the joint optimum. A place lies in a fold where both bones' metaballs have more than
//! [`SHARE`] of the field. Where joint and bones are, is known from where each part moves as one. Which data lie in folds is decided
//! once, where a round of the optimum begins: E is the same function for all steps of a round. Decided at each step, E would
//! fall as folds grow.
//!
//! Ellipsoids share nothing, and meet in creases that no person has. Of them what lies within [`FOLD_M`] of the joint is in the fold: about as much
//! as of metaballs, 6 cm along the bone from a joint that lies 6 cm below the skin.

use nalgebra::Vector3;

use super::PlacedResidual;
use crate::body::metaball::{Field, FieldSample};
use crate::body::{BodyModel, PartId, Posed};

/// The least share of either bone: 10 cm from a joint that is bent by 1 rad, it moves the skin by 1 mm.
const SHARE: f64 = 0.01;

/// How far a fold of ellipsoids reaches from its joint.
const FOLD_M: f64 = 0.085;

/// The folds of a body of metaballs.
pub(super) struct Folds<'a> {
    model: &'a BodyModel,
    field: &'a Field,
    /// The two parts of each.
    pairs: Vec<(PartId, PartId)>,
}

impl<'a> Folds<'a> {
    pub(super) fn new(model: &'a BodyModel, field: &'a Field) -> Self {
        Self { model, field, pairs: model.folds() }
    }

    /// Whether a place lies in one.
    pub(super) fn contain(&self, sample: &FieldSample) -> bool {
        let share_of = |part: PartId| -> f64 {
            let is_own = |ball: usize| {
                self.field.source(ball).is_some_and(|i| self.model.metaballs[i].part == part)
            };
            let own = sample.shares.iter().filter(|share| is_own(share.metaball));
            own.map(|share| share.weight).sum()
        };
        self.pairs.iter().any(|(above, below)| share_of(*above).min(share_of(*below)) > SHARE)
    }
}

/// The folds of a body of ellipsoids.
pub(super) struct EllipsoidFolds {
    /// Each part that a joint folds, and where it is in the part's frame, metres.
    joints: Vec<(PartId, Vector3<f64>)>,
}

impl EllipsoidFolds {
    pub(super) fn new(body: &Posed<'_>) -> Self {
        let at_joint = |(above, below): (PartId, PartId)| {
            let joint = body.origin_of_part(below);
            [above, below].map(|part| (part, body.in_part(part, &joint)))
        };
        Self { joints: body.model.folds().into_iter().flat_map(at_joint).collect() }
    }

    /// Whether a residual was measured in one.
    pub(super) fn contain(&self, residual: &PlacedResidual) -> bool {
        let is_near = |(part, joint): &(PartId, Vector3<f64>)| {
            *part == residual.part && (residual.place_part - joint).norm() < FOLD_M
        };
        self.joints.iter().any(is_near)
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use nalgebra::Point3;

    use super::*;
    use crate::body::{Motion, Shape};
    use crate::likelihood::{PointField, PointOptions, SkinScale, Source, SurfacePoint, Term};

    /// How many of the points on a line along the right leg's front a term keeps, from a height to another above the knee.
    fn kept_between(model: &BodyModel, low_m: f64, high_m: f64) -> usize {
        let shape = Shape(model.statistics.mean.clone());
        let motion = Motion::straight(model);
        let body = Posed::new(model, &shape, &motion);
        let shank = model.parts.iter().position(|p| p.name == "shank_r").unwrap();
        let knee = body.origin_of_part(PartId(shank));
        let point = |i: i32| {
            let up_m = low_m + (high_m - low_m) * f64::from(i) / 10.0;
            SurfacePoint::isotropic(Point3::new(knee.x + 0.06, knee.y, knee.z + up_m), 0.002)
        };
        let points = (0..10).map(point).collect();
        let term = PointField::new(points, PointOptions::default(), SkinScale::new(model));
        let clear = term.clear(&body);
        let left = clear.term.map_or(10, |term| term.placed_residuals(&body).len());
        assert_eq!(clear.residuals.len(), left);
        left
    }

    #[test]
    fn points_about_the_knee_are_left_out_and_those_of_thigh_and_shank_stay() {
        let mut model = crate::io::model::load("human-metaballs", Path::new("")).unwrap();
        assert_eq!(kept_between(&model, -0.03, 0.03), 0);
        assert_eq!(kept_between(&model, 0.12, 0.2), 10);
        assert_eq!(kept_between(&model, -0.2, -0.12), 10);
        model.parts.iter_mut().for_each(|part| part.folds = false);
        assert_eq!(kept_between(&model, -0.03, 0.03), 10);
    }

    #[test]
    fn ellipsoids_fold_as_far_from_the_knee() {
        let model = crate::io::model::load("human-ellipsoids", Path::new("")).unwrap();
        let shape = Shape(model.statistics.mean.clone());
        let body = Posed::new(&model, &shape, &Motion::straight(&model));
        let folds = EllipsoidFolds::new(&body);
        let named = |name: &str| PartId(model.parts.iter().position(|p| p.name == name).unwrap());
        let knee = body.origin_of_part(named("shank_r"));
        // 6 cm before the leg's axis, so far above the knee
        let folds_at = |name: &str, up_m: f64| {
            let place = knee + Vector3::new(0.06, 0.0, up_m);
            folds.contain(&PlacedResidual {
                source: Source::View(0),
                value: 0.0,
                trust: 1.0,
                sigma: 1.0,
                weight: 1.0,
                outward_px: nalgebra::Vector2::x(),
                part: named(name),
                place_part: body.in_part(named(name), &place),
            })
        };
        assert!(folds_at("thigh_r", 0.05) && folds_at("shank_r", -0.05));
        assert!(!folds_at("thigh_r", 0.07) && !folds_at("shank_r", -0.07));
        assert!(!folds_at("thigh_l", 0.05) && !folds_at("foot_r", 0.0));
    }
}
