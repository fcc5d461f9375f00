//! Recordings spoiled in fifty ways each, and some that are spoiled already: how far off the fit is, what it says of itself, and which cause it names.
//!
//! A row is *silent* if the error is more than twice that of the clean recording, neither verdict nor note names its cause, and
//! the stated standard deviations of the joint centres do not cover it. A row that only a note names is counted apart: a world
//! that is 10 % too large shows what a person who is 10 % taller shows, so no program can do more than ask for the height.
//!
//! Starts: the body is found from nothing, as `maquette fit` does it.

mod damage;
mod jumps;
mod shadows;
mod worn;

use std::error::Error;
use std::process::ExitCode;

use damage::{Damage, as_recorded, damages, recalibrated};
use experiments::figures::fitted;
use experiments::metrics::{mpjpe_mm, rms_z};
use experiments::recorded::Recorded;
use experiments::run::{Run, shared_data};
use experiments::table::Table;
use maquette::pipeline::Fit;

/// A recording that is spoiled.
struct Set {
    name: &'static str,
    fps: f64,
    /// The file of the truth.
    truth: &'static str,
    damages: fn() -> Vec<Damage>,
}

const SETS: [Set; 6] = [
    Set { name: "walk7", fps: 50.0, truth: "truth.trc", damages },
    Set { name: "dressed", fps: 50.0, truth: "truth.trc", damages },
    Set { name: "balance", fps: 60.0, truth: "reference.trc", damages },
    Set {
        name: "moved",
        fps: 50.0,
        truth: "truth.trc",
        damages: || {
            vec![
                recalibrated(),
                as_recorded("cam_02 was touched & cam_04 was touched & cam_05 was touched"),
            ]
        },
    },
    Set {
        name: "clocks",
        fps: 50.0,
        truth: "truth.trc",
        damages: || vec![as_recorded("cam_02 is late & cam_03 is early & cam_06 is early")],
    },
    Set {
        name: "two",
        fps: 50.0,
        truth: "truth.trc",
        damages: || vec![as_recorded("second person")],
    },
];
/// The recording as it is.
const CLEAN: &str = "nothing";
/// An error of so many times the clean one needs a word.
const TWICE: f64 = 2.0;
/// Errors of so many of their standard deviations, root mean square, are said by these.
const COVERED: f64 = 2.0;
/// How the name of a damage ends whose recording states the person's height.
const HEIGHT_GIVEN: &str = "height given";

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let mut run = Run::start("spoiled");
    if !shared_data().is_dir() {
        run.say(&format!("skipped: no recordings in {}", shared_data().display()));
        return Ok(ExitCode::SUCCESS);
    }
    let sets = if run.is_quick() { &SETS[..1] } else { &SETS[..] };
    let header = ["set", "spoiled by", "mm", "× clean", "z", "what was said"];
    let mut table = Table::new("spoiled", &header);
    let (mut silent, mut noted, mut rows) = (0, 0, 0);
    for Set { name, fps, truth, damages } in sets {
        let is_wanted = |damage: &Damage| run.wants(&format!("{name} | {}", damage.name));
        let mut wanted = damages();
        if run.is_partial() && !wanted.iter().any(is_wanted) {
            continue;
        }
        wanted.retain(|damage| is_wanted(damage) || damage.name == CLEAN);

        let recorded = Recorded::read(&shared_data().join(name), *fps, truth)?;
        let mut clean_mm = f64::NAN;
        for damage in wanted {
            let Some(row) = Row::new(&damage, &recorded)? else {
                continue;
            };
            if damage.name == CLEAN {
                clean_mm = row.error_mm;
            }
            rows += 1;
            match row.told(clean_mm, &damage) {
                Told::Enough => {}
                Told::ByNote => noted += 1,
                Told::Nothing => silent += 1,
            }
            table.row(row.cells(name, &damage, clean_mm));
            run.say(&row.cells(name, &damage, clean_mm).join(" | "));
        }
    }

    if run.is_partial() {
        return Ok(ExitCode::SUCCESS);
    }
    run.table("Spoiled recordings", &table)?;
    run.number("rows", rows as f64);
    run.number("silent", silent as f64);
    run.number("told by a note", noted as f64);
    Ok(run.finish()?)
}

/// What became of a spoiled recording.
struct Row {
    /// NaN where nothing was fitted.
    error_mm: f64,
    /// Root mean square of the errors in their standard deviations; NaN where these are withheld.
    z: f64,
    is_usable: bool,
    /// The verdict.
    said: String,
    /// The warnings.
    notes: String,
}

/// What a reader learns of an error.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Told {
    /// Its cause or its size, or there is not much of it.
    Enough,
    /// A note names the cause.
    ByNote,
    /// Neither.
    Nothing,
}

impl Row {
    /// `None` for a height that is not known.
    fn new(damage: &Damage, recorded: &Recorded) -> Result<Option<Self>, Box<dyn Error>> {
        let spoiled = (damage.spoil)(recorded);
        if damage.name.ends_with(HEIGHT_GIVEN) && spoiled.given_m.is_none() {
            return Ok(None);
        }
        Ok(Some(match spoiled.fit()? {
            Ok(fit) => Self::from_fit(&spoiled, &fit),
            Err(refused) => Self {
                error_mm: f64::NAN,
                z: f64::NAN,
                is_usable: false,
                said: format!("refused: {refused}"),
                notes: String::new(),
            },
        }))
    }

    fn from_fit(spoiled: &Recorded, fit: &Fit) -> Self {
        let fitted = fitted(fit, spoiled.fps);
        let covariances =
            fit.frames.iter().map(|f| Some(f.uncertainty.as_ref()?.points.as_slice()));
        let covariances: Vec<_> = covariances.collect();
        Self {
            error_mm: mpjpe_mm(&spoiled.truth, &fitted).unwrap_or(f64::NAN),
            z: rms_z(&spoiled.truth, &fitted, &covariances).unwrap_or(f64::NAN),
            is_usable: fit.verdict.is_usable(),
            said: fit.verdict.headline().unwrap_or_default(),
            notes: fit.warnings.iter().map(|w| format!("{w}; ")).collect(),
        }
    }

    fn names_cause(&self, damage: &Damage) -> bool {
        damage.cause.split(" & ").all(|said| self.said.contains(said))
    }

    /// Whether an error that is far off is told.
    fn told(&self, clean_mm: f64, damage: &Damage) -> Told {
        let is_named = !damage.cause.is_empty() && self.names_cause(damage);
        let is_far = clean_mm.is_nan() || self.error_mm > TWICE * clean_mm;
        let is_covered = self.z <= COVERED;
        let is_noted = damage.note.is_some_and(|note| self.notes.contains(note));
        match (!is_far || is_named || is_covered, is_noted) {
            (true, _) => Told::Enough,
            (false, true) => Told::ByNote,
            (false, false) => Told::Nothing,
        }
    }

    fn cells(&self, set: &str, damage: &Damage, clean_mm: f64) -> [String; 6] {
        let mark = match (self.told(clean_mm, damage), self.names_cause(damage)) {
            (Told::Nothing, _) => "✗ ",
            (Told::ByNote, _) => "a note only: ",
            (Told::Enough, false) => "(✗) ",
            (Told::Enough, true) => "",
        };
        [
            set.to_owned(),
            damage.name.to_owned(),
            format!("{:.0}", self.error_mm),
            format!("{:.1}", self.error_mm / clean_mm),
            format!("{:.1}", self.z),
            format!("{mark}{}{}", if self.is_usable { "" } else { "exit 3: " }, self.said),
        ]
    }
}
