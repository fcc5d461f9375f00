//! From the field at a point to a residual.
//!
//! *Field* (PF02 eq. 7): T − F, which far outside stays at T with no slope. It is divided by the slope that F
//! has at the skin of a limb of radius 5 cm (ln 2 / 5 cm), so that its σ is in metres like the other's.
//!
//! *Metric*: ψ = √(c − ½ ln F) is, for one metaball, a distance over the radius, and grows without bound. A plain
//! √(−½ ln F) ends where balls overlap and F > 1; so c = ½ ln A, with an A that F never reaches. With ψ_T for ψ
//! at the skin, r = (ψ − ψ_T)·R is a distance in metres near the skin, positive outside. R is the local
//! length, Σ wᵢ Rᵢ over the metaballs there ([`local_length`](super::local_length)): on the mean body 1/‖∇ψ‖ at the skin
//! around metaball i, and longer where the radius along the skin's normal is longer. With L = ln F: ∂ψ = −∂L/(4ψ),
//! ∂wᵢ = wᵢ (∂ ln fᵢ − ∂L), so that
//!
//! ∂r = Σ wᵢ (αᵢ ∂ ln fᵢ + γᵢ ∂ ln Rᵢ), αᵢ = −R/(4ψ) + (ψ − ψ_T)(Rᵢ − R), γᵢ = (ψ − ψ_T) Rᵢ.
//!
//! To divide by ‖∇ψ‖ at the point, instead of by a constant, would give the exact first-order distance but a bad
//! residual: a fit can lower it by moving to where ψ is steep. Fits to lines of sight then ended in many local minima.

use nalgebra::{Matrix3, Vector3};

use super::local_length::{LocalLength, MeanLength};
use crate::body::metaball::{BallChange, Field, FieldSample, Share, THRESHOLD};
use crate::body::{BodyModel, Motion, Posed, Shape};

/// Which residual.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Residual {
    /// PF02 eq. 7: T − F, over the slope of a limb of radius 5 cm.
    Field,
    /// Distance to the skin, metres.
    Metric,
}

/// Which derivatives (PF02 App. A.2).
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Derivatives {
    /// All: the gradient is that of the cost.
    Complete,
    /// PF02 App. A.2's simpler variant: as if neither the contact on a ray moved nor the local length changed.
    FirstOrder,
}

/// The radius of the limb whose slope scales the field's residual, m.
const FIELD_RADIUS_M: f64 = 0.05;

/// Least ψ²: below it F is more than its ceiling, and ψ stays constant.
const LEAST_SQUARE: f64 = 1e-3;

/// The constants of a model that turn its field into metres.
#[derive(Debug, Clone, PartialEq)]
pub struct SkinScale {
    /// c.
    offset: f64,
    /// ψ_T.
    at_skin: f64,
    /// Of each of [`BodyModel::metaballs`].
    balls: Vec<MeanLength>,
}

/// The scale of a body in one pose.
#[derive(Debug, Clone)]
pub(super) struct PosedScale<'a> {
    scale: &'a SkinScale,
    /// Of each of [`Field::metaballs`].
    balls: Vec<LocalLength>,
    /// Of each of [`Field::limbs`].
    limbs: Vec<LimbScale>,
}

/// Bounds of what is the same all over a limb, m.
#[derive(Debug, Clone, Copy)]
struct LimbScale {
    /// The least R and the greatest.
    lengths_m: (f64, f64),
    /// By how much offsets may make r less than that of the model's surface.
    most_outside_m: f64,
}

/// r grows faster than the distance where R, a mean over all directions, is more than the length along the normal.
const STEEPEST: f64 = 2.0;

/// r, and ∂r = Σ wᵢ (αᵢ ∂ ln fᵢ + γᵢ ∂ ln Rᵢ): see [`PosedScale::change`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct SkinResidual {
    /// r, metres, positive outside.
    pub(super) distance_m: f64,
    /// αᵢ without γᵢ, metres.
    pub(super) alpha: f64,
    /// γᵢ/Rᵢ: ψ − ψ_T.
    pub(super) gamma: f64,
}

impl SkinScale {
    /// Measures a model's mean shape at rest.
    pub fn new(model: &BodyModel) -> Self {
        let shape = Shape(model.statistics.mean.clone());
        let rest = Motion::rest(model);
        let body = Posed::new(model, &shape, &rest);
        let field = Field::from_body(&body);
        let scale = Self::of_field(&field);

        // R̄ and ā of every metaball; one that is nowhere at the skin keeps the length of a common limb
        let primitives = model.metaballs.iter();
        let mut balls: Vec<MeanLength> = primitives
            .map(|m| MeanLength { length_m: FIELD_RADIUS_M, radii: body.primitive_radii(m) })
            .collect();
        for ball in 0..field.metaballs.len() {
            let Some(source) = field.source(ball) else {
                continue;
            };
            let axes = body.primitive_axes(&model.metaballs[source]);
            if let Some(slope) = skin_slope(&field, ball, &axes) {
                balls[source].length_m = 4.0 * scale.at_skin / slope;
            }
        }

        Self { balls, ..scale }
    }

    /// c and ψ_T alone.
    pub(super) fn of_field(field: &Field) -> Self {
        let offset = 0.5 * field.ceiling().ln();
        let at_skin = (offset - 0.5 * THRESHOLD.ln()).max(LEAST_SQUARE).sqrt();
        Self { offset, at_skin, balls: Vec::new() }
    }

    /// How far outwards the skin is from a place by ψ's value and slope there; ‖∇L‖ is `slope`.
    pub(super) fn way_to_skin_m(&self, log_value: f64, slope: f64) -> f64 {
        let (psi, _) = self.psi(log_value);
        let per_m = 0.25 * slope.max(1e-9) / psi;
        (self.at_skin - psi) / per_m
    }

    /// ψ and ∂ψ/∂L.
    fn psi(&self, log_value: f64) -> (f64, f64) {
        let square = self.offset - 0.5 * log_value;
        let psi = square.max(LEAST_SQUARE).sqrt();
        (psi, if square > LEAST_SQUARE { -0.25 / psi } else { 0.0 })
    }

    /// The scale of a body in a pose; `field` is the body's.
    pub(super) fn posed(&self, body: &Posed<'_>, field: &Field) -> PosedScale<'_> {
        let local_length = |ball: usize| {
            let source = field.source(ball)?;
            let (mean, primitive) = (self.balls.get(source)?, body.model.metaballs.get(source)?);
            let radii = body.primitive_radii(primitive);
            Some(mean.with_radii(&radii, body.primitive_axes(primitive)))
        };
        let balls: Vec<LocalLength> = (0..field.metaballs.len()).filter_map(local_length).collect();

        let limb = |limb: &Vec<usize>| {
            let ranges = limb.iter().filter_map(|&ball| Some(balls.get(ball)?.range_m()));
            let offset_m = |&ball: &usize| {
                let primitive = body.model.metaballs.get(field.source(ball)?)?;
                Some(body.greatest_offset_m(primitive.part))
            };
            LimbScale {
                lengths_m: ranges.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1))).unwrap_or_default(),
                most_outside_m: STEEPEST * limb.iter().filter_map(offset_m).fold(0.0, f64::max),
            }
        };
        let limbs = field.limbs.iter().map(limb).collect();
        PosedScale { scale: self, balls, limbs }
    }
}

impl PosedScale<'_> {
    /// The residual at a sampled point.
    pub(super) fn residual(
        &self,
        kind: Residual,
        derivatives: Derivatives,
        sample: &FieldSample,
    ) -> SkinResidual {
        match kind {
            Residual::Field => field_residual(sample.log_value),
            Residual::Metric => self.metric_residual(derivatives, sample),
        }
    }

    /// About how far a place is from the skin of a limb: by ln F and the ball that is largest there, m.
    pub(super) fn about_m(&self, log_value: f64, ball: usize) -> f64 {
        let (least_m, greatest_m) = self.balls[ball].range_m();
        (self.scale.psi(log_value).0 - self.scale.at_skin) * 0.5 * (least_m + greatest_m)
    }

    /// The constants of the model.
    pub(super) fn of_model(&self) -> &SkinScale {
        self.scale
    }

    /// A bound below which no residual of a limb lies where its ln F is not more than this.
    pub(super) fn least_m(&self, kind: Residual, limb: usize, most_log_value: f64) -> f64 {
        let LimbScale { lengths_m, most_outside_m } = self.limbs[limb];
        let of_model_m = match kind {
            Residual::Field => field_residual(most_log_value).distance_m,
            Residual::Metric => {
                let past = self.scale.psi(most_log_value).0 - self.scale.at_skin;
                past * if past > 0.0 { lengths_m.0 } else { lengths_m.1 }
            }
        };
        of_model_m - most_outside_m
    }

    /// The residual's derivatives in what can change of a metaball.
    pub(super) fn change(
        &self,
        residual: &SkinResidual,
        field: &Field,
        share: &Share,
    ) -> BallChange {
        if residual.gamma.abs() < f64::MIN_POSITIVE {
            return BallChange { alpha: residual.alpha, ..BallChange::default() };
        }

        let local = &self.balls[share.metaball];
        let (length_m, slopes) = local.linearize(&share.pull, &field.metaballs[share.metaball]);
        let gamma = residual.gamma * length_m;
        BallChange {
            alpha: residual.alpha + gamma,
            place: slopes.place * gamma,
            radii: slopes.radii * gamma,
        }
    }

    fn metric_residual(&self, derivatives: Derivatives, sample: &FieldSample) -> SkinResidual {
        let (psi, slope) = self.scale.psi(sample.log_value);

        // R
        let each = sample.shares.iter();
        let length: f64 = each.map(|s| s.weight * self.balls[s.metaball].value_m(&s.pull)).sum();

        let past = psi - self.scale.at_skin;
        let gamma = match derivatives {
            Derivatives::Complete => past,
            Derivatives::FirstOrder => 0.0,
        };
        SkinResidual { distance_m: past * length, alpha: length * (slope - gamma), gamma }
    }
}

fn field_residual(log_value: f64) -> SkinResidual {
    let metres = FIELD_RADIUS_M / std::f64::consts::LN_2;
    // a point deep inside, in an impossible pose, must not give an infinite residual
    let value = log_value.min(50.0).exp();
    SkinResidual { distance_m: (THRESHOLD - value) * metres, alpha: -value * metres, gamma: 0.0 }
}

/// Mean ‖∇ ln F‖ where the axes of a metaball meet the skin, 1/m; `None` if none does.
///
/// An axis that meets the skin where another metaball is larger counts only if all axes do.
fn skin_slope(field: &Field, ball: usize, axes: &Matrix3<f64>) -> Option<f64> {
    let centre = field.metaballs[ball].ellipsoid.centre;
    let ways = (0..6).map(|k| axes.column(k / 2) * if k % 2 == 0 { 1.0 } else { -1.0 });
    let met: Vec<_> = ways.filter_map(|way| skin_along(field, &centre, &way)).collect();

    let is_own = |s: &&FieldSample| s.heaviest() == Some(ball);
    let own: Vec<_> = met.iter().filter(is_own).collect();
    let places = if own.is_empty() { met.iter().collect() } else { own };

    let slope = places.iter().map(|s| s.log_gradient.norm()).sum::<f64>() / places.len() as f64;
    (slope.is_finite() && slope > 0.0).then_some(slope)
}

/// Step and reach of the walk to the skin, m.
const STEP_M: f64 = 0.004;
const REACH_M: f64 = 0.6;

/// The field where a walk from a point first leaves the body.
fn skin_along(field: &Field, from: &Vector3<f64>, direction: &Vector3<f64>) -> Option<FieldSample> {
    let steps = (REACH_M / STEP_M) as usize;
    let mut walk = (0..steps).map(|i| from + direction * (i as f64 * STEP_M));
    let outside = walk.find(|x| field.value(x) < THRESHOLD)?;
    field.sample(&(outside - direction * (0.5 * STEP_M)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::quadric::Ellipsoid;

    /// One round metaball whose skin has this radius, and its scale.
    fn ball(radius: f64) -> (Field, SkinScale) {
        let squared = 2.0 * radius * radius / std::f64::consts::LN_2;
        let field = Field::new([Ellipsoid {
            centre: Vector3::zeros(),
            shape: Matrix3::identity() * squared,
        }]);
        let offset = 0.5 * 3.0_f64.ln();
        let at_skin = (offset + 0.5 * 2.0_f64.ln()).sqrt();
        let length_m = 4.0 * at_skin / skin_slope(&field, 0, &Matrix3::identity()).unwrap();
        let radii = Vector3::repeat(squared.sqrt());
        let scale = SkinScale { offset, at_skin, balls: vec![MeanLength { length_m, radii }] };
        (field, scale)
    }

    fn residual(kind: Residual, (field, scale): &(Field, SkinScale), x: f64) -> SkinResidual {
        let sample = field.sample(&Vector3::new(x, 0.0, 0.0)).unwrap();
        let mean = scale.balls[0];
        let balls = vec![mean.with_radii(&mean.radii, Matrix3::identity())];
        let limbs = vec![LimbScale { lengths_m: balls[0].range_m(), most_outside_m: 0.0 }];
        let posed = PosedScale { scale, balls, limbs };
        posed.residual(kind, Derivatives::Complete, &sample)
    }

    #[test]
    fn near_the_skin_it_is_the_distance() {
        for radius in [0.03, 0.06, 0.15] {
            let ball = ball(radius);
            for off in [-2e-3, -1e-4, 1e-4, 2e-3] {
                let r = residual(Residual::Metric, &ball, radius + off).distance_m;
                // the skin is found by the half step
                approx::assert_relative_eq!(r, off, max_relative = 0.1);
            }
        }
    }

    #[test]
    fn it_grows_with_the_distance_and_the_fields_residual_does_not() {
        let ball = ball(0.05);
        let measure = |kind, x| residual(kind, &ball, x).distance_m;
        let far = [1e-6, 0.02, 0.05, 0.1, 0.3, 1.0, 3.0];
        let metric = far.map(|x| measure(Residual::Metric, x));
        assert!(metric.is_sorted_by(|a, b| a < b), "{metric:?}");
        assert!(metric[0].is_finite() && metric[6] > 2.0, "{metric:?}");
        let saturated = measure(Residual::Field, 3.0) - measure(Residual::Field, 1.0);
        assert!(saturated.abs() < 1e-12);
    }

    #[test]
    fn above_the_ceiling_it_stays_finite_and_has_no_slope() {
        let mut ball = ball(0.05);
        ball.1.offset = -0.5;
        let r = residual(Residual::Metric, &ball, 0.0);
        assert!(r.distance_m.is_finite() && r.distance_m < 0.0);
        // only the local length changes it
        approx::assert_abs_diff_eq!(r.alpha, -r.distance_m, epsilon = 1e-12);
    }
}
