//! How residuals err is found again from simulated ones whose scale and correlations are known.
//!
//! Every number is drawn with a fixed seed. The tolerances are three to four standard errors of the estimates.

use maquette::body::PartId;
use maquette::inference::noise::{DataWeights, Noise, SurfaceNoise};
use maquette::likelihood::{PlacedResidual, Source};
use maquette::solver::Loss;
use nalgebra::{Vector2, Vector3};
use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

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
}

const INDEPENDENT: Truth = Truth { scale: 1.0, length: 0.0 };

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

fn simulate(truth: Truth, seed: u64) -> Vec<Vec<PlacedResidual>> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let frame = |_| -> Vec<PlacedResidual> {
        let views = (0..VIEWS).flat_map(|view| {
            let own = border(truth.length, &mut rng).into_iter().enumerate();
            own.map(|(i, value)| row(view, i, truth.scale * value)).collect::<Vec<_>>()
        });
        views.collect()
    };
    (0..FRAMES).map(frame).collect()
}

fn estimated(truth: Truth, seed: u64) -> SurfaceNoise {
    of_outlines(&simulate(truth, seed))
}

fn of_outlines(frames: &[Vec<PlacedResidual>]) -> SurfaceNoise {
    Noise::from_residuals(frames).outlines.expect("there are outlines")
}

#[test]
fn residuals_that_err_as_stated_and_independently_are_found_so() {
    let noise = estimated(INDEPENDENT, 1);
    // clipped at three standard deviations: 0.4 % of a normal's variance
    approx::assert_relative_eq!(noise.scale, 1.0, max_relative = 0.01);
    // each row is an observation of its own, five to one that was stated
    approx::assert_relative_eq!(noise.along_border, WEIGHT, max_relative = 0.05);
    // squares of 15 sums: a standard error of √(2/15), and never below 1
    assert!((1.0..2.1).contains(&noise.together), "{noise:?}");
}

#[test]
fn the_scale_is_found_whatever_it_is() {
    for scale in [0.3, 1.7, 5.0] {
        let noise = estimated(Truth { scale, ..INDEPENDENT }, 2);
        approx::assert_relative_eq!(noise.scale, scale, max_relative = 0.01);
        let weight = 1.0 / (noise.scale.powi(2) * noise.along_border * noise.together);
        let all = Noise { outlines: Some(noise), ..Noise::default() };
        approx::assert_relative_eq!(all.weights().outlines, weight, max_relative = 1e-12);
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
        let frames = simulate(Truth { length: 2.0, ..INDEPENDENT }, 3);
        let thinned = |rows: &Vec<PlacedResidual>| -> Vec<PlacedResidual> {
            let wider =
                |row: &PlacedResidual| PlacedResidual { weight: every as f64 * WEIGHT, ..*row };
            rows.iter().step_by(every).map(wider).collect()
        };
        let thinned: Vec<_> = frames.iter().map(thinned).collect();
        let found = of_outlines(&thinned).along_border;
        approx::assert_relative_eq!(found, 4.0 * 0.95, max_relative = 0.15);
    }
}

/// What k = 4 cameras share of each frame, and what lasts, ρ = exp(−t/T), both count: τ = k(1 + 2Σρ) of a whole variance.
/// Where a contour is cut into pieces a few rows are short: what they say of each other is too little to say where ρ ends.
#[test]
fn a_few_short_rows_do_not_hide_that_neighbours_go_together() {
    let mut frames = simulate(Truth { scale: 1.0, length: 0.6 }, 5);
    let whole = of_outlines(&frames).along_border;
    for frame in &mut frames {
        let short = [1.0, -1.0].map(|value| PlacedResidual { weight: 0.01, ..row(0, 0, value) });
        frame.splice(0..0, short);
    }
    let found = of_outlines(&frames).along_border;
    approx::assert_relative_eq!(found, whole, max_relative = 0.05);
}

#[test]
fn looks_that_go_together_are_worth_one() {
    let lasts_s = 0.06;
    let lasting = |fps: f64, seed: u64| {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let rho = (-1.0 / (fps * lasts_s)).exp();
        let mut of_place: Vec<f64> = (0..400).map(|_| normal(&mut rng)).collect();
        let frame = |_| -> Vec<PlacedResidual> {
            for y in &mut of_place {
                *y = rho * *y + (1.0 - rho * rho).sqrt() * normal(&mut rng);
            }
            let rows = (0..VIEWS).flat_map(|view| {
                of_place.iter().enumerate().map(move |(i, y)| row(view, i * ROWS_A_PLACE, *y))
            });
            rows.collect()
        };
        let frames: Vec<_> = (0..(10.0 * fps) as usize).map(frame).collect();
        (of_outlines(&frames).together, (1.0 + rho) / (1.0 - rho))
    };
    for fps in [25.0, 50.0] {
        let (found, in_time) = lasting(fps, 7);
        // the variance of 400 squares, three standard errors
        approx::assert_relative_eq!(found, VIEWS as f64 * in_time, max_relative = 0.22);
    }
}

/// A fold that stays is one look, however often it is seen: twice the frames are twice the τ.
#[test]
fn what_stays_is_seen_once() {
    let stays = |count: usize| {
        let mut rng = ChaCha8Rng::seed_from_u64(9);
        let fold: Vec<f64> = (0..ROWS).map(|_| normal(&mut rng)).collect();
        let frame =
            |_| fold.iter().enumerate().map(|(i, y)| row(0, i * ROWS_A_PLACE, *y)).collect();
        let frames: Vec<Vec<PlacedResidual>> = (0..count).map(frame).collect();
        Noise::from_residuals(&frames)
    };
    for count in [1, 20, 40] {
        let noise = stays(count);
        let outlines = noise.outlines.expect("there are outlines");
        approx::assert_relative_eq!(outlines.together, count as f64, max_relative = 1e-9);
        approx::assert_relative_eq!(outlines.in_one_frame, 1.0, max_relative = 1e-9);
        let share = 1.0 - 1.0 / count as f64;
        approx::assert_relative_eq!(noise.staying_share(), share, epsilon = 1e-9);
    }
}

/// What passes does not stay, and what all cameras see alike is one look of a frame.
#[test]
fn what_all_cameras_share_in_a_frame_does_not_stay() {
    let mut rng = ChaCha8Rng::seed_from_u64(13);
    let frame = |_| -> Vec<PlacedResidual> {
        let shared: Vec<f64> = (0..ROWS).map(|_| normal(&mut rng)).collect();
        let view =
            |view| shared.iter().enumerate().map(move |(i, y)| row(view, i * ROWS_A_PLACE, *y));
        (0..VIEWS).flat_map(view).collect()
    };
    let frames: Vec<_> = (0..FRAMES).map(frame).collect();
    let noise = Noise::from_residuals(&frames);
    let in_one_frame = noise.outlines.map(|outlines| outlines.in_one_frame);
    approx::assert_relative_eq!(in_one_frame.unwrap(), VIEWS as f64, max_relative = 1e-9);
    // 150 squares: three standard errors of τ
    assert!(noise.staying_share().abs() < 0.35, "{noise:?}");

    // of ROWS·FRAMES values that were drawn, λ of a row each: as many independent observations
    let independent = (ROWS * FRAMES) as f64;
    approx::assert_relative_eq!(noise.independent(&frames), independent, max_relative = 0.45);
}

#[test]
fn a_few_wild_rows_change_little() {
    let mut frames = simulate(INDEPENDENT, 5);
    for frame in &mut frames {
        for row in frame.iter_mut().step_by(100) {
            row.value = 1e3;
            row.trust = Loss::Cauchy(3.0).evaluate(row.value).1;
        }
    }
    let noise = of_outlines(&frames);
    assert!((0.97..1.03).contains(&noise.scale), "{noise:?}");
}

/// One camera's detections of a joint along one axis: half of their variance is the same in every frame, so of n frames
/// (1 + n)/2 are worth one.
#[test]
fn detections_that_err_alike_in_every_frame_count_as_few_and_change_nothing_of_the_outlines() {
    const JOINTS: usize = 40;
    let mut rng = ChaCha8Rng::seed_from_u64(12);
    let outlines = simulate(INDEPENDENT, 12);
    let constant: Vec<f64> = (0..2 * JOINTS).map(|_| normal(&mut rng)).collect();
    let mut frames = outlines.clone();
    for frame in &mut frames {
        for (k, constant) in constant.iter().enumerate() {
            let value = 3.0 * (constant + normal(&mut rng)) / 2.0_f64.sqrt();
            let outward_px = Vector2::ith(k % 2, 1.0);
            let own = row(0, ROWS_A_PLACE * (k / 2), value);
            let source = Source::Keypoint { camera: 0, keypoint: k / 2 };
            frame.push(PlacedResidual { source, outward_px, ..own });
        }
    }
    let noise = Noise::from_residuals(&frames);
    let found = noise.keypoints.expect("there are detections");
    approx::assert_relative_eq!(found.scale, 3.0, max_relative = 0.15);
    // of 80 clusters: a standard error of √(2/80)
    approx::assert_relative_eq!(found.together, 0.5 * (1.0 + FRAMES as f64), max_relative = 0.5);
    approx::assert_relative_eq!(found.in_a_row, 1.0, epsilon = 0.1);
    assert_eq!(Noise { keypoints: None, ..noise }, Noise::from_residuals(&outlines));

    // beside outlines a frame's detections count as in that frame, and as long as outlines stay
    let of_outlines = noise.outlines.expect("there are outlines");
    let passes = of_outlines.in_one_frame / of_outlines.together;
    let expected = passes / (found.scale.powi(2) * found.in_a_row);
    approx::assert_relative_eq!(noise.weights().keypoints, expected, max_relative = 1e-12);
    let alone = Noise { outlines: None, ..noise }.weights().keypoints;
    let expected = 1.0 / (found.scale.powi(2) * found.together);
    approx::assert_relative_eq!(alone, expected, max_relative = 1e-12);
}

/// Errors of autocorrelation ρᵏ over k frames about a constant: (1 + ρ)/(1 − ρ) in a row are worth one, less what lies below .05 and what
/// the mean takes away, a sixth where errors last nine of 400 frames. Two keypoints lie at one place of the body.
#[test]
fn how_long_errors_of_detections_last_is_told_from_what_stays() {
    const KEYPOINTS: usize = 40;
    const LONG: usize = 400;
    for rho in [0.0, 0.5, 0.8_f64] {
        let mut rng = ChaCha8Rng::seed_from_u64(15);
        let constant: Vec<f64> = (0..KEYPOINTS).map(|_| 2.0 * normal(&mut rng)).collect();
        let mut last: Vec<f64> = (0..KEYPOINTS).map(|_| normal(&mut rng)).collect();
        let mut frame = |_| {
            let of_keypoint = |(keypoint, last): (usize, &mut f64)| {
                *last = rho * *last + (1.0 - rho * rho).sqrt() * normal(&mut rng);
                let own = row(0, ROWS_A_PLACE * (keypoint / 2), constant[keypoint] + *last);
                let source = Source::Keypoint { camera: 0, keypoint };
                PlacedResidual { source, ..own }
            };
            last.iter_mut().enumerate().map(of_keypoint).collect()
        };
        let frames: Vec<Vec<PlacedResidual>> = (0..LONG).map(&mut frame).collect();
        let found = Noise::from_residuals(&frames).keypoints.expect("there are detections");
        let expected = (1.0 + rho) / (1.0 - rho);
        assert!((0.8 * expected..1.05 * expected).contains(&found.in_a_row), "{found:?}");
        assert!(found.together > 10.0 * found.in_a_row, "{found:?}");
    }
}

/// A cloud three times worse than stated, and outlines as they are stated.
#[test]
fn points_that_err_more_change_nothing_of_the_outlines() {
    let outlines = simulate(INDEPENDENT, 13);
    let worse = simulate(Truth { scale: 3.0, ..INDEPENDENT }, 14);
    let mut frames = outlines.clone();
    for (frame, points) in frames.iter_mut().zip(worse) {
        frame.extend(points.into_iter().map(|row| PlacedResidual { source: Source::Cloud, ..row }));
    }
    let noise = Noise::from_residuals(&frames);
    let points = noise.points.expect("there are points");
    approx::assert_relative_eq!(points.scale, 3.0, max_relative = 0.01);
    let of_outlines = noise.outlines.expect("there are outlines");
    let passes = of_outlines.in_one_frame / of_outlines.together;
    let expected = passes * points.weight_in_frame();
    approx::assert_relative_eq!(noise.weights().points, expected, max_relative = 1e-12);
    assert_eq!(Noise { points: None, ..noise }, Noise::from_residuals(&outlines));
}

/// One point a place of 3 cm on a line, in any order: λ = w(1 + ρ)/(1 − ρ); what lies below ρ = 0.05 is left out, 5 % of it.
#[test]
fn the_length_over_which_points_err_together_is_found_in_any_order() {
    const PLACES: usize = 200;
    for length in [1.0, 2.0, 4.0] {
        let rho = (-1.0_f64 / length).exp();
        let mut rng = ChaCha8Rng::seed_from_u64(15);
        let frame = |_| -> Vec<PlacedResidual> {
            let mut last = normal(&mut rng);
            let mut points: Vec<PlacedResidual> = (0..PLACES)
                .map(|i| {
                    last = rho * last + (1.0 - rho * rho).sqrt() * normal(&mut rng);
                    let place_part = Vector3::new(0.01, 0.01, 0.03 * i as f64 + 0.01);
                    PlacedResidual { source: Source::Cloud, place_part, ..row(0, 0, last) }
                })
                .collect();
            points.shuffle(&mut rng);
            points
        };
        let frames: Vec<_> = (0..FRAMES).map(frame).collect();
        let found = Noise::from_residuals(&frames).points.expect("there are points");
        let expected = 0.95 * WEIGHT * (1.0 + rho) / (1.0 - rho);
        approx::assert_relative_eq!(found.along_border, expected, max_relative = 0.1);
    }
}

#[test]
fn nothing_seen_is_no_fault() {
    for frames in [vec![], vec![Vec::new(); 3]] {
        let noise = Noise::from_residuals(&frames);
        assert_eq!(noise, Noise::default());
        assert_eq!(noise.weights(), DataWeights::all(1.0));
    }
}
