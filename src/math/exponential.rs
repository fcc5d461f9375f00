//! eˣ by arithmetic alone, without a branch: a loop over many numbers is turned into vectors by the compiler.
//!
//! With n the whole number nearest to x/ln 2 and r = x − n ln 2, |r| ≤ ½ ln 2: eˣ = 2ⁿ eʳ, and eʳ is its Taylor polynomial of
//! degree 12, whose rest is less than 3·10⁻¹⁶ of it. n ln 2 is taken off in two parts, the first of which is exact (W. J. Cody and
//! W. Waite, *Software Manual for the Elementary Functions*, 1980).

/// What is added to a number to round it to a whole one, which then is the low bits of the sum.
const ROUNDING: f64 = 6_755_399_441_055_744.0;
/// ln 2 in two parts; the first has 21 bits fewer than an f64, so that a multiple of it is exact.
const LN_2_HIGH: f64 = 0.693_147_180_369_123_8;
const LN_2_LOW: f64 = 1.908_214_929_270_587_7e-10;
/// Below it eˣ is taken for e to this: a normal number still.
const LEAST: f64 = -700.0;
/// The same above.
const GREATEST: f64 = 700.0;

/// 1/k! from k = 12 to 0.
const TAYLOR: [f64; 13] = [
    1.0 / 479_001_600.0,
    1.0 / 39_916_800.0,
    1.0 / 3_628_800.0,
    1.0 / 362_880.0,
    1.0 / 40_320.0,
    1.0 / 5040.0,
    1.0 / 720.0,
    1.0 / 120.0,
    1.0 / 24.0,
    1.0 / 6.0,
    0.5,
    1.0,
    1.0,
];

/// eˣ, to 10⁻¹⁵ of it, where |x| is not more than 700; beyond, e⁻⁷⁰⁰ or e⁷⁰⁰.
#[inline(always)]
pub(crate) fn exp(x: f64) -> f64 {
    let x = if x > LEAST { x } else { LEAST };
    let x = if x < GREATEST { x } else { GREATEST };
    let rounded = x * std::f64::consts::LOG2_E + ROUNDING;
    let n = rounded - ROUNDING;
    let rest = (x - n * LN_2_HIGH) - n * LN_2_LOW;
    let power = TAYLOR.into_iter().fold(0.0, |power, coefficient| power * rest + coefficient);

    // 2ⁿ by its exponent; what lies above the low bits is shifted out
    power * f64::from_bits(rounded.to_bits().wrapping_add(1023) << 52)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_the_exponential() {
        for k in -69_990..=69_990 {
            let x = f64::from(k) * 0.010_001;
            approx::assert_relative_eq!(exp(x), x.exp(), max_relative = 1e-15);
        }
    }

    #[test]
    fn beyond_its_ends_it_stays_what_it_is_there() {
        let found = [-1e300, f64::NEG_INFINITY, 1e300, f64::INFINITY].map(exp);
        assert_eq!(found[..2], [exp(LEAST); 2]);
        assert_eq!(found[2..], [exp(GREATEST); 2]);
        assert!(found.iter().all(|v| v.is_normal()));
    }
}
