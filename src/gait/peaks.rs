//! Maxima that stand out.

use crate::math::parabola::summit;

/// A maximum.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Peak {
    /// Where, between frames: the top of the parabola through the three highest values.
    pub(super) frame: f64,
    /// How far it stands out from what lies between it and higher values.
    pub(super) prominence: f64,
}

/// How far a maximum must stand out on a side where the signal ends before it rises above the maximum, metres.
const AT_AN_END: f64 = 0.005;

/// The maxima that stand out by `prominence`; of several within `nearest` frames only the most prominent.
///
/// On a side where the signal ends, or has a gap, before it rises above the maximum, the maximum need only stand out by
/// [`AT_AN_END`], if it stands out in full on the other side.
pub(super) fn peaks(values: &[f64], prominence: f64, nearest: f64) -> Vec<Peak> {
    let is_top = |i: &usize| values[*i] > values[i - 1] && values[*i] >= values[i + 1];
    let tops = (1..values.len().saturating_sub(1)).filter(is_top);

    let peak = |i: usize| {
        let left = descent(values[i], values[..i].iter().rev());
        let right = descent(values[i], values[i + 1..].iter());
        let stands_out = [&left, &right].iter().all(|d| match d.is_full {
            true => d.depth >= prominence,
            false => d.depth >= AT_AN_END,
        });
        let deepest = left.depth.max(right.depth);
        (stands_out && deepest >= prominence).then(|| Peak {
            frame: i as f64 + summit([values[i - 1], values[i], values[i + 1]]),
            prominence: deepest,
        })
    };

    // of two that lie too near, the one that stands out more
    let mut kept: Vec<Peak> = Vec::new();
    for peak in tops.filter_map(peak) {
        match kept.last_mut() {
            Some(last) if peak.frame - last.frame < nearest => {
                if peak.prominence > last.prominence {
                    *last = peak;
                }
            }
            _ => kept.push(peak),
        }
    }
    kept
}

struct Descent {
    depth: f64,
    /// A higher value ended it.
    is_full: bool,
}

/// How deep values fall below a maximum before they rise above it.
fn descent<'a>(top: f64, values: impl Iterator<Item = &'a f64>) -> Descent {
    let mut lowest = top;
    for value in values {
        if value.is_nan() {
            break;
        }
        if *value > top {
            return Descent { depth: top - lowest, is_full: true };
        }
        lowest = lowest.min(*value);
    }
    Descent { depth: top - lowest, is_full: false }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tops_of_a_wave_are_found_between_frames_and_ripples_are_not() {
        let wave = |i: usize| (0.1 * (i as f64 - 12.3)).cos() + 0.02 * (i as f64).sin();
        let values: Vec<f64> = (0..120).map(wave).collect();
        let found = peaks(&values, 0.5, 5.0);
        assert_eq!(found.len(), 2);
        assert!((found[0].frame - 12.3).abs() < 2.5 && (found[1].frame - 75.1).abs() < 2.5);
    }

    #[test]
    fn the_top_of_a_parabola_is_exact() {
        let values: Vec<f64> = (0..9).map(|i| -(f64::from(i) - 4.2).powi(2)).collect();
        approx::assert_relative_eq!(peaks(&values, 1.0, 1.0)[0].frame, 4.2, epsilon = 1e-12);
    }
}
