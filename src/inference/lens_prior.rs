//! How far a focal length may be off.
//!
//! A lens is as its calibration found it, but for what a usual calibration errs by; one in a hundred was touched, or its pictures were scaled. That is
//! a contaminated normal of ζ, the logarithm of its focal length over the calibrated one,
//!
//! p(ζ) = (1 − π) N(ζ; 0, σ²) + π N(ζ; 0, σ_t²).
//!
//! With the share ψ of the first in p(ζ), its weight is ψ/σ² + (1 − ψ)/σ_t²: of a normal near 0, and next to nothing from four σ on. Student's t, which
//! turns and displacements have, says of every eighth lens that it is five σ off, and gives way to the errors of rough masks.
//!
//! # Source
//! Tukey 1960, *A survey of sampling from contaminated distributions*. σ, π and σ_t are estimates (E).

/// σ of a focal length, as a share of it.
pub const ZOOM_SD: f64 = 0.002;
/// π.
const TOUCHED: f64 = 0.01;
/// σ_t.
const TOUCHED_SD: f64 = 0.1;

/// −ln p(ζ), 0 where nothing is off.
pub fn cost(log_zoom: f64) -> f64 {
    let ln_density = |log_zoom: f64| {
        let [usual, touched] = ln_parts(log_zoom);
        usual.max(touched) + (-(usual - touched).abs()).exp().ln_1p()
    };
    ln_density(0.0) - ln_density(log_zoom)
}

/// What ∂ cost/∂ζ is of ζ.
pub fn weight(log_zoom: f64) -> f64 {
    let [usual, touched] = ln_parts(log_zoom);
    let usual = 1.0 / (1.0 + (touched - usual).exp());
    usual / ZOOM_SD.powi(2) + (1.0 - usual) / TOUCHED_SD.powi(2)
}

/// The logarithms of both parts, but for one constant.
fn ln_parts(log_zoom: f64) -> [f64; 2] {
    let ln_part = |share: f64, sd: f64| (share / sd).ln() - 0.5 * (log_zoom / sd).powi(2);
    [ln_part(1.0 - TOUCHED, ZOOM_SD), ln_part(TOUCHED, TOUCHED_SD)]
}

#[cfg(test)]
mod tests {
    use approx::assert_relative_eq;

    use super::*;

    #[test]
    fn a_lens_is_held_as_by_a_normal_and_one_that_was_touched_is_free() {
        assert_relative_eq!(cost(0.0), 0.0);
        assert_relative_eq!(cost(ZOOM_SD), 0.5, max_relative = 1e-3);
        assert_relative_eq!(weight(ZOOM_SD), ZOOM_SD.powi(-2), max_relative = 1e-3);
        assert_relative_eq!(weight(0.05), TOUCHED_SD.powi(-2), max_relative = 1e-9);

        // the two are as likely as each other
        assert!(weight(4.0 * ZOOM_SD) > 0.5 * ZOOM_SD.powi(-2));
        assert!(weight(4.3 * ZOOM_SD) < 0.5 * ZOOM_SD.powi(-2));
        assert!(cost(2.0).is_finite() && cost(2.0) > cost(0.1));
    }

    #[test]
    fn the_weight_is_the_slope_over_what_is_off() {
        for log_zoom in [1e-4, 0.003, 0.0083, -0.009, 0.02, -0.3] {
            let step = 1e-7;
            let slope = (cost(log_zoom + step) - cost(log_zoom - step)) / (2.0 * step);
            assert_relative_eq!(weight(log_zoom) * log_zoom, slope, max_relative = 1e-5);
        }
    }
}
