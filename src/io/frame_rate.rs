//! Which frame rates there are.

/// The slowest and the fastest recording that is believed, Hz: a picture in ten seconds, and a high-speed camera.
const RATES_HZ: std::ops::RangeInclusive<f64> = 0.1..=100_000.0;

/// What a message says that it expected.
pub const EXPECTED: &str = "a frame rate from 0.1 to 100000 Hz";

/// Whether a number is a frame rate; one that is not finite is none.
pub fn is_one(rate_hz: f64) -> bool {
    RATES_HZ.contains(&rate_hz)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_camera_runs_at_a_rate_that_is_absurd() {
        assert!([0.1, 25.0, 59.94, 10_000.0].into_iter().all(is_one));
        let absurd = [0.0, -50.0, 1e-3, 1e9, 1e308, f64::NAN, f64::INFINITY];
        assert!(!absurd.into_iter().any(is_one));
    }
}
