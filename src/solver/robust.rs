//! Robust losses.
//!
//! | loss    | ρ(r²)              | weight ρ′(r²)   |
//! |---------|--------------------|-----------------|
//! | Squared | r²                 | 1               |
//! | Cauchy  | c² ln(1 + r²/c²)   | 1/(1 + r²/c²)   |
//! | Geman   | r²/(1 + r²/c²)     | 1/(1 + r²/c²)²  |
//!
//! r is a residual over its standard deviation, c has no unit. A cost is ½ Σ w ρ(r²).

/// What a squared residual costs.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Loss {
    /// For Gaussian noise.
    Squared,
    /// For noise with heavy tails; the pull of an outlier falls as 1/r.
    Cauchy(f64),
    /// Geman–McClure; an outlier costs at most ½c².
    Geman(f64),
}

impl Loss {
    /// (ρ(r²), ρ′(r²)).
    #[inline]
    pub fn evaluate(self, r: f64) -> (f64, f64) {
        let squared = r * r;
        match self {
            Self::Squared => (squared, 1.0),
            Self::Cauchy(c) => {
                let ratio = squared / (c * c);
                (c * c * ratio.ln_1p(), 1.0 / (1.0 + ratio))
            }
            Self::Geman(c) => {
                let weight = 1.0 / (1.0 + squared / (c * c));
                (squared * weight, weight * weight)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Loss;

    #[test]
    fn the_weight_is_the_derivative_of_the_loss() {
        for loss in [Loss::Squared, Loss::Cauchy(2.0), Loss::Geman(3.0)] {
            for r in [1e-8_f64, 0.3, 1.0, 5.0, 40.0] {
                let h = 1e-5 * r * r;
                let value = |squared: f64| loss.evaluate(squared.sqrt()).0;
                let slope = (value(r * r + h) - value(r * r - h)) / (2.0 * h);
                approx::assert_relative_eq!(
                    slope,
                    loss.evaluate(r).1,
                    max_relative = 1e-5,
                    epsilon = 1e-12
                );
            }
        }
    }

    #[test]
    fn an_outlier_costs_at_most_c_squared_under_geman_mcclure() {
        assert!(Loss::Geman(3.0).evaluate(1e6).0 <= 9.0);
    }
}
