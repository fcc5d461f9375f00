//! By how much one sound is later than another: where the loudness of both rises together.
//!
//! The onset of a sound is f(i) = max(0, ln(e_i + ē/10³) − ln(e_{i−1} + ē/10³)), e_i the energy in the i-th step, ē its mean: a clap
//! counts alike near and far from a microphone, and noise 30 dB below the mean is none. With means subtracted, the delay is where
//!
//! r(d) = Σ f_a(i) f_b(i + d)   over what both have
//!
//! is largest: first in steps of 10 ms over the whole range, then in single steps about the largest, with a parabola through three. It is not divided by what both have in
//! common: one clap against another would then agree as well as all claps together.
//!
//! It is told only where no other delay agrees nearly as well: r must be at least 1½ times as large as further than 50 ms away. (E: step,
//! floor and ratio were chosen before any recording was looked at.)

/// Steps of a loudness, Hz.
pub const ENVELOPE_HZ: f64 = 1000.0;

/// Steps that make one of the coarse search.
const COARSE: usize = 10;
/// Further away is another delay, coarse steps.
const APART: isize = 5;
/// How much better the best must be than any other.
const DISTINCT: f64 = 1.5;
/// The noise that is no sound, as a share of the mean energy.
const FLOOR: f64 = 1e-3;
/// What both must have in common, coarse steps: a second.
const LEAST_COMMON: usize = 100;

/// By how many seconds what is heard in `b` is later in it than the same in `a`, at most `most_s`; energies in steps of
/// 1/[`ENVELOPE_HZ`]. `None` where no delay is distinct.
pub fn sound_delay_s(a: &[f32], b: &[f32], most_s: f64) -> Option<f64> {
    let coarse = |energy: &[f32]| {
        let sums = energy.chunks(COARSE).map(|chunk| chunk.iter().sum::<f32>());
        onsets(&sums.collect::<Vec<f32>>())
    };
    let most = (most_s * ENVELOPE_HZ / COARSE as f64) as isize;
    let (rough_a, rough_b) = (coarse(a), coarse(b));
    let all: Vec<(isize, f64)> = (-most..=most)
        .filter_map(|delay| Some((delay, agreement(&rough_a, &rough_b, delay, LEAST_COMMON)?)))
        .collect();
    let best = all.iter().max_by(|x, y| x.1.total_cmp(&y.1))?;
    let others = all.iter().filter(|(delay, _)| (delay - best.0).abs() > APART);
    let other = others.map(|(_, r)| *r).fold(0.0, f64::max);
    if best.1 <= DISTINCT * other || best.1 <= 0.0 {
        return None;
    }

    // single steps about it
    let (fine_a, fine_b) = (onsets_of(a), onsets_of(b));
    let middle = best.0 * COARSE as isize;
    let reach = 2 * COARSE as isize;
    let near: Vec<f64> = (middle - reach..=middle + reach)
        .map(|delay| agreement(&fine_a, &fine_b, delay, LEAST_COMMON * COARSE).unwrap_or(0.0))
        .collect();
    let top = (0..near.len()).max_by(|x, y| near[*x].total_cmp(&near[*y]))?;
    let bend = match near.get(top.wrapping_sub(1)..top + 2) {
        Some(&[left, here, right]) if left + right < 2.0 * here => {
            0.5 * (left - right) / (left + right - 2.0 * here)
        }
        _ => 0.0,
    };
    Some(((middle - reach + top as isize) as f64 + bend) / ENVELOPE_HZ)
}

/// Onsets in single steps, of energies that are summed over a coarse one so that they do not flicker.
fn onsets_of(energy: &[f32]) -> Vec<f32> {
    let mut sum = 0.0_f64;
    let running = energy.iter().enumerate().map(|(i, e)| {
        sum += f64::from(*e);
        if i >= COARSE {
            sum -= f64::from(energy[i - COARSE]);
        }
        sum.max(0.0) as f32
    });
    onsets(&running.collect::<Vec<f32>>())
}

/// f, with its mean subtracted.
fn onsets(energy: &[f32]) -> Vec<f32> {
    let count = energy.len().max(1) as f32;
    let floor = (energy.iter().sum::<f32>() / count) * FLOOR as f32 + f32::MIN_POSITIVE;
    let logarithms: Vec<f32> = energy.iter().map(|e| (e + floor).ln()).collect();
    let rises = logarithms.windows(2).map(|pair| (pair[1] - pair[0]).max(0.0));
    let mut rises: Vec<f32> = std::iter::once(0.0).chain(rises).take(energy.len()).collect();
    let mean = rises.iter().sum::<f32>() / count;
    rises.iter_mut().for_each(|rise| *rise -= mean);
    rises
}

/// r at a delay; `None` where less than `least` steps are in both.
fn agreement(a: &[f32], b: &[f32], delay: isize, least: usize) -> Option<f64> {
    let first = (-delay).max(0) as usize;
    let last = a.len().min(b.len().checked_add_signed(-delay)?);
    let length = last.checked_sub(first).filter(|length| *length >= least)?;
    let a = &a[first..last];
    let b = &b[first.checked_add_signed(delay)?..][..length];
    Some(a.iter().zip(b).map(|(x, y)| f64::from(*x) * f64::from(*y)).sum())
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    /// Noise, and claps that fade at these times.
    fn heard(seconds: f64, claps_s: &[f64], loud: f32, seed: u64) -> Vec<f32> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let steps = (seconds * ENVELOPE_HZ) as usize;
        let clap = |i: usize| {
            let since = |at: &f64| i as f64 / ENVELOPE_HZ - at;
            let heard = claps_s.iter().map(since).filter(|since| *since >= 0.0);
            heard.map(|since| loud * (-since / 0.03).exp() as f32).sum::<f32>()
        };
        (0..steps).map(|i| clap(i) + 1e-4 * rng.random_range(0.5..1.5)).collect()
    }

    #[test]
    fn claps_are_found_at_their_delay_however_loud_they_are() {
        let claps = [1.0, 2.7, 3.1, 6.4];
        for delay in [-1.234, 0.0, 0.077, 2.5] {
            let a = heard(9.0, &claps, 1.0, 1);
            let b = heard(12.0, &claps.map(|at| at + delay), 0.05, 2);
            let found = sound_delay_s(&a, &b, 5.0).unwrap();
            assert!((found - delay).abs() < 1.5e-3, "{found} {delay}");
        }
    }

    #[test]
    fn noise_a_steady_beat_and_silence_tell_no_delay() {
        let noise = |seed| heard(10.0, &[], 0.0, seed);
        assert_eq!(sound_delay_s(&noise(1), &noise(2), 3.0), None);
        let beat: Vec<f64> = (0..20).map(|i| 0.5 * f64::from(i)).collect();
        assert_eq!(
            sound_delay_s(&heard(10.0, &beat, 1.0, 1), &heard(10.0, &beat, 1.0, 2), 3.0),
            None
        );
        let silence = vec![0.0; 10_000];
        assert_eq!(sound_delay_s(&silence, &silence, 3.0), None);
        assert_eq!(sound_delay_s(&[], &silence, 3.0), None);
    }
}
