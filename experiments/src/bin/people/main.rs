//! Several people in one room: how many the masks are said to show, and how well each is fitted.
//!
//! Each scene: two people of `walker-metaballs` with skins of another make, in irregular rings of six cameras and of four, ragged masks that hold
//! both. The second walks beside the first, comes the other way, follows, stands by, walks across, or is not there at all. Who is fitted is
//! compared with the true person whose pelvis is nearest.
//!
//! Starts: the people are found from nothing, as `maquette fit` does it.

mod scene;

use std::error::Error;
use std::path::Path;
use std::process::ExitCode;

use experiments::run::Run;
use experiments::table::Table;
use maquette::io::model;
use maquette::math::stats::{mean, median};
use maquette::workflow::DEFAULT_BODY;
use rayon::prelude::*;
use scene::{Company, Outcome, Scene};

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let mut run = Run::start("people");
    let repeats = if run.is_quick() { 1 } else { 5 };
    run.setting("scenes of each kind", 2 * repeats);
    let body = model::load(DEFAULT_BODY, Path::new(""))?;
    let walker = model::load("walker-metaballs", Path::new(""))?;

    let kinds =
        Company::ALL.into_iter().flat_map(|company| [6, 4].map(|cameras| (company, cameras)));
    let kinds: Vec<(Company, usize)> =
        kinds.filter(|(company, _)| run.wants(company.name())).collect();
    let first = run.seed() * repeats;
    let scenes: Vec<(Company, usize, u64)> = kinds
        .iter()
        .flat_map(|(company, cameras)| {
            (first..first + repeats).map(move |seed| (*company, *cameras, seed))
        })
        .collect();
    let outcomes: Vec<Option<Outcome>> = scenes
        .par_iter()
        .map(|(company, cameras, seed)| {
            Scene::new(&walker, *company, *cameras, *seed)?.fitted(&body)
        })
        .collect();

    let header = ["the second person", "cameras", "found", "joints off, mm", "after offset, mm"];
    let mut table = Table::new("people", &header);
    for kind in &kinds {
        let own = scenes.iter().zip(&outcomes);
        let own = own.filter(|((company, cameras, _), _)| (*company, *cameras) == *kind);
        let own: Vec<Option<&Outcome>> = own.map(|(_, outcome)| outcome.as_ref()).collect();
        let found = own.iter().map(|o| o.map_or("–".into(), |o| o.found.to_string()));
        let listed = |of: fn(&Outcome) -> &Vec<f64>| {
            let all = own.iter().flatten().flat_map(|o| of(o)).map(|mm| format!("{mm:.0}"));
            all.collect::<Vec<_>>().join(" ")
        };
        table.row([
            kind.0.name().to_owned(),
            kind.1.to_string(),
            found.collect::<Vec<_>>().join(" "),
            listed(|o| &o.joints_mm),
            listed(|o| &o.offset_mm),
        ]);
    }
    run.table("people found and fitted", &table)?;

    let all: Vec<&Outcome> = outcomes.iter().flatten().collect();
    let sum = |of: fn(&Outcome) -> usize| all.iter().map(|o| of(o)).sum::<usize>() as f64;
    run.number("missed", sum(|o| o.people.saturating_sub(o.found)));
    run.number("invented", sum(|o| o.found.saturating_sub(o.people)));
    run.number("without_result", outcomes.iter().filter(|o| o.is_none()).count() as f64);
    let errors = |of: fn(&Outcome) -> &Vec<f64>| -> Vec<f64> {
        all.iter().flat_map(|o| of(o).iter().copied()).collect()
    };
    run.number("joints_mm", median(&mut errors(|o| &o.joints_mm)).unwrap_or(f64::NAN));
    run.number("offset_mm", median(&mut errors(|o| &o.offset_mm)).unwrap_or(f64::NAN));
    run.number(
        "lost",
        errors(|o| &o.joints_mm).iter().filter(|mm| **mm > scene::LOST_MM).count() as f64,
    );
    run.number("mean_joints_mm", mean(errors(|o| &o.joints_mm)).unwrap_or(f64::NAN));
    Ok(run.finish()?)
}
