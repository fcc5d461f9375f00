//! Radial functions: where they increase, and their inverse there.

/// Number of steps in which an interval is searched for the place where a radial function stops increasing.
const STEPS: u32 = 32;
/// Bisection alone reaches rounding in about 60 halvings.
const MAX_ITERATIONS: u32 = 100;

/// Whether a function increases on \[0, `end`\], by its slope at equally spaced points.
pub(super) fn increases_up_to(end: f64, slope: impl Fn(f64) -> f64) -> bool {
    (0..=STEPS).all(|step| slope(end * f64::from(step) / f64::from(STEPS)) > 0.0)
}

/// The smallest x in \[0, `limit`\] with f(x) = `target`, if f increases from f(0) = 0 up to there.
///
/// `f` returns value and slope. Newton's iteration, kept in a shrinking bracket by bisection; exact to rounding.
pub(super) fn solve_increasing(
    f: impl Fn(f64) -> (f64, f64),
    target: f64,
    limit: f64,
) -> Option<f64> {
    if target <= 0.0 {
        return (target >= 0.0).then_some(0.0);
    }
    let (mut below, mut above) = bracket(&f, target, limit)?;
    let mut x = 0.5 * (below + above);

    for _ in 0..MAX_ITERATIONS {
        let (value, slope) = f(x);
        if value < target {
            below = x;
        } else {
            above = x;
        }

        // a step that leaves the bracket is replaced by its middle
        let newton = x - (value - target) / slope;
        let next = if newton > below && newton < above { newton } else { 0.5 * (below + above) };

        if (next - x).abs() <= f64::EPSILON * x {
            return Some(next);
        }
        x = next;
    }
    None
}

/// The first of [`STEPS`] intervals in which `f` passes `target`; `None` if `f` stops increasing before.
fn bracket(f: impl Fn(f64) -> (f64, f64), target: f64, limit: f64) -> Option<(f64, f64)> {
    let at = |step: u32| limit * f64::from(step) / f64::from(STEPS);
    for step in 1..=STEPS {
        let (value, slope) = f(at(step));
        if value >= target {
            return Some((at(step - 1), at(step)));
        }
        if slope <= 0.0 || !value.is_finite() {
            return None;
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_inverse_of_a_cubic_is_exact_to_rounding() {
        let x = solve_increasing(|x| (x + x.powi(3), 1.0 + 3.0 * x * x), 0.3 + 0.027, 2.0);
        approx::assert_relative_eq!(x.unwrap(), 0.3, epsilon = 1e-15);
    }

    #[test]
    fn beyond_the_fold_there_is_no_solution() {
        // x − x³ rises to 0.385 at 0.577
        let f = |x: f64| (x - x.powi(3), 1.0 - 3.0 * x * x);
        assert!(solve_increasing(f, 0.38, 2.0).is_some_and(|x| x < 0.578));
        assert_eq!(solve_increasing(f, 0.39, 2.0), None);
        assert_eq!(solve_increasing(f, f64::NAN, 2.0), None);
    }
}
