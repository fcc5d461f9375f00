//! The parabola through three values at equal distances.

/// Where the summit lies, in steps from the middle value, at most half a step away; 0 if there is no summit.
pub fn summit([before, here, after]: [f64; 3]) -> f64 {
    let curvature = before - 2.0 * here + after;
    if curvature < 0.0 { (0.5 * (before - after) / curvature).clamp(-0.5, 0.5) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_summit_of_a_parabola_is_found_and_a_valley_has_none() {
        let parabola = [-1.0_f64, 0.0, 1.0].map(|x| 3.0 - (x - 0.3).powi(2));
        assert!((summit(parabola) - 0.3).abs() < 1e-12);
        for (values, expected) in
            [(parabola.map(|y| -y), 0.0), ([0.0, 1.0, 5.0], 0.0), ([5.0, 5.0, 4.0], -0.5)]
        {
            assert!((summit(values) - expected).abs() < 1e-12, "{values:?}");
        }
    }
}
