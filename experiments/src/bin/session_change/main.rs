//! How often the 95 % interval of a change between two sessions holds the true change.
//!
//! Each person, of another make than the fitted body as in `session`, walks five trials on each of two days. Between the days the gait truly changes, by drawn
//! amounts: the bend of the knees, the length of the steps, and the cadence. Within a day trials differ as `maquette synth --trial` has it. Every
//! recording is written, fitted and compared as `maquette session` and `maquette compare` do it, in two ways: each day a session with a body of its own, and both
//! days the conditions of one session, with one body.
//!
//! The true change is that of the walk about which the trials of a day are drawn, by the same analysis of the true motion. Told: the share of intervals that hold it,
//! for the range of the knee, the step length and the Gait Profile Score of each side, with its standard error between persons; how far
//! changes are off in standard errors; and how wide the intervals are.

mod days;

use std::error::Error;
use std::fs;
use std::path::Path;
use std::process::ExitCode;

use experiments::metrics::rms;
use experiments::run::Run;
use experiments::table::Table;
use maquette::gait::trials::Quantity;
use maquette::gait::{Angle, Parameter};
use maquette::io::model;
use maquette::math::stats::mean;
use maquette::synth::Make;

use days::{Found, Person, Way};

/// Makes in turn.
const MAKES: [Make; 2] = [Make::Flesh, Make::Dressed];
/// The numbers whose changes are looked at.
const NUMBERS: [(&str, Quantity); 3] = [
    ("knee_range", Quantity::Range(Angle::KneeFlexion)),
    ("step_length", Quantity::Parameter(Parameter::StepLength)),
    ("gps", Quantity::ProfileScore),
];
/// Half of a 95 % interval in standard deviations.
const Z_95: f64 = 1.96;

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let mut run = Run::start("session_change");
    let (persons, trials) = if run.is_quick() { (1, 3) } else { (4, 5) };
    run.setting("persons", persons);
    run.setting("trials of each session", trials);
    let body = model::load("human-ellipsoids", Path::new(""))?;
    let walker = model::load("walker-metaballs", Path::new(""))?;
    let recordings = run.folder().join("recordings");
    if recordings.exists() {
        fs::remove_dir_all(&recordings)?;
    }

    let mut all: Vec<Vec<Found>> = Vec::new();
    let names = ["way", "person", "number", "side", "true change", "found", "low", "high", "holds"];
    let mut table = Table::new("changes", &names);
    for k in 0..persons {
        let seed = 100 * run.seed() + k;
        let make = MAKES[k as usize % MAKES.len()];
        let person = Person::new(seed, make, &body, &walker).ok_or("no such person")?;
        let found = person.changes(trials, &recordings, &NUMBERS)?;
        for change in &found {
            let numbers = [change.truth, change.found, change.low, change.high];
            let numbers = numbers.map(|number| format!("{number:.3}"));
            let way = format!("{:?}", change.way);
            let names = [way, seed.to_string(), change.name.into(), change.side.into()];
            let holds = [change.holds().to_string()];
            table.row(names.into_iter().chain(numbers).chain(holds));
        }
        let held = found.iter().filter(|change| change.holds()).count();
        run.say(&format!("person {seed}: {held} of {} intervals hold the truth", found.len()));
        all.push(found);
    }
    run.table("changes between two sessions", &table)?;

    for (way, name) in Way::ALL {
        numbers_of(&mut run, way, name, &all);
    }
    Ok(run.finish()?)
}

/// What one way of comparing says.
fn numbers_of(run: &mut Run, way: Way, way_name: &str, persons: &[Vec<Found>]) {
    let every = || persons.iter().flatten().filter(|change| change.way == way);
    for (name, _) in NUMBERS {
        let own = || every().filter(|change| change.name == name);
        let half = mean(own().map(Found::half)).unwrap_or(f64::NAN);
        run.number(format!("{way_name}_{name}_holds_pct"), share_pct(own()));
        run.number(format!("{way_name}_{name}_off_se"), rms(own().map(Found::off_se)));
        run.number(format!("{way_name}_{name}_half_width"), half);
    }
    run.number(format!("{way_name}_intervals"), every().count() as f64);
    run.number(format!("{way_name}_holds_pct"), share_pct(every()));
    // intervals of one person err together, so persons are what is counted
    let of_person = |person: &Vec<Found>| share_pct(person.iter().filter(|own| own.way == way));
    let shares: Vec<f64> = persons.iter().map(of_person).collect();
    let middle = mean(shares.iter().copied()).unwrap_or(f64::NAN);
    let sd = rms(shares.iter().map(|share| share - middle));
    run.number(
        format!("{way_name}_holds_se_pct"),
        sd / (shares.len() as f64 - 1.0).max(1.0).sqrt(),
    );
}

/// The share of intervals that hold the truth, per cent.
fn share_pct<'a>(changes: impl Iterator<Item = &'a Found>) -> f64 {
    let held = changes.map(|change| f64::from(u8::from(change.holds())));
    100.0 * mean(held).unwrap_or(f64::NAN)
}
