//! How high a smooth random curve reaches by chance: one-dimensional random field theory.
//!
//! A field of Student's t with ν degrees of freedom over N places, whose noise is as smooth as white noise under a Gaussian of full
//! width at half maximum w (in places), is R₁ = (N − 1)/w resels long. Its expected Euler characteristic above a height u is
//!
//! E(u) = ρ₀(u) + R₁·ρ₁(u), ρ₀(u) = P(t > u), ρ₁(u) = √(4 ln 2)/(2π) · (1 + u²/ν)^((1 − ν)/2),
//!
//! and the probability that the greatest of the field exceeds u is 1 − e^(−E(u)). One stretch above u of k resels or more has the
//! probability 1 − e^(−E(u)·p(k)), with p(k) = exp(−(Γ(3/2)·k·ρ₁/ρ₀)²).
//!
//! # Source
//! Worsley et al. 1996, Hum Brain Mapp 4:58–73 (densities); Friston et al. 1994, Hum Brain Mapp 1:210–220 (stretches); Kiebel et al.
//! 1999, NeuroImage 10:756–766 (smoothness). Where the field is so rough that Bonferroni's bound is lower, that one holds, as in
//! Pataky's rft1d.

use std::f64::consts::{LN_2, TAU};

use statrs::distribution::{ContinuousCDF, StudentsT};

/// Γ(3/2).
const GAMMA_OF_THREE_HALVES: f64 = 0.886_226_925_452_758;

/// A field of Student's t along a line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TField {
    /// ν.
    pub freedom: f64,
    /// N.
    pub places: usize,
    /// w, in places.
    pub fwhm: f64,
}

impl TField {
    /// The probability that the greatest value of the field exceeds a height; one-sided.
    pub fn exceeds(&self, height: f64) -> f64 {
        let [at_a_place, _] = self.densities(height);
        let by_field = -(-self.expected(height)).exp_m1();
        // never more likely than Bonferroni's bound, nor less than at a single place
        by_field.min(self.places as f64 * at_a_place).min(1.0).max(at_a_place)
    }

    /// The height that the greatest value exceeds with this probability, one-sided; between 0 and 10⁶.
    pub fn height(&self, probability: f64) -> f64 {
        // exceeds() falls with the height
        let (mut low, mut high) = (0.0, 1e6);
        for _ in 0..200 {
            let middle = 0.5 * (low + high);
            match self.exceeds(middle) > probability {
                true => low = middle,
                false => high = middle,
            }
        }
        0.5 * (low + high)
    }

    /// The probability of one stretch above a height that is so many places wide or wider; one-sided.
    pub fn stretch(&self, height: f64, width: f64) -> f64 {
        let [at_a_place, upcrossing] = self.densities(height);
        let reach = GAMMA_OF_THREE_HALVES * (width / self.fwhm) * upcrossing / at_a_place;
        -(-self.expected(height) * (-reach * reach).exp()).exp_m1()
    }

    /// E(u).
    fn expected(&self, height: f64) -> f64 {
        let [at_a_place, upcrossing] = self.densities(height);
        at_a_place + (self.places as f64 - 1.0) / self.fwhm * upcrossing
    }

    /// ρ₀ and ρ₁, neither below the precision of numbers.
    fn densities(&self, height: f64) -> [f64; 2] {
        let nu = self.freedom;
        let at_a_place = StudentsT::new(0.0, 1.0, nu).map_or(f64::NAN, |t| t.sf(height));
        let upcrossing =
            (4.0 * LN_2).sqrt() / TAU * (1.0 + height * height / nu).powf(0.5 * (1.0 - nu));
        [at_a_place, upcrossing].map(|density| density.max(f64::EPSILON))
    }
}

/// The full width at half maximum of residuals, in places: 1 / mean √(Σ(∂r)² / (4 ln 2·Σr²)), sums over the curves at each place,
/// ∂ central differences. `None` of fewer than two places, and where the curves do not differ.
///
/// # Source
/// Kiebel et al. 1999; the differences as in Pataky's rft1d.
pub fn fwhm(residuals: &[Vec<f64>]) -> Option<f64> {
    let places = residuals.first()?.len();
    let roughness = |at: usize| {
        let (before, after) = (at.saturating_sub(1), (at + 1).min(places - 1));
        let slope = |r: &Vec<f64>| (r[after] - r[before]) / (after - before) as f64;
        let slopes: f64 = residuals.iter().map(|r| slope(r).powi(2)).sum();
        let squares: f64 = residuals.iter().map(|r| r[at] * r[at]).sum();
        (slopes / (squares + f64::EPSILON) / (4.0 * LN_2)).sqrt()
    };
    let sum: f64 = (places > 1).then(|| (0..places).map(roughness).sum())?;
    (sum > 0.0 && sum.is_finite()).then(|| places as f64 / sum)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_infinitely_smooth_field_is_one_number_and_a_rough_one_many() {
        let field = |fwhm| TField { freedom: 8.0, places: 101, fwhm };
        // t₀.₉₇₅(8) = 2.3060, Bonferroni's t of 101 places 5.8 and a little
        approx::assert_relative_eq!(field(1e9).height(0.025), 2.3060, epsilon = 1e-3);
        let rough = field(0.01).height(0.025);
        let bound = StudentsT::new(0.0, 1.0, 8.0).unwrap().inverse_cdf(1.0 - 0.025 / 101.0);
        approx::assert_relative_eq!(rough, bound, epsilon = 1e-3);
        assert!(field(10.0).height(0.025) > 2.31 && field(10.0).height(0.025) < rough);
    }

    #[test]
    fn a_wider_stretch_is_less_probable() {
        let field = TField { freedom: 8.0, places: 101, fwhm: 15.0 };
        let height = field.height(0.05);
        approx::assert_relative_eq!(field.stretch(height, 0.0), 0.05, epsilon = 1e-9);
        assert!(field.stretch(height, 20.0) < field.stretch(height, 10.0));
    }

    #[test]
    fn curves_that_do_not_differ_have_no_smoothness() {
        assert_eq!(fwhm(&[vec![0.0; 5], vec![0.0; 5]]), None);
        assert_eq!(fwhm(&[vec![1.0]]), None);
        assert_eq!(fwhm(&[]), None);
    }
}
