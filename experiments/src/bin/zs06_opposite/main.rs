//! ZS06 Fig. 6: when does the published likelihood bend an arm to the opposite side?
//!
//! "Human arm bends to the opposite side to cover inaccuracy of the model … Correct motion parameters produce higher
//! (worse) value of the criterial function." So the claim is about an optimum, not about a search. A metaball man holds
//! both arms beside his trunk (`experiments::held`). In every eighth frame each arm is fitted twice: from where Algorithm 1
//! on the outline has it, and from there with the elbow bent to the other side by as much. The shape is the track's, and
//! the limits of arms are taken away: with them an elbow cannot bend backwards. A likelihood *prefers* the opposite side
//! where the cheaper optimum lies on that side. And each likelihood tracks the whole recording from the same keyframe, with the same
//! shape and without limits: does an arm bend to the other side by itself? So do published likelihood and outline from
//! nothing. Conditions vary cameras, pose, noise and loss.
//!
//! Starts: Algorithm 1 on the outline finds the person from nothing, as ZS06 does, with limits. Keyframe and shape of the tracks are those
//! of its winner, and its poses are the first starts. No truth enters.

mod conditions;
mod pictures;
mod sides;

use std::error::Error;
use std::path::Path;
use std::process::ExitCode;

use experiments::run::Run;
use experiments::table::Table;
use maquette::io::model;
use rayon::prelude::*;

use conditions::{CONDITIONS, Condition};
use sides::{LIKELIHOODS, Sides, Tally, Track};

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let mut run = Run::start("zs06_opposite");
    let wanted: Vec<&Condition> = CONDITIONS.iter().filter(|c| run.wants(c.name)).collect();
    let model = model::load("human-metaballs", Path::new(""))?;
    let seed = run.seed();
    let jobs: Vec<(&Condition, u64)> =
        wanted.iter().flat_map(|c| (seed..seed + c.recordings).map(|seed| (*c, seed))).collect();
    let recordings: Result<Vec<Sides>, _> =
        jobs.par_iter().map(|(condition, seed)| Sides::of(&model, condition, *seed)).collect();
    let mut recordings = recordings.map_err(|error| error.to_string())?.into_iter();
    let each = wanted.iter().filter_map(|condition| {
        recordings.by_ref().take(condition.recordings as usize).reduce(Sides::and)
    });
    let found: Vec<Sides> = each.collect();

    let mut table = Table::new("sides", &columns());
    for (condition, sides) in wanted.iter().zip(&found) {
        let each = sides.fits.each_ref().map(|fits| Tally::of(fits.iter()));
        report(&mut run, &mut table, condition, &each, sides);
    }
    run.table("Arms to the opposite side, %", &table)?;
    together(&mut run, &found);
    let named: Vec<(&Condition, &Sides)> = wanted.iter().copied().zip(&found).collect();
    run.picture("shares", &pictures::shares(&named))?;
    if let Some(example) = pictures::example(&found) {
        run.picture("arm", &example)?;
    }
    if run.is_partial() {
        return Ok(ExitCode::SUCCESS);
    }
    Ok(run.finish()?)
}

/// The shares of all conditions together.
fn together(run: &mut Run, found: &[Sides]) {
    let share = |count: usize, all: usize| 100.0 * count as f64 / all.max(1) as f64;
    for (k, likelihood) in LIKELIHOODS.iter().enumerate() {
        let tally = Tally::of(found.iter().flat_map(|sides| &sides.fits[k]));
        let sum = |of: fn(&Track) -> usize| found.iter().map(|sides| of(&sides.tracks[k])).sum();
        let (held, opposite, lost) = (sum(|t| t.held), sum(|t| t.opposite), sum(|t| t.lost));
        run.number(format!("all_{}_prefers_pct", likelihood.name), share(tally.prefers, tally.all));
        run.number(format!("all_{}_tracked_opposite_pct", likelihood.name), share(opposite, held));
        run.number(format!("all_{}_tracked_lost_pct", likelihood.name), share(lost, held));
    }
}

fn columns() -> [&'static str; 14] {
    [
        "condition",
        "opposite costs less: published",
        "outline",
        "metaballs",
        "tracked to the opposite: published",
        "outline",
        "metaballs",
        "tracked, lost: published",
        "outline",
        "metaballs",
        "from nothing, opposite: published",
        "outline",
        "from nothing, lost: published",
        "outline",
    ]
}

fn report(
    run: &mut Run,
    table: &mut Table,
    condition: &Condition,
    each: &[Tally; 3],
    sides: &Sides,
) {
    let share = |count: usize, all: usize| 100.0 * count as f64 / all.max(1) as f64;
    let columns = [
        ("prefers", each.map(|t| share(t.prefers, t.all))),
        ("tracked_opposite", sides.tracks.map(|t| share(t.opposite, t.held))),
        ("tracked_lost", sides.tracks.map(|t| share(t.lost, t.held))),
        ("stays", each.map(|t| share(t.stays, t.all))),
    ];
    for (what, values) in columns {
        for (likelihood, value) in LIKELIHOODS.iter().zip(values) {
            run.number(format!("{}_{}_{what}_pct", condition.name, likelihood.name), value);
        }
    }
    let alone = [
        ("alone_opposite", sides.alone.map(|t| share(t.opposite, t.held))),
        ("alone_lost", sides.alone.map(|t| share(t.lost, t.held))),
    ];
    for (what, values) in alone {
        for (likelihood, value) in LIKELIHOODS.iter().zip(values) {
            run.number(format!("{}_{}_{what}_pct", condition.name, likelihood.name), value);
        }
    }
    let shown = columns[..3].iter().flat_map(|(_, values)| values);
    let cells = shown.chain(alone.iter().flat_map(|(_, values)| values)).map(|v| format!("{v:.0}"));
    table.row(std::iter::once(condition.title.to_owned()).chain(cells));
}
