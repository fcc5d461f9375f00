//! Recordings spoiled in forty ways each: how far off the fit is, what it says of itself, and which cause it names.
//!
//! A row is *silent* if the error is more than twice that of the clean recording and neither a cause is named nor the fit said to
//! be unusable.

mod damage;
mod recorded;

use std::error::Error;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use damage::{Damage, damages};
use experiments::metrics::{mpjpe_mm, trajectories};
use experiments::run::Run;
use experiments::table::Table;
use maquette::inference::Sequence;
use maquette::inference::search::NoJournal;
use maquette::io::model;
use maquette::pipeline::{EstimateOptions, Fit, FitError, fit};
use recorded::Recorded;

/// Name, frames per second, and the file of the truth.
const SETS: [(&str, f64, &str); 3] = [
    ("walk7", 50.0, "truth.trc"),
    ("dressed", 50.0, "truth.trc"),
    ("balance", 60.0, "reference.trc"),
];
/// An error of so many times the clean one needs a word.
const TWICE: f64 = 2.0;

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let mut run = Run::start("spoiled");
    if !shared().is_dir() {
        run.say(&format!("skipped: no recordings in {}", shared().display()));
        return Ok(ExitCode::SUCCESS);
    }
    let sets = if run.is_quick() { &SETS[..1] } else { &SETS[..] };
    let mut table = Table::new("spoiled", &["set", "spoiled by", "mm", "× clean", "what was said"]);
    let (mut silent, mut rows) = (0, 0);
    for (name, fps, truth) in sets {
        let recorded = Recorded::read(&shared().join(name), *fps, truth)?;
        let mut clean_mm = f64::NAN;
        for damage in damages() {
            let row = Row::new(&damage, &recorded)?;
            if rows == 0 || damage.name == "nothing" {
                clean_mm = row.error_mm;
            }
            rows += 1;
            silent += usize::from(row.is_silent(clean_mm, &damage));
            table.row(row.cells(name, &damage, clean_mm));
            run.say(&row.cells(name, &damage, clean_mm).join(" | "));
        }
    }

    run.table("Spoiled recordings", &table)?;
    run.number("rows", rows as f64);
    run.number("silent", silent as f64);
    Ok(run.finish()?)
}

/// What became of a spoiled recording.
struct Row {
    /// NaN where nothing was fitted.
    error_mm: f64,
    is_usable: bool,
    said: String,
}

impl Row {
    fn new(damage: &Damage, recorded: &Recorded) -> Result<Self, Box<dyn Error>> {
        let body = model::load("human-ellipsoids", Path::new(""))?;
        let spoiled = (damage.spoil)(recorded);
        let frames = spoiled.observations();
        let sequence = Sequence { frames: &frames, fps: spoiled.fps };
        let found = fit(&body, &spoiled.rig, sequence, &EstimateOptions::default(), &NoJournal);
        Ok(Self::from_fit(found, |fit| {
            let motions: Vec<_> = fit.frames.iter().map(|f| f.fit.motion.clone()).collect();
            mpjpe_mm(&spoiled.truth, &trajectories(&body, &fit.shape, &motions, spoiled.fps))
        }))
    }

    fn from_fit(found: Result<Fit, FitError>, error_mm: impl Fn(&Fit) -> Option<f64>) -> Self {
        match found {
            Ok(fit) => Self {
                error_mm: error_mm(&fit).unwrap_or(f64::NAN),
                is_usable: fit.verdict.is_usable(),
                said: fit.verdict.headline().unwrap_or_default(),
            },
            Err(refused) => {
                Self { error_mm: f64::NAN, is_usable: false, said: format!("refused: {refused}") }
            }
        }
    }

    fn names_cause(&self, damage: &Damage) -> bool {
        self.said.contains(damage.cause)
    }

    fn is_silent(&self, clean_mm: f64, damage: &Damage) -> bool {
        self.error_mm > TWICE * clean_mm && (damage.cause.is_empty() || !self.names_cause(damage))
    }

    fn cells(&self, set: &str, damage: &Damage, clean_mm: f64) -> [String; 5] {
        let mark = match (self.names_cause(damage), self.is_silent(clean_mm, damage)) {
            (_, true) => "✗ ",
            (false, false) => "(✗) ",
            _ => "",
        };
        [
            set.to_owned(),
            damage.name.to_owned(),
            format!("{:.0}", self.error_mm),
            format!("{:.1}", self.error_mm / clean_mm),
            format!("{mark}{}{}", if self.is_usable { "" } else { "exit 3: " }, self.said),
        ]
    }
}

/// Where the recordings lie that are shared by projects.
fn shared() -> PathBuf {
    let beside = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data");
    std::env::var_os("MAQUETTE_SHARED").map_or(beside, |shared| PathBuf::from(shared).join("data"))
}
