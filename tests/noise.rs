//! How residuals err is found again from simulated ones whose scale, correlation and repetition are known.
//!
//! Every number is drawn with a fixed seed. The tolerances are three to four standard errors of the estimates.

use maquette::body::PartId;
use maquette::inference::noise::Noise;
use maquette::likelihood::{PlacedResidual, Source};
use maquette::solver::Loss;
use nalgebra::{Vector2, Vector3};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

const FPS: f64 = 25.0;
const FRAMES: usize = 120;
const VIEWS: usize = 4;
/// Rows of a border, and the observations that each is stated to be.
const ROWS: usize = 150;
const WEIGHT: f64 = 0.2;
/// Rows that lie at one place of the body.
const ROWS_A_PLACE: usize = 10;

/// What is simulated.
#[derive(Clone, Copy)]
struct Truth {
    /// Standard deviation, of stated ones.
    scale: f64,
    /// Length over which neighbours go together, ρ(u) = exp(−u/length), in stated observations; 0: not at all.
    length: f64,
    /// Share of the variance that belongs to the place and returns in every frame and view.
    repeated: f64,
}

const INDEPENDENT: Truth = Truth { scale: 1.0, length: 0.0, repeated: 0.0 };

fn normal(rng: &mut ChaCha8Rng) -> f64 {
    StandardNormal.sample(rng)
}

/// ROWS values of variance 1 that go together over `length`.
fn border(length: f64, rng: &mut ChaCha8Rng) -> Vec<f64> {
    let rho = if length > 0.0 { (-WEIGHT / length).exp() } else { 0.0 };
    let mut last = normal(rng);
    let mut next = |_| {
        last = rho * last + (1.0 - rho * rho).sqrt() * normal(rng);
        last
    };
    (0..ROWS).map(&mut next).collect()
}

/// One place every ten rows, ten centimetres apart.
fn row(view: usize, index: usize, value: f64) -> PlacedResidual {
    PlacedResidual {
        source: Source::View(view),
        value,
        trust: 1.0,
        sigma: 1.0,
        weight: WEIGHT,
        outward_px: Vector2::x(),
        part: PartId(0),
        place_part: Vector3::new(0.05, 0.05, 0.05 + 0.1 * (index / ROWS_A_PLACE) as f64),
    }
}

fn simulate(truth: Truth, seed: u64) -> (Vec<Vec<PlacedResidual>>, Vec<f64>) {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let returning = border(truth.length, &mut rng);
    let frame = |_| -> Vec<PlacedResidual> {
        let views = (0..VIEWS).flat_map(|view| {
            let own = border(truth.length, &mut rng);
            let both = returning.iter().zip(own).enumerate();
            let (again, new) = (truth.repeated.sqrt(), (1.0 - truth.repeated).sqrt());
            let value = |(i, (r, o)): (usize, (&f64, f64))| {
                row(view, i, truth.scale * (again * r + new * o))
            };
            both.map(value).collect::<Vec<_>>()
        });
        views.collect()
    };
    let frames = (0..FRAMES).map(frame).collect();
    let seconds = (0..FRAMES).map(|i| i as f64 / FPS).collect();
    (frames, seconds)
}

fn estimated(truth: Truth, seed: u64) -> Noise {
    let (frames, seconds) = simulate(truth, seed);
    Noise::from_residuals(&frames, &seconds, &[])
}

#[test]
fn residuals_that_err_as_stated_and_independently_are_found_so() {
    let noise = estimated(INDEPENDENT, 1);
    // clipped at three standard deviations: 0.4 % of a normal's variance
    approx::assert_relative_eq!(noise.scale, 1.0, max_relative = 0.01);
    // each row is an observation of its own, five to one that was stated
    approx::assert_relative_eq!(noise.along_border, WEIGHT, max_relative = 0.05);
    assert!(noise.repeated < 0.1, "{noise:?}");
    // P is known to V·√2/(N√places), so τ = 1 + N·P/V to 0.37, and never below 1
    assert!(noise.over_time < 2.1, "{noise:?}");
}

#[test]
fn the_scale_is_found_whatever_it_is() {
    for scale in [0.3, 1.7, 5.0] {
        let noise = estimated(Truth { scale, ..INDEPENDENT }, 2);
        approx::assert_relative_eq!(noise.scale, scale, max_relative = 0.01);
        let weight = 1.0 / (noise.scale.powi(2) * noise.along_border * noise.within_frame);
        approx::assert_relative_eq!(noise.data_weight(), weight);
    }
}

/// λ = ∫exp(−|u|/l)du = 2l; what lies below ρ = 0.05 is left out, 5 % of it.
#[test]
fn the_length_along_the_border_is_found() {
    for length in [0.5, 1.0, 2.0] {
        let truth = Truth { length, ..INDEPENDENT };
        let found = estimated(truth, 3).along_border;
        approx::assert_relative_eq!(found, 2.0 * length * 0.95, max_relative = 0.1);
    }
}

/// Rows twice and five times as far apart as those of every other test, so that whole bins of distances hold no pair.
#[test]
fn the_length_is_found_however_far_apart_the_rows_are() {
    for every in [2, 5] {
        let (frames, seconds) = simulate(Truth { length: 2.0, ..INDEPENDENT }, 3);
        let thinned = |rows: &Vec<PlacedResidual>| -> Vec<PlacedResidual> {
            let wider =
                |row: &PlacedResidual| PlacedResidual { weight: every as f64 * WEIGHT, ..*row };
            rows.iter().step_by(every).map(wider).collect()
        };
        let thinned: Vec<_> = frames.iter().map(thinned).collect();
        let found = Noise::from_residuals(&thinned, &seconds, &[]).along_border;
        approx::assert_relative_eq!(found, 4.0 * 0.95, max_relative = 0.15);
    }
}

/// Of V = P + I of a place's mean residual, P is `repeated` of the whole: both go together alike along the border.
#[test]
fn what_returns_in_every_frame_is_found() {
    for repeated in [0.2, 0.5, 0.9] {
        let truth = Truth { length: 1.0, repeated, ..INDEPENDENT };
        // there are few places, and each returns with one draw: the variance of 15 squares, averaged over five seeds
        let seeds = 10..15;
        let count = 5.0;
        let found: f64 = seeds.map(|seed| estimated(truth, seed).repeated.powi(2)).sum();
        approx::assert_abs_diff_eq!(found / count, repeated, epsilon = 0.12);
    }
}

#[test]
fn the_more_returns_the_fewer_observations_are_worth_one() {
    let over_time = |repeated| {
        let truth = Truth { repeated, ..INDEPENDENT };
        estimated(truth, 4).over_time
    };
    let [none, some, most] = [0.0, 0.3, 0.9].map(over_time);
    assert!(none < some && some < most, "{none} {some} {most}");
    // if everything returned, the N observations of a place would be worth one
    let all = (FRAMES * VIEWS) as f64;
    assert!(most > 0.5 * all && most <= all, "{most} of {all}");
}

/// μ = 1 + (k − 1)·P/V of the k = 4 cameras that show every place.
#[test]
fn cameras_that_show_one_place_share_what_returns() {
    let alone = estimated(INDEPENDENT, 6);
    assert!((1.0..1.02).contains(&alone.within_frame), "{alone:?}");
    let truth = Truth { repeated: 0.9, ..INDEPENDENT };
    let shared = estimated(truth, 6);
    let expected = 1.0 + (VIEWS as f64 - 1.0) * shared.repeated.powi(2);
    approx::assert_relative_eq!(shared.within_frame, expected, max_relative = 1e-9);
    assert!(shared.within_frame > 3.0, "{shared:?}");
}

#[test]
fn a_few_wild_rows_change_little() {
    let (mut frames, seconds) = simulate(INDEPENDENT, 5);
    for frame in &mut frames {
        for row in frame.iter_mut().step_by(100) {
            row.value = 1e3;
            row.trust = Loss::Cauchy(3.0).evaluate(row.value).1;
        }
    }
    let noise = Noise::from_residuals(&frames, &seconds, &[]);
    assert!((0.97..1.03).contains(&noise.scale), "{noise:?}");
}

/// What returns on both sides alike is one thing for a shape that both sides share.
#[test]
fn two_sides_that_err_alike_are_one() {
    let truth = Truth { repeated: 0.5, ..INDEPENDENT };
    let (right, seconds) = simulate(truth, 11);
    let (own, _) = simulate(truth, 12);
    let left = |values: &[PlacedResidual]| {
        let mirrored = |row: &PlacedResidual| PlacedResidual {
            part: PartId(1),
            place_part: row.place_part.component_mul(&Vector3::new(1.0, -1.0, 1.0)),
            ..*row
        };
        values.iter().map(mirrored).collect::<Vec<_>>()
    };
    let both = |other: &[Vec<PlacedResidual>]| -> Vec<Vec<PlacedResidual>> {
        let frames = right.iter().zip(other);
        frames.map(|(r, l)| [r.clone(), left(l)].concat()).collect()
    };
    let tau = |frames: &[Vec<PlacedResidual>], pairs: &[(usize, usize)]| {
        Noise::from_residuals(frames, &seconds, pairs).over_time
    };
    let (alike, unlike) = (both(&right), both(&own));
    let [together, apart] = [&[(0, 1)][..], &[]].map(|pairs| tau(&alike, pairs));
    approx::assert_relative_eq!(together, 2.0 * apart, max_relative = 0.05);
    let [together, apart] = [&[(0, 1)][..], &[]].map(|pairs| tau(&unlike, pairs));
    approx::assert_relative_eq!(together, apart, max_relative = 0.1);
}

#[test]
fn nothing_seen_is_no_fault() {
    for frames in [vec![], vec![Vec::new(); 3]] {
        let seconds = vec![0.0; frames.len()];
        let noise = Noise::from_residuals(&frames, &seconds, &[]);
        let numbers = [noise.scale, noise.along_border, noise.over_time];
        assert!(numbers.iter().all(|v| v.is_finite() && *v > 0.0), "{noise:?}");
        assert!(noise.data_weight().is_finite());
    }
}
