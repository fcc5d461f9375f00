//! Tables of several trials for spreadsheets: one heading line, a row for each number and side; SI units, degrees.

use std::collections::BTreeMap;

use super::tables::finished;
use crate::gait::trials::{Change, CurveChange, Measure, Sides, Spread};
use crate::pipeline::OneBody;

/// How far every number varies, and its value in each trial.
///
/// # Errors
/// None that a session can cause; the writer's, if it has any.
pub fn variation_csv(
    names: &[&str],
    spreads: &BTreeMap<Measure, Spread>,
) -> std::io::Result<Vec<u8>> {
    let heading = [
        "number",
        "side",
        "unit",
        "mean",
        "sd_strides",
        "sd_trials",
        "fit_sd",
        "trials",
        "strides",
    ];
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record(heading.iter().chain(names))?;
    for (measure, spread) in spreads {
        let mut row = named(*measure, Sides::Same);
        row.push(text(Some(spread.mean)));
        row.extend([spread.between_strides, spread.between_trials, spread.fit].map(text));
        row.extend([spread.trials, spread.strides].map(|count| count.to_string()));
        row.extend(spread.values.iter().copied().map(text));
        writer.write_record(row)?;
    }
    finished(writer)
}

/// Every change from one session to another, or from one side to the other, and in each row whether both have one body.
///
/// # Errors
/// As [`variation_csv`].
pub fn changes_csv(
    changes: &[Change],
    sides: Sides,
    one_body: &OneBody,
) -> std::io::Result<Vec<u8>> {
    let heading = [
        "number",
        "side",
        "unit",
        "before",
        "before_sd",
        "before_trials",
        "after",
        "after_sd",
        "after_trials",
        "change",
        "low_95",
        "high_95",
        "mdc",
        "beyond_mdc",
        "one_body",
    ];
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record(heading)?;
    for change in changes {
        let mut row = named(change.measure, sides);
        for own in [&change.before, &change.after] {
            row.extend([text(Some(own.mean)), text(own.between_trials), own.trials.to_string()]);
        }
        let (low, high) = change.interval.unzip();
        row.extend([Some(change.difference), low, high, change.detectable].map(text));
        row.push(change.is_detected().to_string());
        row.push(one_body.name().to_owned());
        writer.write_record(row)?;
    }
    finished(writer)
}

/// Where over the cycle curves differ: a row for each stretch, and one without it for a curve that differs nowhere.
///
/// # Errors
/// As [`variation_csv`].
pub fn curve_changes_csv(curves: &[CurveChange]) -> std::io::Result<Vec<u8>> {
    let heading = [
        "angle",
        "side",
        "before_trials",
        "after_trials",
        "freedom",
        "fwhm_percent",
        "threshold_t",
        "from_percent",
        "to_percent",
        "peak_t",
        "p",
    ];
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record(heading)?;
    for CurveChange { angle, side, trials, test } in curves {
        let mut curve = vec![angle.name().to_owned(), side.name().to_owned()];
        curve.extend(trials.map(|count| count.to_string()));
        curve.extend([test.field.freedom, test.field.fwhm, test.threshold].map(Some).map(text));
        for stretch in &test.stretches {
            let numbers = [stretch.from, stretch.to, stretch.peak, stretch.p];
            writer.write_record(curve.iter().cloned().chain(numbers.map(Some).map(text)))?;
        }
        if test.stretches.is_empty() {
            writer.write_record(curve.iter().cloned().chain([None; 4].map(text)))?;
        }
    }
    finished(writer)
}

fn named(measure: Measure, sides: Sides) -> Vec<String> {
    let Measure { quantity, side } = measure;
    vec![quantity.name(), sides.name(side).into(), quantity.unit().into()]
}

fn text(value: Option<f64>) -> String {
    value.filter(|v| v.is_finite()).map_or(String::new(), |v| format!("{v:.6}"))
}
