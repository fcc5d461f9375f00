//! Where over the cycle the curves of two sessions differ: statistical parametric mapping of one dimension.
//!
//! The observations are the mean curves of the trials: strides of one trial are not independent of each other, and more of them in
//! a trial would make a difference look surer than it is. Of K_a and K_b trials with the means a and b, at every place of the cycle
//!
//! t = (b − a) / √(s²(1/K_a + 1/K_b)), s² pooled over both sessions, ν = K_a + K_b − 2.
//!
//! Two curves of a person who has not changed exceed ± t* anywhere once in twenty times, and each stretch beyond t* has a
//! probability, both by random field theory ([`TField`]) with the smoothness of the residuals.
//!
//! # Source
//! Pataky 2010, J Biomech 43:1976–1982; Pataky, Vanrenterghem & Robinson 2015, J Biomech 48:1277–1285. The variance is pooled, as
//! there: Welch's degrees of freedom would differ from place to place, for which the theory has no threshold.

use crate::gait::{Angle, Curve, Side};
use crate::math::random_field::{TField, fwhm};
use crate::math::stats::mean;

/// Fewer trials in a session are not tested: their spread is not known well enough.
pub const LEAST_TRIALS: usize = 3;

/// How often a person who has not changed exceeds the threshold, in both directions together.
const ALPHA: f64 = 0.05;

/// A stretch of the cycle in which two sessions differ by more than the threshold.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stretch {
    /// Where it begins, in places of the curve; between two of them where t crosses the threshold.
    pub from: f64,
    /// Where it ends.
    pub to: f64,
    /// The t that is farthest from 0 in it.
    pub peak: f64,
    /// The probability of a stretch as wide by chance, in both directions together.
    pub p: f64,
}

/// Two groups of curves compared at every place.
#[derive(Debug, Clone, PartialEq)]
pub struct CurveTest {
    /// t at every place; positive where the second group is higher.
    pub t: Vec<f64>,
    /// The field that t is of one person who has not changed.
    pub field: TField,
    /// t*, which |t| exceeds anywhere once in twenty times by chance.
    pub threshold: f64,
    /// Stretches beyond ± t*, in the order of the cycle.
    pub stretches: Vec<Stretch>,
}

/// The curves of one angle and side in two sessions.
#[derive(Debug, Clone, PartialEq)]
pub struct CurveChange {
    /// Which.
    pub angle: Angle,
    /// Of which side's cycle.
    pub side: Side,
    /// Trials of the first and of the second session that have it.
    pub trials: [usize; 2],
    /// How they differ.
    pub test: CurveTest,
}

impl CurveTest {
    /// Compares two groups of curves; `None` with fewer than [`LEAST_TRIALS`] in one, of unequal lengths, with numbers that are not
    /// finite, and where no curve differs from its group's mean.
    pub fn new(before: &[&[f64]], after: &[&[f64]]) -> Option<Self> {
        let places = before.first()?.len();
        let mut all = before.iter().chain(after);
        let is_whole = all.all(|c| c.len() == places && c.iter().all(|v| v.is_finite()));
        if !is_whole || before.len().min(after.len()) < LEAST_TRIALS {
            return None;
        }

        // t, with the variance of both
        let [means_before, means_after] = [before, after].map(|group| means(group, places));
        let mut residuals = off(before, &means_before);
        residuals.extend(off(after, &means_after));
        let freedom = residuals.len() as f64 - 2.0;
        let share = 1.0 / before.len() as f64 + 1.0 / after.len() as f64;
        let t_at = |at: usize| {
            let squares: f64 = residuals.iter().map(|r| r[at] * r[at]).sum();
            let sem = (squares / freedom * share).sqrt();
            (means_after[at] - means_before[at]) / sem.max(f64::MIN_POSITIVE)
        };
        let t: Vec<f64> = (0..places).map(t_at).collect();

        // how high it may be by chance
        let field = TField { freedom, places, fwhm: fwhm(&residuals)? };
        let threshold = field.height(0.5 * ALPHA);
        let stretches = stretches(&t, &field, threshold);
        Some(Self { t, field, threshold, stretches })
    }
}

/// Every curve that both sessions have in three trials or more; `before` and `after` hold the curves of each trial.
pub fn curve_changes(before: &[&[Curve]], after: &[&[Curve]]) -> Vec<CurveChange> {
    let pairs = Angle::ALL.into_iter().flat_map(|angle| Side::BOTH.map(|side| (angle, side)));
    let changed = |(angle, side)| {
        let [a, b] = [before, after].map(|trials| of(trials, angle, side));
        let test = CurveTest::new(&a, &b)?;
        Some(CurveChange { angle, side, trials: [a.len(), b.len()], test })
    };
    pairs.filter_map(changed).collect()
}

/// One curve of each trial that has it.
fn of<'a>(trials: &[&'a [Curve]], angle: Angle, side: Side) -> Vec<&'a [f64]> {
    let is_it = |curve: &&Curve| curve.angle == angle && curve.side == side;
    let own = trials.iter().filter_map(|curves| curves.iter().find(is_it));
    own.map(|curve| curve.mean.as_slice()).collect()
}

fn means(group: &[&[f64]], places: usize) -> Vec<f64> {
    (0..places).map(|at| mean(group.iter().map(|c| c[at])).unwrap_or(f64::NAN)).collect()
}

fn off(group: &[&[f64]], means: &[f64]) -> Vec<Vec<f64>> {
    group.iter().map(|c| c.iter().zip(means).map(|(v, mean)| v - mean).collect()).collect()
}

/// The stretches beyond ± the threshold, their ends where the line between two places crosses it.
fn stretches(t: &[f64], field: &TField, threshold: f64) -> Vec<Stretch> {
    let state = |value: &f64| (value.abs() >= threshold).then_some(*value > 0.0);
    let mut found = Vec::new();
    let mut first = 0;
    for run in t.chunk_by(|a, b| state(a) == state(b)) {
        let last = first + run.len() - 1;
        if state(&run[0]).is_some() {
            let sign = run[0].signum();
            // how far from an outer place the threshold is crossed, as a share of the step inwards
            let share = |inner: usize, outer: usize| {
                let (inner, outer) = (sign * t[inner], sign * t[outer]);
                (inner - threshold) / (inner - outer)
            };
            let from = match first {
                0 => 0.0,
                _ => first as f64 - share(first, first - 1),
            };
            let to = match last + 1 < t.len() {
                true => last as f64 + share(last, last + 1),
                false => last as f64,
            };
            let peak = run.iter().map(|v| v.abs()).fold(0.0, f64::max) * sign;
            // a stretch of a single place at an end of the cycle counts as one place wide
            let width = if to > from { to - from } else { 1.0 };
            let p = (2.0 * field.stretch(threshold, width)).min(1.0);
            found.push(Stretch { from, to, peak, p });
        }
        first = last + 1;
    }
    found
}
