//! The summit of a limb's field on a ray: a mixture in one dimension, climbed.

use crate::math::exponential::exp;

/// A climb ends with the first Newton step that is less than this, metres. The error that is left is of the order of its
/// square over the size of a metaball, 1e-9 m, and r depends only on the square of that, because x* is a summit.
const LAST_STEP_M: f64 = 1e-5;

/// Sums are of so many partial sums, so that they are the same for every width of vectors.
pub(super) const LANES: usize = 4;

/// A climb ends after so many steps in any case; most take four.
const MOST_STEPS: usize = 60;

/// What the metaballs of a limb that are not too faint add along the ray: one number for each, in whole lanes.
#[derive(Debug, Clone, Default)]
pub(super) struct Bumps {
    nearest: Vec<f64>,
    at: Vec<f64>,
    sharpness: Vec<f64>,
    /// a (t − tᵢ), at the place that was looked at last.
    lean: Vec<f64>,
    /// f there.
    value: Vec<f64>,
}

impl Bumps {
    pub(super) fn clear(&mut self) {
        self.nearest.clear();
        self.at.clear();
        self.sharpness.clear();
    }

    pub(super) fn push(&mut self, nearest: f64, at: f64, sharpness: f64) {
        self.nearest.push(nearest);
        self.at.push(at);
        self.sharpness.push(sharpness);
    }

    /// Fills the last lanes with what is too faint to be seen.
    pub(super) fn fill(&mut self) {
        let whole = self.nearest.len().next_multiple_of(LANES);
        self.nearest.resize(whole, f64::INFINITY);
        self.at.resize(whole, 0.0);
        self.sharpness.resize(whole, 0.0);
        self.lean.resize(whole, 0.0);
        self.value.resize(whole, 0.0);
    }
}

/// Where F is largest, and ln F there.
#[derive(Debug, Clone, Copy)]
pub(super) struct Summit {
    pub(super) at: f64,
    pub(super) log_value: f64,
}

/// F(t), the derivatives of ln F, and where mean shift goes.
#[derive(Debug, Clone, Copy)]
struct Slope {
    value: f64,
    first: f64,
    second: f64,
    mean: f64,
}

/// The sum of each metaball's own summit: F is nowhere more.
#[multiversion::multiversion(targets("x86_64+avx2"))]
pub(super) fn sum_of_summits(bumps: &mut Bumps) -> f64 {
    for (value, nearest) in bumps.value.iter_mut().zip(&bumps.nearest) {
        *value = exp(-2.0 * nearest);
    }
    let blocks = bumps.value.as_chunks::<LANES>().0.iter();
    sum(blocks.fold([0.0; LANES], |sum, f| std::array::from_fn(|k| sum[k] + f[k])))
}

/// The summit reached from `start`; the bits are those of every instruction set.
#[multiversion::multiversion(targets("x86_64+avx2"))]
pub(super) fn climb(bumps: &mut Bumps, start: f64) -> Summit {
    let mut t = start;
    let mut here = slope(bumps, t);
    // what the last step adds to ln F
    let mut gained = 0.0;
    for _ in 0..MOST_STEPS {
        let newton = -here.first / here.second;
        if here.second < 0.0 && newton.abs() < LAST_STEP_M {
            t += newton;
            gained = 0.5 * here.first * newton;
            break;
        }
        // Newton only where it climbs: elsewhere mean shift does
        let mut next = if here.second < 0.0 { t + newton } else { here.mean };
        let mut there = slope(bumps, next);
        if there.value < here.value && here.second < 0.0 {
            next = here.mean;
            there = slope(bumps, next);
        }
        (t, here) = (next, there);
    }
    Summit { at: t, log_value: here.value.ln() + gained }
}

#[inline(always)]
fn slope(bumps: &mut Bumps, t: f64) -> Slope {
    // slices of one length: the loop needs no checks of bounds and is vectorised
    let n = bumps.nearest.len();
    let (nearest, at, sharpness) = (&bumps.nearest[..n], &bumps.at[..n], &bumps.sharpness[..n]);
    let (leans, values) = (&mut bumps.lean[..n], &mut bumps.value[..n]);
    for i in 0..n {
        let lean = sharpness[i] * (t - at[i]);
        leans[i] = lean;
        values[i] = exp(-2.0 * (nearest[i] + lean * (t - at[i])));
    }

    // F, the sums of its derivatives without their constant factors, and mean shift's
    let [mut value, mut first, mut second, mut pull, mut weight] = [[0.0; LANES]; 5];
    let blocks = values.as_chunks::<LANES>().0.iter().zip(leans.as_chunks::<LANES>().0);
    let blocks = blocks.zip(at.as_chunks::<LANES>().0).zip(sharpness.as_chunks::<LANES>().0);
    for (((f, lean), at), sharpness) in blocks {
        for k in 0..LANES {
            value[k] += f[k];
            first[k] += f[k] * lean[k];
            second[k] += f[k] * (4.0 * lean[k] * lean[k] - sharpness[k]);
            weight[k] += f[k] * sharpness[k];
            pull[k] += f[k] * sharpness[k] * at[k];
        }
    }

    let value = sum(value);
    let first = -4.0 * sum(first) / value;
    Slope {
        value,
        first,
        second: 4.0 * sum(second) / value - first * first,
        mean: sum(pull) / sum(weight),
    }
}

#[inline(always)]
fn sum(lanes: [f64; LANES]) -> f64 {
    (lanes[0] + lanes[1]) + (lanes[2] + lanes[3])
}
