//! Where curves of two groups differ: against spm1d, and how often they do so by chance.

use maquette::gait::trials::CurveTest;
use maquette::math::random_field::TField;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use serde::Deserialize;

#[derive(Deserialize)]
struct Oracle {
    cases: Vec<Case>,
    thresholds: Vec<Threshold>,
}

#[derive(Deserialize)]
struct Case {
    name: String,
    before: Vec<Vec<f64>>,
    after: Vec<Vec<f64>>,
    t: Vec<f64>,
    freedom: f64,
    fwhm: f64,
    threshold: f64,
    stretches: Vec<Stretch>,
}

#[derive(Deserialize)]
struct Stretch {
    start: f64,
    end: f64,
    p: f64,
}

#[derive(Deserialize)]
struct Threshold {
    freedom: f64,
    fwhm: f64,
    height: f64,
}

/// What spm1d found; `oracles/spm1d_curves.py` made it.
fn oracle() -> Oracle {
    serde_json::from_str(include_str!("oracles/spm1d_curves.json")).expect("the oracle's numbers")
}

fn compared(before: &[Vec<f64>], after: &[Vec<f64>]) -> CurveTest {
    tested(before, after).expect("two groups of curves")
}

fn tested(before: &[Vec<f64>], after: &[Vec<f64>]) -> Option<CurveTest> {
    CurveTest::new(&slices(before), &slices(after))
}

fn slices(curves: &[Vec<f64>]) -> Vec<&[f64]> {
    curves.iter().map(Vec::as_slice).collect()
}

#[test]
fn curves_differ_where_spm1d_says_so() {
    for case in oracle().cases {
        let name = &case.name;
        let found = compared(&case.before, &case.after);
        for (ours, theirs) in found.t.iter().zip(&case.t) {
            approx::assert_relative_eq!(ours, theirs, epsilon = 1e-6, max_relative = 1e-6);
        }
        approx::assert_relative_eq!(found.field.freedom, case.freedom);
        approx::assert_relative_eq!(found.field.fwhm, case.fwhm, max_relative = 1e-6);
        approx::assert_relative_eq!(found.threshold, case.threshold, epsilon = 1e-4);

        assert_eq!(found.stretches.len(), case.stretches.len(), "{name}");
        for (ours, theirs) in found.stretches.iter().zip(&case.stretches) {
            approx::assert_relative_eq!(ours.from, theirs.start, epsilon = 1e-3);
            approx::assert_relative_eq!(ours.to, theirs.end, epsilon = 1e-3);
            approx::assert_relative_eq!(ours.p, theirs.p, epsilon = 1e-6, max_relative = 1e-3);
        }
    }
}

#[test]
fn thresholds_are_those_of_spm1d() {
    for theirs in oracle().thresholds {
        let field = TField { freedom: theirs.freedom, places: 101, fwhm: theirs.fwhm };
        approx::assert_relative_eq!(field.height(0.025), theirs.height, epsilon = 1e-3);
    }
}

#[test]
fn a_group_of_two_and_a_curve_with_a_gap_are_not_tested() {
    let wavy = |offset: f64| (0..11).map(|i| offset + (offset * f64::from(i)).sin()).collect();
    let group = |offsets: &[f64]| offsets.iter().map(|o| wavy(*o)).collect::<Vec<Vec<f64>>>();
    let other = group(&[0.5, 1.0, 3.0]);
    assert!(tested(&group(&[0.0, 1.0, 2.0]), &other).is_some());
    assert!(tested(&group(&[0.0, 1.0]), &other).is_none());
    assert!(tested(&group(&[0.0, 1.0, f64::NAN]), &other).is_none());
    // curves that differ by offsets alone have slopes of nothing: no smoothness, no test
    let flat = [0.0, 1.0, 2.0].map(|v| vec![v; 11]);
    assert!(tested(&flat, &flat).is_none());
}

/// Curves of a person who does not change: noise of a full width at half maximum of 15 places.
fn smooth_noise(count: usize, rng: &mut ChaCha8Rng) -> Vec<Vec<f64>> {
    let sigma = 15.0 / (8.0 * 2.0_f64.ln()).sqrt();
    let reach = (4.0 * sigma) as usize;
    let weight = |step: usize| (-0.5 * ((step as f64 - reach as f64) / sigma).powi(2)).exp();
    let weights: Vec<f64> = (0..=2 * reach).map(weight).collect();
    let mut curve = || {
        let white: Vec<f64> = (0..101 + 2 * reach).map(|_| StandardNormal.sample(rng)).collect();
        let smooth = |at: usize| weights.iter().zip(&white[at..]).map(|(w, v)| w * v).sum();
        (0..101).map(smooth).collect()
    };
    (0..count).map(|_| curve()).collect()
}

/// Whether a share of so many experiments is one in twenty, within three standard errors.
fn is_one_in_twenty(share: f64, experiments: usize) -> bool {
    (share - 0.05).abs() < 3.0 * (0.05 * 0.95 / experiments as f64).sqrt()
}

#[test]
fn a_person_who_has_not_changed_exceeds_the_threshold_once_in_twenty_times() {
    let mut rng = ChaCha8Rng::seed_from_u64(2015);
    let (experiments, mut beyond, mut beyond_at_a_place) = (2000, 0, 0);
    for _ in 0..experiments {
        let found = compared(&smooth_noise(5, &mut rng), &smooth_noise(5, &mut rng));
        beyond += usize::from(!found.stretches.is_empty());
        // what holds at one place (t of 8 degrees of freedom) does not hold for all
        beyond_at_a_place += usize::from(found.t.iter().any(|t| t.abs() > 2.306));
    }
    let share = |count: usize| count as f64 / experiments as f64;
    assert!(is_one_in_twenty(share(beyond), experiments), "{}", share(beyond));
    assert!(!is_one_in_twenty(share(beyond_at_a_place), experiments));
}
