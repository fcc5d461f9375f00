//! How far a clock is off, and how fast it drifts, from windows of a long recording.
//!
//! Window w, whose middle is at t_w, says that the clock is off by a_w with the standard deviation σ_w. The line a + b(t − t̄) through them
//! by weighted least squares, with W = 1/σ², t̄ = ΣWt/ΣW, S = ΣW(t − t̄)², is
//!
//! a = ΣWa_w/ΣW,  b = ΣW(t − t̄)a_w/S,  σ_a² = 1/ΣW,  σ_b² = 1/S.
//!
//! Windows that lie further from their line than they should are less sure than they say: with three of them or more, all variances
//! are multiplied by max(1, χ²/(n − 2)).
//!
//! # Source
//! The factor: Birge 1932, *The calculation of errors by the method of least squares*.

/// What one window says.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WindowClock {
    /// Its middle, seconds.
    pub middle_s: f64,
    /// How far the clock is off.
    pub off_s: f64,
    /// Standard deviation.
    pub sd_s: f64,
}

/// A clock over a recording.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ClockLine {
    /// How far it is off in the middle of the windows.
    pub off_s: f64,
    /// Standard deviation.
    pub sd_s: f64,
    /// How fast it drifts; of two windows or more.
    pub drift: Option<Drift>,
}

/// How fast a clock drifts against the others.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Drift {
    /// Microseconds a second.
    pub ppm: f64,
    /// Standard deviation.
    pub sd_ppm: f64,
}

/// Clocks of cameras drift by this much and less (E): a drift that is known to less than this is worth a word.
pub const TOLD_PPM: f64 = 50.0;

impl Drift {
    /// Whether it is known well enough to be told.
    pub fn is_told(&self) -> bool {
        self.sd_ppm <= TOLD_PPM
    }
}

/// The line through the windows; `None` without any.
pub fn clock_line(windows: &[WindowClock]) -> Option<ClockLine> {
    let weight = |window: &WindowClock| window.sd_s.powi(-2);
    let sum =
        |of: &dyn Fn(&WindowClock) -> f64| windows.iter().map(|w| weight(w) * of(w)).sum::<f64>();
    let all = sum(&|_| 1.0);
    if windows.is_empty() || !all.is_finite() {
        return None;
    }
    let (middle_s, off_s) = (sum(&|w| w.middle_s) / all, sum(&|w| w.off_s) / all);
    let spread = sum(&|w| (w.middle_s - middle_s).powi(2));
    let is_line = windows.len() > 1 && spread > 0.0;
    if !is_line {
        return Some(ClockLine { off_s, sd_s: all.sqrt().recip(), drift: None });
    }

    let slope = sum(&|w| (w.middle_s - middle_s) * w.off_s) / spread;
    let rest = |w: &WindowClock| (w.off_s - off_s - slope * (w.middle_s - middle_s)).powi(2);
    let free = windows.len().saturating_sub(2).max(1) as f64;
    let factor = (sum(&rest) / free).max(1.0).sqrt();
    let ppm = |rate: f64| 1e6 * rate;
    let drift = Drift { ppm: ppm(slope), sd_ppm: ppm(factor / spread.sqrt()) };
    Some(ClockLine { off_s, sd_s: factor / all.sqrt(), drift: Some(drift) })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn window(middle_s: f64, off_s: f64, sd_s: f64) -> WindowClock {
        WindowClock { middle_s, off_s, sd_s }
    }

    #[test]
    fn a_line_through_two_windows_has_their_difference_as_slope() {
        let line = clock_line(&[window(1.0, 0.010, 1e-3), window(101.0, 0.014, 1e-3)]).unwrap();
        let drift = line.drift.unwrap();
        approx::assert_relative_eq!(line.off_s, 0.012, epsilon = 1e-12);
        approx::assert_relative_eq!(line.sd_s, 1e-3 / 2.0_f64.sqrt(), epsilon = 1e-12);
        approx::assert_relative_eq!(drift.ppm, 40.0, epsilon = 1e-9);
        approx::assert_relative_eq!(drift.sd_ppm, 2.0_f64.sqrt() * 10.0, epsilon = 1e-9);
        assert!(drift.is_told());
        // half a minute would not tell
        let short = clock_line(&[window(1.0, 0.010, 1e-3), window(21.0, 0.014, 1e-3)]).unwrap();
        assert!(!short.drift.unwrap().is_told());
    }

    #[test]
    fn windows_far_from_their_line_are_less_sure_than_they_say() {
        let windows = |off_s: f64| {
            [window(0.0, 0.0, 1e-3), window(50.0, off_s, 1e-3), window(100.0, 0.0, 1e-3)]
        };
        let (straight, bent) =
            (clock_line(&windows(0.0)).unwrap(), clock_line(&windows(0.01)).unwrap());
        let ratio = bent.sd_s / straight.sd_s;
        // the middle one lies ⅔ of 10 standard deviations above the line, the others ⅓ below
        approx::assert_relative_eq!(ratio * ratio, 100.0 * (4.0 + 1.0 + 1.0) / 9.0, epsilon = 1e-9);
    }

    #[test]
    fn one_window_has_no_drift_and_none_says_nothing() {
        let line = clock_line(&[window(1.0, 0.5, 2e-3)]).unwrap();
        assert_eq!((line.off_s, line.drift), (0.5, None));
        approx::assert_relative_eq!(line.sd_s, 2e-3, epsilon = 1e-15);
        assert_eq!(clock_line(&[]), None);
    }
}
