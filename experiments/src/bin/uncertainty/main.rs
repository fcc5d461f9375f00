//! Stated intervals against what came true, on simulated walks of persons of three makes.
//!
//! Each recording: another person, whose body is that of `walker-metaballs` (of other flesh and proportions than the fitted bodies:
//! a mismatch that returns in every frame), made of metaballs, of a skin that follows the bones by shares, or dressed
//! ([`Make`]). The joints' centres lie elsewhere in the flesh, by one draw from what publications leave open
//! (`synth::draw_centres`), and joints at rest are held at angles of their own; another walk, another ring of cameras, masks with ragged
//! borders that err together along the border, bites and specks. Each shipped body is fitted as `maquette fit` does it. Stated: the
//! intervals of every angle, joint centre and length from the joint optimum's covariance. True: how many of them contain
//! the truth. ECE, the expected calibration error, is the mean difference of the two over stated probabilities of 5, 10, …, 95 %.
//!
//! Starts: the body is found from nothing, as `maquette fit` does it.

mod recording;

use std::error::Error;
use std::path::Path;
use std::process::ExitCode;

use experiments::metrics::{INTERVALS, rms, within_pct};
use experiments::picture::{Panel, colour, svg};
use experiments::run::Run;
use experiments::table::Table;
use kuva::plot::LegendPosition;
use maquette::io::model;
use maquette::math::stats::mean;
use maquette::synth::Make;
use rayon::prelude::*;

use recording::{Deviation, Kind, deviations};

const KINDS: [(Kind, &str, &str); 3] = [
    (Kind::Angle, "angles", colour::BLUE),
    (Kind::Joint, "joint centres", colour::ORANGE),
    (Kind::Length, "lengths", colour::GREEN),
];

/// A make of body.
struct Tried {
    name: &'static str,
    /// Its table, number by number.
    table: &'static str,
    make: Make,
}

const MAKES: [Tried; 3] = [
    Tried { name: "metaballs", table: "by_name_metaballs", make: Make::Metaballs },
    Tried { name: "flesh", table: "by_name_flesh", make: Make::Flesh },
    Tried { name: "dressed", table: "by_name_dressed", make: Make::Dressed },
];
/// The default body first: the quick form has it alone.
const BODIES: [&str; 2] = ["human-metaballs", "human-ellipsoids"];

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let mut run = Run::start("uncertainty");
    let (recordings, bodies) = if run.is_quick() { (8, &BODIES[..1]) } else { (24, &BODIES[..]) };
    run.setting("recordings of each make", recordings);
    let walker = model::load("walker-metaballs", Path::new(""))?;

    let mut coverage = Table::new(
        "coverage",
        &["body", "make", "", "numbers", "50 %", "80 %", "95 %", "RMS z", "ECE"],
    );
    let mut lost = 0;
    let mut of_default = Vec::new();
    for name in bodies {
        let body = model::load(name, Path::new(""))?;
        for tried in &MAKES {
            let first = run.seed() * recordings;
            let seeds = (first..first + recordings).into_par_iter();
            let found: Vec<_> =
                seeds.map(|seed| deviations(&body, &walker, tried.make, seed)).collect();
            lost += found.iter().filter(|f| f.is_none()).count();
            let found: Vec<Deviation> = found.into_iter().flatten().flatten().collect();
            report(&mut run, &mut coverage, [name, tried.name], &found);
            if *name == BODIES[0] {
                number_by_number(&mut run, tried, &found)?;
                of_default.extend(found);
            }
        }
    }
    run.table("intervals that contain the truth, %", &coverage)?;
    run.number("recordings_without_result", lost as f64);
    run.picture("reliability", &reliability(&of_default))?;
    Ok(run.finish()?)
}

/// How often the truth lies in intervals of one body and make.
fn report(run: &mut Run, table: &mut Table, [body, make]: [&str; 2], all: &[Deviation]) {
    for (kind, name, _) in KINDS {
        let of_kind: Vec<f64> = all.iter().filter(|d| d.kind == kind).map(|d| d.z).collect();
        let shares = INTERVALS.map(|(_, z)| within_pct(of_kind.iter().copied(), z));
        let ece = calibration_error(&of_kind);
        run.number(format!("{body}_{make}_{}", name.replace(' ', "_")), ece);

        let titles = [body.to_owned(), make.to_owned(), name.to_owned(), of_kind.len().to_string()];
        let shares = shares.map(|share| format!("{share:.1}"));
        let ends = [format!("{:.2}", rms(of_kind.iter().copied())), format!("{ece:.3}")];
        table.row(titles.into_iter().chain(shares).chain(ends));
    }
}

/// Stated probabilities, and the share of the truths within their intervals, both %.
fn came_true(z: &[f64]) -> Vec<(f64, f64)> {
    let stated = (1..20).map(|i| f64::from(i) / 20.0);
    stated.map(|p| (100.0 * p, within_pct(z.iter().copied(), recording::quantile(p)))).collect()
}

/// ECE.
fn calibration_error(z: &[f64]) -> f64 {
    let off = came_true(z).into_iter().map(|(stated, found)| (stated - found).abs() / 100.0);
    mean(off).unwrap_or(f64::NAN)
}

fn number_by_number(run: &mut Run, make: &Tried, all: &[Deviation]) -> Result<(), Box<dyn Error>> {
    let mut names: Vec<&str> = all.iter().map(|d| d.name.as_str()).collect();
    names.sort_unstable();
    names.dedup();
    let mut table =
        Table::new(make.table, &["", "50 %", "80 %", "95 %", "mean z", "RMS z", "RMS SD"]);
    for name in names {
        let of = || all.iter().filter(|d| d.name == name);
        let mean = mean(of().map(|d| d.z)).unwrap_or(f64::NAN);
        let (rms, sd) = (rms(of().map(|d| d.z)), rms(of().map(|d| d.sd)));
        let shares = INTERVALS.map(|(_, z)| format!("{:.0}", within_pct(of().map(|d| d.z), z)));
        let numbers = [format!("{mean:.2}"), format!("{rms:.2}"), format!("{sd:.4}")];
        table.row([name.to_owned()].into_iter().chain(shares).chain(numbers));
    }
    run.table(&format!("number by number, {}", make.name), &table)?;
    Ok(())
}

/// Stated against true, one curve for each kind of number.
fn reliability(all: &[Deviation]) -> String {
    let panel = Panel::new("intervals that contain the truth", "stated, %", "came true, %")
        .ranges((0.0, 100.0), (0.0, 100.0))
        .dashed("as stated", colour::BLACK, &[(0.0, 0.0), (100.0, 100.0)])
        .legend(LegendPosition::OutsideRightTop);
    let panel = KINDS.iter().fold(panel, |panel, &(kind, name, colour)| {
        let of_kind = all.iter().filter(|d| d.kind == kind);
        let points = came_true(&of_kind.map(|d| d.z).collect::<Vec<f64>>());
        panel.curve(name, colour, &points).marks("", colour, &points)
    });
    svg(1, (520.0, 400.0), vec![panel])
}
