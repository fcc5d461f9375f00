//! Five trials of one person fitted with one body, against each trial by itself.
//!
//! Each person: a body of `walker-metaballs`, of other flesh and proportions than the fitted body, made of a skin that follows the bones
//! or dressed ([`Make`]), with joints where publications have them and leave them open (`experiments::individual`). Each of the five trials is another
//! walk of that person before the same cameras, with masks whose errors are its own. Every trial is fitted alone as `maquette fit` does it, then all
//! together as `maquette session` does.
//!
//! Told: how far lengths are from the truth alone and together, RMS over lengths and persons in per cent of the length; how much of
//! that is the same in all trials of a person, which no mean over trials could take away; intervals of the lengths that hold
//! the truth; and whether a trial of another person is named and no other is.

mod person;

use std::error::Error;
use std::path::Path;
use std::process::ExitCode;

use experiments::metrics::{rms, within_pct};
use experiments::run::Run;
use experiments::table::Table;
use maquette::io::model;
use maquette::math::stats::mean;
use maquette::synth::Make;

use person::{Found, found};

/// Makes in turn.
const MAKES: [(&str, Make); 2] = [("flesh", Make::Flesh), ("dressed", Make::Dressed)];
/// 95 % of a standard normal.
const Z_95: f64 = 1.96;

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let mut run = Run::start("session");
    let (persons, frames) = if run.is_quick() { (2, 40) } else { (6, 100) };
    run.setting("persons", persons);
    run.setting("frames of each trial", frames);
    let body = model::load("human-metaballs", Path::new(""))?;
    let walker = model::load("walker-metaballs", Path::new(""))?;

    let mut all: Vec<Found> = Vec::new();
    let mut table = Table::new(
        "persons",
        &["person", "make", "alone, % off", "together, % off", "same in all trials, %"],
    );
    for k in 0..persons {
        let (name, make) = MAKES[k as usize % MAKES.len()];
        let seed = 100 * run.seed() + k;
        let person =
            found(&body, &walker, make, seed, frames).ok_or("a trial could not be fitted")?;
        let numbers = [person.alone_pct(), person.together_pct(), person.common_pct()];
        let numbers = numbers.map(|number| format!("{number:.2}"));
        table.row([seed.to_string(), name.to_owned()].into_iter().chain(numbers));
        all.push(person);
    }
    run.table("lengths, RMS over the lengths of a person", &table)?;

    let over = |of: fn(&Found) -> f64| rms(all.iter().map(of));
    let (alone, together) = (over(Found::alone_pct), over(Found::together_pct));
    run.number("alone_pct", alone);
    run.number("together_pct", together);
    run.number("same_in_all_trials_pct", over(Found::common_pct));
    run.number("together_less_pct", 100.0 * (1.0 - together / alone));
    let z = |of: fn(&Found) -> &Vec<f64>| within_pct(all.iter().flat_map(of).copied(), Z_95);
    run.number("alone_95_pct", z(|person| &person.alone_z));
    run.number("together_95_pct", z(|person| &person.together_z));
    let seconds = |of: fn(&Found) -> f64| mean(all.iter().map(of)).unwrap_or(f64::NAN);
    run.number("time_beside_single_fits", seconds(|person| person.times));
    run.number("wrongly_named", all.iter().map(|person| person.wrongly_named as f64).sum());
    run.number("others_missed", all.iter().map(|person| person.others_missed as f64).sum());
    Ok(run.finish()?)
}
