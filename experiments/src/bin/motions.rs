//! Persons who do not walk: what is found, how far joint centres are from the truth, and whether their stated standard deviations are true.
//!
//! Each [`Movement`] of `synth` is made by two persons, one of the make *flesh* and one *dressed*, whose joints' centres lie elsewhere in the flesh
//! than in the fitted body, before four to eight cameras. One of whom joints are more than 6 cm off on the mean is *lost*. A recording is *blamed* if the
//! verdict names a cause of faults: there is none.
//!
//! Starts: the body is found from nothing, as `maquette fit` does it.

use std::error::Error;
use std::path::Path;
use std::process::ExitCode;

use experiments::figures::{Figures, shares, shares_text};
use experiments::individual::individual;
use experiments::metrics::{INTERVALS, rms};
use experiments::run::Run;
use experiments::table::Table;
use experiments::walker::{observe, truth};
use maquette::body::BodyModel;
use maquette::inference::Sequence;
use maquette::inference::search::NoJournal;
use maquette::io::model;
use maquette::math::stats::mean;
use maquette::pipeline::{EstimateOptions, Fit, fit};
use maquette::synth::{Action, Make, Movement, Recipe, Ring, Synthetic};
use maquette::workflow::DEFAULT_BODY;
use rayon::prelude::*;

const FPS: f64 = 30.0;
/// Frames at most: of slow movements the beginning.
const FRAMES: usize = 48;
/// Cameras before which movements are made, in turn.
const CAMERAS: [usize; 3] = [5, 8, 4];
/// Those of the short form.
const QUICK: [Movement; 4] = [Movement::Jump, Movement::Throw, Movement::AllFours, Movement::Lie];
/// Who is farther off was not found.
const LOST_MM: f64 = 60.0;

/// One person's movement.
struct Tried {
    movement: Movement,
    make: Make,
    cameras: usize,
    seed: u64,
}

/// A fit, beside the truth; `None` where there is none.
struct Outcome {
    figures: Option<Figures>,
    is_blamed: bool,
    /// What the verdict says.
    said: String,
}

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let mut run = Run::start("motions");
    let walker = model::load("walker-metaballs", Path::new(""))?;
    let body = model::load(DEFAULT_BODY, Path::new(""))?;
    let tried = all(&run);
    let outcomes: Vec<Outcome> = tried
        .par_iter()
        .map(|one| one.outcome(&body, &walker))
        .collect::<Option<_>>()
        .ok_or("no person can be made")?;

    let header = [
        "movement",
        "made of",
        "cameras",
        "mm",
        "without offset",
        "RMS z",
        "50 · 80 · 95 %",
        "said",
    ];
    let mut table = Table::new("movements", &header);
    for (one, outcome) in tried.iter().zip(&outcomes) {
        table.row(row(one, outcome));
    }
    run.table("Movements", &table)?;

    let found: Vec<&Figures> =
        outcomes.iter().filter_map(|o| o.figures.as_ref()).filter(|f| f.raw_mm < LOST_MM).collect();
    run.number("lost", (outcomes.len() - found.len()) as f64);
    run.number("blamed", outcomes.iter().filter(|o| o.is_blamed).count() as f64);
    run.number("joints_mm", mean(found.iter().map(|f| f.raw_mm)).unwrap_or(f64::NAN));
    run.number("offset_mm", mean(found.iter().map(|f| f.offset_mm)).unwrap_or(f64::NAN));
    let pooled: Vec<f64> = found.iter().flat_map(|f| f.z.iter().copied()).collect();
    for ((percent, _), share) in INTERVALS.into_iter().zip(shares(&pooled)) {
        run.number(format!("pooled_{percent}"), share);
    }
    let worst = found.iter().map(|f| rms(f.z.iter().copied())).fold(0.0, f64::max);
    run.number("worst_z", worst);
    Ok(run.finish()?)
}

/// Every movement by two persons; in the short form the last few by one.
fn all(run: &Run) -> Vec<Tried> {
    let makes = [Make::Flesh, Make::Dressed];
    let each = Movement::ALL.into_iter().flat_map(|m| makes.map(|make| (m, make)));
    let one = |(i, (movement, make)): (usize, (Movement, Make))| Tried {
        movement,
        make,
        cameras: CAMERAS[i % CAMERAS.len()],
        seed: 100 * run.seed() + i as u64,
    };
    let is_short = |tried: &Tried| QUICK.contains(&tried.movement) && tried.make == Make::Flesh;
    let all = each.enumerate().map(one).filter(|tried| !run.is_quick() || is_short(tried));
    all.filter(|tried| run.wants(tried.movement.name())).collect()
}

impl Tried {
    /// `None` if there is no such person.
    fn outcome(&self, body: &BodyModel, walker: &BodyModel) -> Option<Outcome> {
        let recipe = Recipe {
            seed: self.seed,
            action: Action::Move(self.movement),
            make: self.make,
            frames: Some(FRAMES),
            fps: FPS,
            ring: Ring { cameras: self.cameras, ..Ring::default() },
            ..Recipe::default()
        };
        let recording = recipe.walker(&individual(&recipe, body, walker)?).ok()?;
        Some(Outcome::new(body, &recording))
    }
}

impl Outcome {
    fn new(body: &BodyModel, recording: &Synthetic) -> Self {
        let observations = observe(recording);
        let sequence = Sequence { frames: &observations, fps: recording.fps };
        let found = fit(body, &recording.rig, sequence, &EstimateOptions::default(), &NoJournal);
        match found {
            Ok(found) => Self {
                figures: Some(Figures::new(&truth(recording), &found, recording.fps)),
                is_blamed: !found.verdict.is_usable() || !found.verdict.causes.is_empty(),
                said: said(&found),
            },
            Err(error) => Self { figures: None, is_blamed: true, said: error.to_string() },
        }
    }
}

/// The verdict and the notes of a fit.
fn said(fit: &Fit) -> String {
    let unusable = (!fit.verdict.is_usable()).then(|| "**not usable**".to_owned());
    let causes = fit.verdict.causes.iter().map(ToString::to_string);
    let notes = fit.warnings.iter().map(ToString::to_string);
    unusable.into_iter().chain(causes).chain(notes).collect::<Vec<String>>().join(" | ")
}

fn row(tried: &Tried, outcome: &Outcome) -> [String; 8] {
    let number = |of: fn(&Figures) -> f64, digits: usize| {
        outcome.figures.as_ref().map_or("–".to_owned(), |f| format!("{:.digits$}", of(f)))
    };
    [
        tried.movement.name().to_owned(),
        format!("{:?}", tried.make).to_lowercase(),
        tried.cameras.to_string(),
        number(|f| f.raw_mm, 1),
        number(|f| f.offset_mm, 1),
        number(|f| rms(f.z.iter().copied()), 2),
        outcome.figures.as_ref().map_or("–".to_owned(), |f| shares_text(&f.z)),
        outcome.said.clone(),
    ]
}
