//! Smoothing and slopes of one coordinate over time; NaN where it is missing.

/// The longest gap that is bridged, seconds (a straight line over 0.1 s is within millimetres of a walking body).
pub(super) const LONGEST_GAP_S: f64 = 0.1;

/// Two passes of a filter of order 2 move its −3 dB point down by this factor (Winter 2009, p. 69).
const TWO_PASSES: f64 = 0.802;
/// Samples of which one is too few to be filtered.
const FEWEST: usize = 4;

/// Bridges gaps of at most [`LONGEST_GAP_S`] by straight lines.
pub(super) fn bridge(values: &mut [f64], rate_hz: f64) {
    let longest = (LONGEST_GAP_S * rate_hz).floor() as usize;
    let known: Vec<usize> = (0..values.len()).filter(|i| values[*i].is_finite()).collect();
    for pair in known.windows(2) {
        let (a, b) = (pair[0], pair[1]);
        if b - a - 1 > longest {
            continue;
        }
        let slope = (values[b] - values[a]) / (b - a) as f64;
        for i in a + 1..b {
            values[i] = values[a] + slope * (i - a) as f64;
        }
    }
}

/// Butterworth low pass of order 2, forwards and backwards: no delay, 4th order in all; each stretch by itself.
///
/// Returned as it is where `cutoff_hz` is above 0.8 of half the rate: nothing is left to take away.
///
/// # Source
/// Winter, *Biomechanics and Motor Control of Human Movement*, 4th ed. 2009, §3.4.4.2; ends continued by their point
/// reflection.
pub(super) fn low_pass(values: &[f64], rate_hz: f64, cutoff_hz: f64) -> Vec<f64> {
    let mut smooth = values.to_vec();
    if cutoff_hz / TWO_PASSES >= 0.4 * rate_hz {
        return smooth;
    }
    for range in stretches(values) {
        if range.len() >= FEWEST {
            let stretch = both_ways(&values[range.clone()], rate_hz, cutoff_hz);
            smooth[range].copy_from_slice(&stretch);
        }
    }
    smooth
}

/// Where values are known, stretch by stretch.
pub(super) fn stretches(values: &[f64]) -> Vec<std::ops::Range<usize>> {
    let mut ranges = Vec::new();
    let mut begin = None;
    for i in 0..=values.len() {
        let is_known = values.get(i).is_some_and(|v| v.is_finite());
        match (begin, is_known) {
            (None, true) => begin = Some(i),
            (Some(first), false) => {
                ranges.push(first..i);
                begin = None;
            }
            _ => {}
        }
    }
    ranges
}

fn both_ways(values: &[f64], rate_hz: f64, cutoff_hz: f64) -> Vec<f64> {
    let pad = (values.len() - 1).min((rate_hz / cutoff_hz).ceil() as usize * 2);
    let (first, last) = (values[0], values[values.len() - 1]);
    let before = (1..=pad).rev().map(|i| 2.0 * first - values[i]);
    let after = (1..=pad).map(|i| 2.0 * last - values[values.len() - 1 - i]);
    let mut padded: Vec<f64> = before.chain(values.iter().copied()).chain(after).collect();
    for _ in 0..2 {
        padded = one_way(&padded, rate_hz, cutoff_hz);
        padded.reverse();
    }
    padded[pad..pad + values.len()].to_vec()
}

/// One pass, begun as if the first value had always been there.
fn one_way(values: &[f64], rate_hz: f64, cutoff_hz: f64) -> Vec<f64> {
    let w = (std::f64::consts::PI * cutoff_hz / TWO_PASSES / rate_hz).tan();
    let (k1, k2) = (std::f64::consts::SQRT_2 * w, w * w);
    let a0 = k2 / (1.0 + k1 + k2);
    let b1 = 2.0 * a0 * (1.0 / k2 - 1.0);
    let b2 = 1.0 - 4.0 * a0 - b1;
    let mut x = [values[0]; 2];
    let mut y = [values[0]; 2];
    let step = |&now: &f64| {
        let next = a0 * (now + 2.0 * x[0] + x[1]) + b1 * y[0] + b2 * y[1];
        x = [now, x[0]];
        y = [next, y[0]];
        next
    };
    values.iter().map(step).collect()
}

/// Slope per second, by central differences; one-sided at the ends.
pub(super) fn slope(values: &[f64], rate_hz: f64) -> Vec<f64> {
    let n = values.len();
    let at = |i: usize| {
        let (a, b) = (i.saturating_sub(1), (i + 1).min(n.saturating_sub(1)));
        (values[b] - values[a]) * rate_hz / (b - a).max(1) as f64
    };
    (0..n).map(at).collect()
}

/// Value at a time between two frames, by a straight line; NaN outside.
pub(super) fn at(values: &[f64], frame: f64) -> f64 {
    if !(0.0..=(values.len() as f64 - 1.0)).contains(&frame) {
        return f64::NAN;
    }
    let i = (frame as usize).min(values.len().saturating_sub(2));
    let (a, part) = (values[i], frame - i as f64);
    match values.get(i + 1) {
        Some(b) if part > 0.0 => a + part * (b - a),
        _ => a,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_straight_line_passes_unchanged_to_its_ends() {
        let line: Vec<f64> = (0..60).map(|i| 0.1 * f64::from(i)).collect();
        for (smooth, value) in low_pass(&line, 100.0, 6.0).iter().zip(&line) {
            approx::assert_relative_eq!(smooth, value, epsilon = 1e-3);
        }
    }

    #[test]
    fn the_amplitude_at_the_cutoff_is_that_of_minus_three_decibels() {
        let wave = |i: usize| (std::f64::consts::TAU * 6.0 * i as f64 / 200.0).sin();
        let values: Vec<f64> = (0..800).map(wave).collect();
        let smooth = low_pass(&values, 200.0, 6.0);
        let peak = smooth[200..600].iter().copied().fold(0.0, f64::max);
        approx::assert_relative_eq!(peak, 0.5_f64.sqrt(), epsilon = 0.01);
    }

    #[test]
    fn a_short_gap_is_bridged_and_a_long_one_is_left() {
        let nan = f64::NAN;
        let mut values = [0.0, nan, 2.0, nan, nan, nan, nan, nan, 8.0];
        bridge(&mut values, 30.0);
        assert_eq!(values[..3], [0.0, 1.0, 2.0]);
        assert!(values[5].is_nan());
        assert_eq!(stretches(&values), [0..3, 8..9]);
    }
}
