//! From the field at a point to a residual.
//!
//! *Field* (PF02 eq. 7): T − F, which far outside stays at T with no slope. It is divided by the slope that F
//! has at the skin of a limb of radius 5 cm (ln 2 / 5 cm), so that its σ is in metres like the other's.
//!
//! *Metric*: ψ = √(c − ½ ln F) is, for one metaball, a distance over the radius, and grows without bound. The
//! design's √(−½ ln F) ends where balls overlap and F > 1; so c = ½ ln A with A more than F ever reaches, see
//! [`Field::ceiling`](crate::body::metaball::Field::ceiling). With ψ_T its value at the skin,
//!
//! r = δ/√s, δ = ψ − ψ_T, s = ‖∇ψ‖² + κ² h, h = δ²/(δ² + ρ²),
//!
//! is the distance in metres to first order near the skin, positive outside. There h vanishes; away from the skin
//! κ = 1/(0.25 m) keeps r finite where ∇ψ is 0, on a limb's axis and at a saddle between two metaballs. With
//! L = ln F and p = ∇L: ‖∇ψ‖² = p·p/(16ψ²), ∂ψ = −∂L/(4ψ), so that
//!
//! ∂s = p·∂p/(8ψ²) + (2κ²ρ²δ/(δ² + ρ²)² − p·p/(8ψ³)) ∂ψ, ∂r = ∂ψ/√s − ½ δ s^(−3/2) ∂s = α ∂L + β·∂p.

use nalgebra::Vector3;

use crate::body::metaball::THRESHOLD;

/// Which residual.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Residual {
    /// PF02: T − F, over the slope of a limb of radius 5 cm.
    Field,
    /// Distance to the skin, metres to first order.
    Metric,
}

/// Which derivatives (PF02 App. A.2).
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Derivatives {
    /// First and second ones: the gradient is that of the cost.
    Complete,
    /// PF02's simpler variant: without every second derivative of F.
    FirstOrder,
}

/// κ, 1/m.
const LEAST_SLOPE: f64 = 4.0;

/// ρ: how far from the skin, in ψ, κ begins to matter.
const NEAR: f64 = 0.3;

/// The radius of the limb whose slope scales the field's residual, m.
const FIELD_RADIUS_M: f64 = 0.05;

/// Least ψ²: beneath it F is more than its ceiling, and ψ stays as it is.
const LEAST_SQUARE: f64 = 1e-3;

/// The measure of how far a point is from the skin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SkinDistance {
    residual: Residual,
    derivatives: Derivatives,
    /// c.
    offset: f64,
    /// ψ_T.
    at_skin: f64,
}

/// r, and ∂r = α ∂(ln F) + β·∂(∇ ln F).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SkinResidual {
    /// r, metres, positive outside.
    pub distance_m: f64,
    /// α, metres.
    pub alpha: f64,
    /// β, square metres.
    pub beta: Vector3<f64>,
}

impl SkinDistance {
    /// A measure for a model whose field stays below `ceiling`.
    pub fn new(residual: Residual, derivatives: Derivatives, ceiling: f64) -> Self {
        let offset = 0.5 * ceiling.ln();
        Self {
            residual,
            derivatives,
            offset,
            at_skin: (offset - 0.5 * THRESHOLD.ln()).max(LEAST_SQUARE).sqrt(),
        }
    }

    /// The residual from ln F and ∇ ln F, world frame, 1/m.
    pub fn evaluate(&self, log_value: f64, log_gradient: &Vector3<f64>) -> SkinResidual {
        match self.residual {
            Residual::Field => field(log_value),
            Residual::Metric => self.metric(log_value, log_gradient),
        }
    }

    fn metric(&self, log_value: f64, p: &Vector3<f64>) -> SkinResidual {
        let square = self.offset - 0.5 * log_value;
        let psi = square.max(LEAST_SQUARE).sqrt();
        // ∂ψ/∂L
        let slope = if square > LEAST_SQUARE {
            -0.25 / psi
        } else {
            0.0
        };
        let scale = 1.0 / (psi * psi);
        let steepness = p.norm_squared() * scale;
        let past = psi - self.at_skin;
        let away = 1.0 / (past * past + NEAR * NEAR);
        let stiff = LEAST_SLOPE * LEAST_SLOPE * past * away;
        let squared = steepness / 16.0 + stiff * past;
        // deep in the skin's own tangent plane both vanish only together, at no slope at all
        let length = 1.0 / squared.max(f64::MIN_POSITIVE).sqrt();
        let (mut alpha, mut beta) = (length * slope, Vector3::zeros());
        if self.derivatives == Derivatives::Complete {
            // ∂r/∂s, ∂s/∂ψ
            let by_squared = -0.5 * past * length / squared;
            let by_psi = 2.0 * stiff * NEAR * NEAR * away - steepness / (8.0 * psi);
            alpha += by_squared * by_psi * slope;
            beta = p * (by_squared * scale / 8.0);
        }
        SkinResidual {
            distance_m: past * length,
            alpha,
            beta,
        }
    }
}

fn field(log_value: f64) -> SkinResidual {
    let metres = FIELD_RADIUS_M / std::f64::consts::LN_2;
    // a point deep within, in a pose that no body takes, must not give an infinite residual
    let value = log_value.min(50.0).exp();
    SkinResidual {
        distance_m: (THRESHOLD - value) * metres,
        alpha: -value * metres,
        beta: Vector3::zeros(),
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::DVector;

    use super::*;
    use crate::math::central_differences;

    /// ln F and ∇ ln F on the axis of one round metaball whose skin has this radius.
    fn ball(x: f64, radius: f64) -> (f64, Vector3<f64>) {
        let d = 0.5 * std::f64::consts::LN_2 * (x / radius).powi(2);
        (-2.0 * d, Vector3::new(-4.0 * d / x, 0.0, 0.0))
    }

    #[test]
    fn near_the_skin_it_is_the_distance() {
        let metric = SkinDistance::new(Residual::Metric, Derivatives::Complete, 3.0);
        for radius in [0.03, 0.06, 0.15] {
            for off in [-1e-4, 1e-4, 2e-3] {
                let (value, gradient) = ball(radius + off, radius);
                let r = metric.evaluate(value, &gradient).distance_m;
                approx::assert_relative_eq!(r, off, max_relative = 0.05);
            }
        }
    }

    #[test]
    fn it_grows_with_the_distance_and_the_fields_residual_does_not() {
        let measure = |kind, x| {
            let (value, gradient) = ball(x, 0.05);
            SkinDistance::new(kind, Derivatives::Complete, 3.0)
                .evaluate(value, &gradient)
                .distance_m
        };
        let far = [1e-6, 0.02, 0.05, 0.1, 0.3, 1.0, 3.0];
        let metric = far.map(|x| measure(Residual::Metric, x));
        assert!(metric.is_sorted_by(|a, b| a < b), "{metric:?}");
        assert!(metric[0].is_finite() && metric[6] > 0.5, "{metric:?}");
        let saturated = measure(Residual::Field, 3.0) - measure(Residual::Field, 1.0);
        assert!(saturated.abs() < 1e-12);
    }

    #[test]
    fn the_slopes_are_those_of_the_residual() {
        for kind in [Residual::Field, Residual::Metric] {
            let measure = SkinDistance::new(kind, Derivatives::Complete, 3.0);
            // outside, near the skin, deep inside, on an axis, and above the ceiling
            for (value, p) in [
                (-40.0, Vector3::new(-80.0, 20.0, 3.0)),
                (-0.7, Vector3::new(20.0, -10.0, 3.0)),
                (0.9, Vector3::new(3.0, 4.0, -2.0)),
                (0.5, Vector3::zeros()),
                (1.5, Vector3::new(1.0, 2.0, 3.0)),
            ] {
                let numeric = central_differences(4, 1e-4, |d| {
                    let moved = p + Vector3::new(d[1], d[2], d[3]);
                    let r = measure.evaluate(value + d[0], &moved);
                    DVector::from_element(1, r.distance_m)
                });
                let r = measure.evaluate(value, &p);
                let slopes = [r.alpha, r.beta.x, r.beta.y, r.beta.z];
                for (a, n) in slopes.iter().zip(&numeric) {
                    approx::assert_abs_diff_eq!(a, n, epsilon = 1e-9);
                }
            }
        }
    }
}
