//! Stated intervals against what came true, on 200 simulated walks of 200 persons.
//!
//! Each recording: another person of `walker-metaballs` (whose flesh and proportions are not those of the fitted body:
//! a mismatch that returns in every frame) whose joints' centres lie elsewhere in the flesh, by one draw from what publications leave open
//! (`synth::draw_centres`) and who holds joints at rest at angles of their own, another walk, another ring of cameras, masks with ragged borders that err
//! together along the border, bites and specks. `human-metaballs` is fitted as `maquette fit` does it. Stated: the
//! 50, 80 and 95 % intervals of every angle, joint centre and length from the joint optimum's covariance. True: how many
//! of them contain the truth.

mod person;
mod recording;

use std::error::Error;
use std::path::Path;
use std::process::ExitCode;

use experiments::metrics::{INTERVALS, within_pct};
use experiments::picture::{Panel, colour, svg};
use experiments::run::Run;
use experiments::table::Table;
use kuva::plot::LegendPosition;
use maquette::io::model;
use rayon::prelude::*;

use recording::{Deviation, Kind, deviations};

const KINDS: [(Kind, &str, &str); 3] = [
    (Kind::Angle, "angles", colour::BLUE),
    (Kind::Joint, "joint centres", colour::ORANGE),
    (Kind::Length, "lengths", colour::GREEN),
];

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let mut run = Run::start("uncertainty");
    let recordings = if run.is_quick() { 16 } else { 200 };
    run.setting("recordings", recordings);
    let (body, walker) = (
        model::load("human-metaballs", Path::new(""))?,
        model::load("walker-metaballs", Path::new(""))?,
    );
    let first = run.seed() * recordings;
    let found: Vec<Vec<Deviation>> = (first..first + recordings)
        .into_par_iter()
        .map(|seed| deviations(&body, &walker, seed).unwrap_or_default())
        .collect();
    let lost = found.iter().filter(|f| f.is_empty()).count();
    run.number("recordings_without_result", lost as f64);
    let all: Vec<Deviation> = found.into_iter().flatten().collect();
    report(&mut run, &all)?;
    run.picture("reliability", &reliability(&all))?;
    Ok(run.finish()?)
}

fn report(run: &mut Run, all: &[Deviation]) -> Result<(), Box<dyn Error>> {
    let mut table =
        Table::new("coverage", &["", "numbers", "50 %", "80 %", "95 %", "RMS of error over SD"]);
    for (kind, name, _) in KINDS {
        let of_kind = || all.iter().filter(|d| d.kind == kind);
        let mut cells = vec![name.to_owned(), of_kind().count().to_string()];
        for (stated, z) in INTERVALS {
            let share = within_pct(of_kind().map(|d| d.z), z);
            run.number(format!("{}_{stated}", name.replace(' ', "_")), share);
            cells.push(format!("{share:.1}"));
        }
        let rms = (of_kind().map(|d| d.z * d.z).sum::<f64>() / of_kind().count() as f64).sqrt();
        cells.push(format!("{rms:.2}"));
        table.row(cells);
    }
    run.table("intervals that contain the truth, %", &table)?;
    let mut names: Vec<&str> = all.iter().map(|d| d.name.as_str()).collect();
    names.sort_unstable();
    names.dedup();
    let mut table =
        Table::new("by_name", &["", "50 %", "80 %", "95 %", "mean z", "RMS z", "RMS SD"]);
    for name in names {
        let of = || all.iter().filter(|d| d.name == name);
        let count = of().count() as f64;
        let mean = of().map(|d| d.z).sum::<f64>() / count;
        let rms = (of().map(|d| d.z * d.z).sum::<f64>() / count).sqrt();
        let sd = (of().map(|d| d.sd * d.sd).sum::<f64>() / count).sqrt();
        let shares = INTERVALS.map(|(_, z)| format!("{:.0}", within_pct(of().map(|d| d.z), z)));
        let numbers = [format!("{mean:.2}"), format!("{rms:.2}"), format!("{sd:.4}")];
        table.row([name.to_owned()].into_iter().chain(shares).chain(numbers));
    }
    run.table("number by number", &table)?;
    Ok(())
}

/// Stated against true, one curve for each kind of number.
fn reliability(all: &[Deviation]) -> String {
    let panel = Panel::new("intervals that contain the truth", "stated, %", "came true, %")
        .ranges((0.0, 100.0), (0.0, 100.0))
        .dashed("as stated", colour::BLACK, &[(0.0, 0.0), (100.0, 100.0)])
        .legend(LegendPosition::OutsideRightTop);
    let panel = KINDS.iter().fold(panel, |panel, &(kind, name, colour)| {
        let of_kind = || all.iter().filter(|d| d.kind == kind);
        let points: Vec<(f64, f64)> = (1..20)
            .map(|i| {
                let stated = f64::from(i) / 20.0;
                (100.0 * stated, within_pct(of_kind().map(|d| d.z), recording::quantile(stated)))
            })
            .collect();
        panel.curve(name, colour, &points).marks("", colour, &points)
    });
    svg(1, (520.0, 400.0), vec![panel])
}
