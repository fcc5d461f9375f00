//! From the field at a point to a residual.
//!
//! *Field* (PF02 eq. 7): T − F, which far outside stays at T with no slope. It is divided by the slope that F
//! has at the skin of a limb of radius 5 cm (ln 2 / 5 cm), so that its σ is in metres like the other's.
//!
//! *Metric*: ψ = √(c − ½ ln F) is, for one metaball, a distance over the radius, and grows without bound. The
//! design's √(−½ ln F) ends where balls overlap and F > 1; so c = ½ ln A with A more than F ever reaches. With ψ_T its
//! value at the skin, r = (ψ − ψ_T)·R is a distance in metres near the skin, positive outside. R is the local
//! length, Σ wᵢ Rᵢ over the metaballs there. Rᵢ is 1/‖∇ψ‖ at the skin around metaball i of the mean body at rest, and
//! grows with the metaball's radii: Rᵢ = R̄ᵢ Πₖ (aᵢₖ/āᵢₖ)^qᵢₖ, qᵢₖ the mean square of the skin's normal along axis k.
//! (Were it a constant, a fatter body would make every residual smaller: fits to points inflated. For lines of sight it
//! is one, qᵢₖ = 0: a border is seen from all sides, so there is less to gain by fattening; but masks have outliers of
//! tens of centimetres, and a body that grows thin across them made those smaller at a walk in a busy room.)
//! With L = ln F: ∂ψ = −∂L/(4ψ), ∂wᵢ = wᵢ (∂ ln fᵢ − ∂L), so that
//!
//! ∂r = Σ wᵢ (αᵢ ∂ ln fᵢ + Σₖ γᵢₖ ∂ ln aᵢₖ), αᵢ = −R/(4ψ) + (ψ − ψ_T)(Rᵢ − R), γᵢₖ = (ψ − ψ_T) Rᵢ qᵢₖ.
//!
//! Dividing by ‖∇ψ‖ where the point is instead of by a constant would be the exact first-order distance, but a bad
//! residual: it can be lowered by moving to where ψ is steep. Fits to lines of sight then ended in many local minima.

use nalgebra::{Matrix3, Vector3};

use crate::body::metaball::{Field, FieldSample, THRESHOLD};
use crate::body::{BodyModel, Motion, Posed, Shape};

/// Which residual.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Residual {
    /// PF02: T − F, over the slope of a limb of radius 5 cm.
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
    /// PF02's simpler variant: as if neither the contact on a ray moved nor the local length changed.
    FirstOrder,
}

/// The radius of the limb whose slope scales the field's residual, m.
const FIELD_RADIUS_M: f64 = 0.05;

/// Least ψ²: beneath it F is more than its ceiling, and ψ stays as it is.
const LEAST_SQUARE: f64 = 1e-3;

/// What turns a model's field into metres: constants of the model.
#[derive(Debug, Clone, PartialEq)]
pub struct SkinScale {
    /// c.
    offset: f64,
    /// ψ_T.
    at_skin: f64,
    /// Of each of [`BodyModel::metaballs`].
    balls: Vec<BallScale>,
}

/// The length around one metaball of the mean body at rest.
#[derive(Debug, Clone, Copy, PartialEq)]
struct BallScale {
    /// R̄ᵢ, m.
    length_m: f64,
    /// āᵢ, m.
    radii: Vector3<f64>,
    /// qᵢ: they sum up to 1.
    shares: Vector3<f64>,
}

/// The scale of a body in one pose: Rᵢ and qᵢ of each metaball of its field.
#[derive(Debug, Clone)]
pub struct PosedScale<'a> {
    scale: &'a SkinScale,
    balls: Vec<(f64, Vector3<f64>)>,
}

/// r, and ∂r = Σ wᵢ (αᵢ ∂ ln fᵢ + Σₖ γᵢₖ ∂ ln aᵢₖ): see [`PosedScale::change`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SkinResidual {
    /// r, metres, positive outside.
    pub distance_m: f64,
    /// αᵢ without γRᵢ, metres.
    pub alpha: f64,
    /// γ: ψ − ψ_T.
    pub gamma: f64,
}

impl SkinScale {
    /// The scale of a model: its mean shape at rest is measured.
    pub fn of(model: &BodyModel) -> Self {
        let shape = Shape(model.statistics.mean.clone());
        let rest = Motion::rest(model);
        let body = Posed::new(model, &shape, &rest);
        let field = Field::of(&body);
        let offset = 0.5 * field.ceiling().ln();
        let at_skin = (offset - 0.5 * THRESHOLD.ln()).max(LEAST_SQUARE).sqrt();
        let primitives = model.metaballs.iter();
        let mut balls: Vec<BallScale> = primitives
            .map(|m| BallScale::thin(body.primitive_radii(m)))
            .collect();
        for ball in 0..field.metaballs.len() {
            let Some(source) = field.source(ball) else {
                continue;
            };
            let axes = body.primitive_axes(&model.metaballs[source]);
            if let Some((slope, shares)) = skin_slope(&field, ball, &axes) {
                let length_m = 4.0 * at_skin / slope;
                balls[source] = BallScale {
                    length_m,
                    shares,
                    ..balls[source]
                };
            }
        }
        Self {
            offset,
            at_skin,
            balls,
        }
    }

    /// R̄ᵢ whatever the shape: for lines of sight, see the module.
    pub fn constant(&self, field: &Field) -> PosedScale<'_> {
        let of = |ball: usize| Some(self.balls.get(field.source(ball)?)?.length_m);
        let lengths = (0..field.metaballs.len()).map(|i| of(i).unwrap_or(FIELD_RADIUS_M));
        PosedScale {
            scale: self,
            balls: lengths.map(|length| (length, Vector3::zeros())).collect(),
        }
    }

    /// The scale of a body in a pose; `field` is the body's.
    pub fn posed(&self, body: &Posed<'_>, field: &Field) -> PosedScale<'_> {
        let of = |ball: usize| {
            let source = field.source(ball)?;
            let (scale, primitive) = (self.balls.get(source)?, body.model.metaballs.get(source)?);
            Some(scale.at(&body.primitive_radii(primitive)))
        };
        let balls =
            (0..field.metaballs.len()).map(|i| of(i).unwrap_or((FIELD_RADIUS_M, Vector3::zeros())));
        PosedScale {
            scale: self,
            balls: balls.collect(),
        }
    }
}

impl BallScale {
    /// A metaball that meets no skin.
    fn thin(radii: Vector3<f64>) -> Self {
        Self {
            length_m: FIELD_RADIUS_M,
            radii,
            shares: Vector3::zeros(),
        }
    }

    /// (Rᵢ, qᵢ) with other radii.
    fn at(&self, radii: &Vector3<f64>) -> (f64, Vector3<f64>) {
        let growth = radii.zip_map(&self.radii, |a, mean| (a / mean).ln());
        (self.length_m * self.shares.dot(&growth).exp(), self.shares)
    }
}

impl PosedScale<'_> {
    /// The residual at a sampled point.
    pub fn residual(&self, kind: (Residual, Derivatives), sample: &FieldSample) -> SkinResidual {
        match kind.0 {
            Residual::Field => of_field(sample.log_value),
            Residual::Metric => self.metric(kind.1, sample),
        }
    }

    /// αᵢ and γᵢ of a metaball.
    pub fn change(&self, residual: &SkinResidual, metaball: usize) -> (f64, Vector3<f64>) {
        let (length, shares) = self.balls[metaball];
        let gamma = residual.gamma * length;
        (residual.alpha + gamma, shares * gamma)
    }

    /// Rᵢ, m.
    pub fn length_m(&self, metaball: usize) -> f64 {
        self.balls[metaball].0
    }

    fn metric(&self, derivatives: Derivatives, sample: &FieldSample) -> SkinResidual {
        let square = self.scale.offset - 0.5 * sample.log_value;
        let psi = square.max(LEAST_SQUARE).sqrt();
        // ∂ψ/∂L
        let slope = if square > LEAST_SQUARE {
            -0.25 / psi
        } else {
            0.0
        };
        let each = sample.shares.iter();
        let length: f64 = each.map(|s| s.weight * self.length_m(s.metaball)).sum();
        let past = psi - self.scale.at_skin;
        let gamma = match derivatives {
            Derivatives::Complete => past,
            Derivatives::FirstOrder => 0.0,
        };
        SkinResidual {
            distance_m: past * length,
            alpha: length * (slope - gamma),
            gamma,
        }
    }
}

fn of_field(log_value: f64) -> SkinResidual {
    let metres = FIELD_RADIUS_M / std::f64::consts::LN_2;
    // a point deep within, in a pose that no body takes, must not give an infinite residual
    let value = log_value.min(50.0).exp();
    SkinResidual {
        distance_m: (THRESHOLD - value) * metres,
        alpha: -value * metres,
        gamma: 0.0,
    }
}

/// Mean ‖∇ ln F‖ where the axes of a metaball meet the skin, 1/m, and the mean square of the skin's normal along each of
/// them; `None` if none does.
///
/// Where the skin is another's, deep in a neighbour, it counts only if there is no better place.
fn skin_slope(field: &Field, ball: usize, axes: &Matrix3<f64>) -> Option<(f64, Vector3<f64>)> {
    let centre = field.metaballs[ball].ellipsoid.centre;
    let ways = (0..6).map(|k| axes.column(k / 2) * if k % 2 == 0 { 1.0 } else { -1.0 });
    let met: Vec<_> = ways
        .filter_map(|way| skin_along(field, &centre, &way))
        .collect();
    let is_own = |s: &&FieldSample| s.heaviest() == Some(ball);
    let own: Vec<_> = met.iter().filter(is_own).collect();
    let places = if own.is_empty() {
        met.iter().collect()
    } else {
        own
    };
    let count = places.len() as f64;
    let slope = places.iter().map(|s| s.log_gradient.norm()).sum::<f64>() / count;
    let normals = places
        .iter()
        .filter_map(|s| s.log_gradient.try_normalize(0.0));
    let squares: Vector3<f64> = normals.map(|n| axes.tr_mul(&n).map(|v| v * v)).sum();
    (slope.is_finite() && slope > 0.0).then(|| (slope, squares / count))
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
    fn ball(radius: f64) -> (Field, SkinScale, f64) {
        let squared = 2.0 * radius * radius / std::f64::consts::LN_2;
        let field = Field::new([Ellipsoid {
            centre: Vector3::zeros(),
            shape: Matrix3::identity() * squared,
        }]);
        let offset = 0.5 * 3.0_f64.ln();
        let at_skin = (offset + 0.5 * 2.0_f64.ln()).sqrt();
        let scale = SkinScale {
            offset,
            at_skin,
            balls: Vec::new(),
        };
        let length = 4.0 * at_skin / skin_slope(&field, 0, &Matrix3::identity()).unwrap().0;
        (field, scale, length)
    }

    fn residual(kind: Residual, ball: &(Field, SkinScale, f64), x: f64) -> SkinResidual {
        let (field, scale, length) = ball;
        let sample = field.sample(&Vector3::new(x, 0.0, 0.0)).unwrap();
        let posed = PosedScale {
            scale,
            balls: vec![(*length, Vector3::repeat(1.0 / 3.0))],
        };
        posed.residual((kind, Derivatives::Complete), &sample)
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
        // α + γ R = 0 for the only metaball
        approx::assert_abs_diff_eq!(r.alpha, -r.distance_m, epsilon = 1e-12);
    }
}
