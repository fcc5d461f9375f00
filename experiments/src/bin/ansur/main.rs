//! The shape prior from all of ANSUR II: what 4082 men and 1986 women share, and what is each quantity's own.
//!
//! Each sex counts half. Quantities: `quantities.rs`; factors: `factors.rs`; soldiers to civilians: `civilians.rs`; what the body
//! models' files must say: [`models`]. docs/anthropometry.md, § 5, explains the numbers.

mod civilians;
mod factors;
mod models;
mod quantities;
mod survey;

use std::error::Error;
use std::path::Path;
use std::process::ExitCode;

use experiments::run::{Run, shared_data};
use experiments::table::Table;
use nalgebra::{DMatrix, DVector};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use civilians::{Percentiles, widening};
use factors::{Estimate, SHARED, Sample};
use models::{Expected, differing, expected, factors};
use quantities::quantities;
use survey::Person;

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let mut run = Run::start("ansur");
    let folder = shared_data().join("ansur2");
    if !folder.is_dir() {
        run.say(&format!("skipped: no survey in {}", folder.display()));
        return Ok(ExitCode::SUCCESS);
    }
    let (men, women) = people(&folder)?;
    let sample = Sample::new(&men, &women);
    let estimate = Estimate::new(&sample, SHARED.len());
    let times = if run.is_quick() { 8 } else { 200 };
    run.setting("resamples", times);
    let errors = standard_errors(&sample, times, run.seed());
    how_many(&mut run, &sample)?;
    loadings(&run, &estimate, &errors)?;
    remaining(&mut run, &estimate)?;

    let civil = widening([&men, &women].map(|sex| body_mass_index(sex)));
    let expected = expected(&estimate, civil);
    coefficients(&run, &expected)?;
    let differing = differing(&expected)?;
    differing.iter().for_each(|line| run.say(line));
    run.number("coefficients_otherwise_in_a_file", differing.len() as f64);
    numbers(&mut run, &estimate, civil);
    run.number("largest_standard_error_of_a_loading", errors.0.max());
    Ok(run.finish()?)
}

/// Men and women.
fn people(folder: &Path) -> Result<(Vec<Person>, Vec<Person>), survey::SurveyError> {
    Ok((survey::read(&folder.join("male.csv"))?, survey::read(&folder.join("female.csv"))?))
}

fn body_mass_index(people: &[Person]) -> Percentiles {
    let index = |p: &Person| p.mass_kg() / p.metres("stature").powi(2);
    Percentiles::from_sample(people.iter().map(index).collect())
}

/// SDs of loadings and of own SDs over samples drawn with replacement.
fn standard_errors(sample: &Sample, times: u64, seed: u64) -> (DMatrix<f64>, DVector<f64>) {
    let one = |i: u64| {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        rng.set_stream(i);
        let estimate = Estimate::new(&sample.resampled(&mut rng), SHARED.len());
        (estimate.loadings, estimate.own)
    };
    let found: Vec<(DMatrix<f64>, DVector<f64>)> = (0..times).into_par_iter().map(one).collect();
    let spread = |values: Vec<f64>| {
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        let squares = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>();
        (squares / (values.len() - 1) as f64).sqrt()
    };
    let (rows, columns) = found[0].0.shape();
    let loadings = DMatrix::from_fn(rows, columns, |i, k| {
        spread(found.iter().map(|(loadings, _)| loadings[(i, k)]).collect())
    });
    let own = DVector::from_fn(rows, |i, _| spread(found.iter().map(|(_, own)| own[i]).collect()));
    (loadings, own)
}

/// What factors beside the known ones leave, by their number.
fn how_many(run: &mut Run, sample: &Sample) -> Result<(), Box<dyn Error>> {
    let names: Vec<&str> = quantities().iter().map(|q| q.name).collect();
    let columns = ["factors", "eigenvalue", "left, RMS", "left, largest", "between"];
    let mut table = Table::new("how_many", &columns);
    for count in 1..=7 {
        let estimate = Estimate::new(sample, count);
        let mut eigenvalues: Vec<f64> =
            estimate.correlations.symmetric_eigenvalues().iter().copied().collect();
        eigenvalues.sort_by(|a, b| b.total_cmp(a));
        let (value, i, j) = pairs(&estimate.left)[0];
        table.row([
            count.to_string(),
            format!("{:.2}", eigenvalues[count - 1]),
            format!("{:.3}", rms(&estimate.left)),
            format!("{value:+.2}"),
            format!("{} – {}", names[i], names[j]),
        ]);
    }
    run.table("Factors beside stature, girth and sex", &table)?;
    Ok(())
}

/// Off the diagonal.
fn rms(left: &DMatrix<f64>) -> f64 {
    let n = left.nrows();
    left.norm() / ((n * (n - 1)) as f64).sqrt()
}

/// Pairs of quantities, the largest correlation first.
fn pairs(left: &DMatrix<f64>) -> Vec<(f64, usize, usize)> {
    let n = left.nrows();
    let mut pairs: Vec<_> = (0..n)
        .flat_map(|i| (0..i).map(move |j| (i, j)))
        .map(|(i, j)| (left[(i, j)], i, j))
        .collect();
    pairs.sort_by(|a, b| b.0.abs().total_cmp(&a.0.abs()));
    pairs
}

fn loadings(
    run: &Run,
    estimate: &Estimate,
    errors: &(DMatrix<f64>, DVector<f64>),
) -> Result<(), Box<dyn Error>> {
    let columns: Vec<&str> =
        ["quantity", "mean, mm"].into_iter().chain(factors()).chain(["own"]).collect();
    let mut table = Table::new("loadings", &columns);
    for (i, quantity) in quantities().iter().enumerate() {
        let cell = |value: f64, error: f64| format!("{value:+.4} ± {error:.4}");
        let loadings = (0..estimate.loadings.ncols())
            .map(|k| cell(estimate.loadings[(i, k)], errors.0[(i, k)]));
        let first = [quantity.name.to_owned(), format!("{:.1}", 1e3 * estimate.mean[i])];
        let own = cell(estimate.own[i], errors.1[i]);
        table.row(first.into_iter().chain(loadings).chain([own]));
    }
    run.table("Loadings of soldiers, log units, with standard errors", &table)?;
    Ok(())
}

fn remaining(run: &mut Run, estimate: &Estimate) -> Result<(), Box<dyn Error>> {
    let names: Vec<&str> = quantities().iter().map(|q| q.name).collect();
    let mut table = Table::new("remaining", &["between", "and", "correlation"]);
    for (value, i, j) in pairs(&estimate.left).into_iter().take_while(|(v, ..)| v.abs() > 0.12) {
        table.row([names[i].to_owned(), names[j].to_owned(), format!("{value:+.2}")]);
    }
    run.number("largest_correlation_left", pairs(&estimate.left)[0].0.abs());
    run.number("rms_correlation_left", rms(&estimate.left));
    run.table("Correlations that remain", &table)?;
    Ok(())
}

fn coefficients(run: &Run, expected: &[Expected]) -> Result<(), Box<dyn Error>> {
    let columns: Vec<&str> =
        ["body", "coefficient"].into_iter().chain(factors()).chain(["sd"]).collect();
    let mut table = Table::new("coefficients", &columns);
    for e in expected {
        let loading = |name: &str| e.entry.loadings.get(name).map_or(String::new(), f64::to_string);
        let first = [e.body.name().to_owned(), e.coefficient.to_owned()];
        table.row(first.into_iter().chain(factors().map(loading)).chain([e.entry.sd.to_string()]));
    }
    run.table("What the body models' files say", &table)?;
    Ok(())
}

fn numbers(run: &mut Run, estimate: &Estimate, civil: f64) {
    run.number("stature_sd", estimate.stature_sd);
    run.number("girth_sd", estimate.girth_sd);
    run.number("civilian_girth", civil);
    run.number("crotch_sd_mm", 1e3 * estimate.crotch_sd_m);
    run.number("sex_distance_sd", estimate.sex_distance);
    // what a normal sex costs where two sexes are meant: KL(½N(−d/2,1) + ½N(d/2,1) ‖ N(0, 1 + d²/4)), the sexes far apart
    let cost = 0.5 * (1.0 + 0.25 * estimate.sex_distance.powi(2)).ln() - std::f64::consts::LN_2;
    run.number("normal_sex_costs_nats", cost);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[allow(clippy::print_stderr, reason = "a skipped test says so")]
    fn the_body_models_say_what_the_survey_says() {
        let folder = shared_data().join("ansur2");
        if !folder.is_dir() {
            eprintln!("skipped: no survey in {}", folder.display());
            return;
        }
        let (men, women) = people(&folder).unwrap();
        let estimate = Estimate::new(&Sample::new(&men, &women), SHARED.len());
        let civil = widening([&men, &women].map(|sex| body_mass_index(sex)));
        let lines = differing(&expected(&estimate, civil)).unwrap();
        assert!(lines.is_empty(), "{}", lines.join("\n"));
    }

    #[test]
    fn soldiers_who_vary_as_civilians_do_widen_nothing() {
        assert!((widening(civilians::CIVILIANS) - 1.0).abs() < 1e-12);
    }
}
