//! `maquette compare`.

use std::path::{Path, PathBuf};

use clap::Args;
use maquette::gait::trials::{Change, CurveChange, Sides, Stretch};
use maquette::io::folder::{OutFolder, check_out};
use maquette::workflow::{Comparison, SessionStudy};
use serde_json::{Value, json};

use crate::error::CliError;
use crate::page::PageArguments;
use crate::subject::norm_choice;
use crate::switches::{Output, Overwrite, print_notes};
use crate::table::Table;

pub(super) const ABOUT: &str = "\
Compare two sessions of one person: what changed, and whether it is more than chance.

Takes the folders of two finished `maquette session`, the earlier one first. Folders of `maquette fit` and .trc files are taken too, as \
sessions of one trial. One session alone is compared by the conditions of its trials, which have one body: such a difference is surer. \
With --sides, the right side of one session is compared with its left. \
Writes compare.html, which prints on A4, and changes.csv: of every number the change with its 95 % interval, and the minimal \
detectable change, which a person who has not changed exceeds once in twenty times. With three trials or more in both, \
curve_changes.csv and bars under the curves tell where over the cycle they differ. docs/session.md explains all.";

pub(super) const EXAMPLES: &str = "\
Examples:
  maquette compare out/before out/after --out out/change
  maquette compare out/before out/after --out out/change --pdf
  maquette compare out/both --out out/change                          (a session of trials of two conditions)
  maquette compare out/all --conditions barefoot orthosis --out out/orthosis-effect
  maquette compare out/before --sides --out out/right-and-left";

/// Arguments of `maquette compare`.
#[derive(Debug, Args)]
pub(super) struct CompareArguments {
    /// Folder of the first session
    before: PathBuf,
    /// Folder of the second session; left out, the first is compared by the conditions of its trials
    after: Option<PathBuf>,
    /// Which two conditions of one session [default: the only two]
    #[arg(long, num_args = 2, value_names = ["FIRST", "SECOND"], conflicts_with = "after")]
    conditions: Vec<String>,
    /// How the right side differs from the left, trial by trial, in one session
    #[arg(long, conflicts_with_all = ["after", "conditions"])]
    sides: bool,
    /// Where to write compare.html, changes.csv and curve_changes.csv; it must be empty or new
    #[arg(long, value_name = "FOLDER")]
    out: PathBuf,
    /// Norm of healthy people: a .toml file, or none [default: the shipped one of their age]
    #[arg(long, value_name = "FILE|none")]
    norm: Option<String>,
    /// Body model of both, if it is not a shipped one
    #[arg(long, value_name = "FILE")]
    body: Option<String>,
    #[command(flatten)]
    page: PageArguments,
    #[command(flatten)]
    overwrite: Overwrite,
    #[command(flatten)]
    output: Output,
}

impl CompareArguments {
    /// Both, compared.
    fn compared(&self) -> Result<Comparison, CliError> {
        let open = |path: &PathBuf| -> Result<SessionStudy, CliError> {
            let norm = norm_choice(self.norm.as_deref());
            Ok(SessionStudy::open(path, self.body.as_deref(), norm)?)
        };
        let before = open(&self.before)?;
        if self.sides {
            return Ok(Comparison::of_sides(&before)?);
        }
        let Some(after) = &self.after else {
            let named = match self.conditions.as_slice() {
                [first, second] => Some([first.as_str(), second]),
                _ => None,
            };
            return Ok(Comparison::of_conditions(&before, named)?);
        };
        Ok(Comparison::new(before, open(after)?)?)
    }

    /// What `--json` prints, and the page.
    pub(super) fn call(&self) -> Result<(Value, String), CliError> {
        let comparison = self.compared()?;
        Ok((json(self, &comparison, None), comparison.report(self.page.language())))
    }
}

/// Reads both, compares them, writes page and table.
pub(super) fn run(arguments: &CompareArguments) -> Result<(), CliError> {
    check_out(&arguments.out, arguments.overwrite.existing())?;
    let comparison = arguments.compared()?;

    let out = OutFolder::open(&arguments.out)?;
    out.write("changes.csv", &comparison.csv()?)?;
    out.write("curve_changes.csv", &comparison.curves_csv()?)?;
    print_notes(&comparison.notes);
    let page = comparison.report(arguments.page.language());
    let written = arguments.page.write(&out, "compare.html", &page)?;
    let json = || json(arguments, &comparison, written.pdf.as_deref());
    arguments.output.summarise(|| text(arguments, &comparison), json);
    Ok(())
}

fn json(arguments: &CompareArguments, comparison: &Comparison, pdf: Option<&Path>) -> Value {
    let change = |change: &Change| {
        json!({
            "number": change.measure.quantity.name(),
            "side": comparison.sides.name(change.measure.side),
            "unit": change.measure.quantity.unit(),
            "before": change.before.mean,
            "after": change.after.mean,
            "change": change.difference,
            "interval_95": change.interval.map(|(low, high)| [low, high]),
            "mdc": change.detectable,
            "beyond_mdc": change.is_detected(),
        })
    };
    let changes: Vec<Value> = comparison.changes.iter().map(change).collect();
    let curves: Vec<Value> = comparison.curves.iter().map(curve_json).collect();
    json!({
        "out": arguments.out.display().to_string(),
        "pdf": pdf.map(|pdf| pdf.display().to_string()),
        "changes": changes,
        "curves": curves,
        "one_body": comparison.one_body.name(),
        "notes": comparison.lines(),
    })
}

fn curve_json(curve: &CurveChange) -> Value {
    let stretch = |s: &Stretch| json!({ "from_percent": s.from, "to_percent": s.to, "peak_t": s.peak, "p": s.p });
    let test = &curve.test;
    json!({
        "angle": curve.angle.name(),
        "side": curve.side.name(),
        "trials": curve.trials,
        "freedom": test.field.freedom,
        "fwhm_percent": test.field.fwhm,
        "threshold_t": test.threshold,
        "stretches": test.stretches.iter().map(stretch).collect::<Vec<_>>(),
    })
}

/// The changes beyond chance, for a person.
fn text(arguments: &CompareArguments, comparison: &Comparison) -> String {
    let [first, second, difference, verb] = match comparison.sides {
        Sides::Same => ["before", "after", "change", "changed"],
        Sides::Opposite => ["left", "right", "right less left", "differ between the sides"],
    };
    let mut table =
        Table::new(&["number", "side", first, second, difference, "95 % interval", "MDC"]);
    let changes = &comparison.changes;
    for change in changes.iter().filter(|change| change.is_detected()) {
        let number = |value: f64| format!("{value:.2}");
        let interval = change.interval.map(|(low, high)| format!("{low:.2} to {high:.2}"));
        table.row(vec![
            format!(
                "{}, {}",
                change.measure.quantity.name().replace('_', " "),
                change.measure.quantity.unit()
            ),
            comparison.sides.name(change.measure.side).into(),
            number(change.before.mean),
            number(change.after.mean),
            number(change.difference),
            interval.unwrap_or_default(),
            change.detectable.map(number).unwrap_or_default(),
        ]);
    }
    let detected = changes.iter().filter(|change| change.is_detected()).count();
    let head = format!("{detected} of {} numbers {verb} by more than chance\n", changes.len());
    let differ = comparison.curves.iter().filter(|curve| !curve.test.stretches.is_empty()).count();
    let curves = match comparison.curves.len() {
        0 => String::new(),
        all => {
            format!("{differ} of {all} curves differ somewhere in the cycle by more than chance\n")
        }
    };
    let end = format!("Written into {}\n", arguments.out.display());
    let bodies = comparison.two_bodies().map_or_else(String::new, |line| format!("!! {line}\n"));
    let all = [bodies, head, if detected > 0 { table.text() } else { String::new() }, curves, end];
    all.into_iter().filter(|section| !section.is_empty()).collect::<Vec<_>>().join("\n")
}
