//! XYZ and CSV.

use std::path::Path;

use super::columns::{self, Numbers, Stated};
use super::error::{CloudError, shortened};
use crate::stereo::{Cloud, CloudPoint};

/// Lines of three or four numbers with blanks between: x y z \[σ\]. Lines that begin with `#` and empty ones are
/// skipped; the first line with numbers states how many there are.
pub(super) fn parse_xyz(bytes: &[u8], path: &Path) -> Result<Cloud, CloudError> {
    let text = String::from_utf8_lossy(bytes);
    let mut columns = None;
    let mut points = Vec::new();
    for (number, line) in (1..).zip(text.lines()) {
        let line = line.trim().trim_start_matches('\u{feff}');
        if line.is_empty() || line.starts_with('#') {
            continue;
        }

        let numbers = numbers(line);
        let fault = |expected| CloudError::Line {
            path: path.into(),
            line: number,
            expected,
            found: shortened(line),
        };
        let numbers = numbers.ok_or_else(|| fault("three or four numbers: x y z [sigma]"))?;
        if *columns.get_or_insert(numbers.len()) != numbers.len() {
            return Err(fault("as many numbers as in the lines before"));
        }

        points.push(point(&numbers));
    }
    Ok(Cloud::from_points(points))
}

fn numbers(line: &str) -> Option<Vec<f64>> {
    let words = line.split_whitespace().take(5);
    let numbers: Vec<f64> = words.map(|word| word.parse().ok()).collect::<Option<_>>()?;
    [3, 4].contains(&numbers.len()).then_some(numbers)
}

fn point(numbers: &[f64]) -> CloudPoint {
    let mut slots = Numbers::default();
    slots.0[..numbers.len()].copy_from_slice(numbers);
    let stated = match numbers.len() {
        4 => Stated::Sigma,
        _ => Stated::Nothing,
    };
    stated.point(&slots)
}

/// A line of names, then one line for each point; other columns are skipped.
pub(super) fn parse_csv(bytes: &[u8], path: &Path) -> Result<Cloud, CloudError> {
    let csv_fault = |source| CloudError::Csv { path: path.into(), source };

    // spreadsheets write a byte order mark
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let mut reader =
        csv::ReaderBuilder::new().trim(csv::Trim::All).comment(Some(b'#')).from_reader(bytes);
    let names = reader.headers().map_err(csv_fault)?.clone();
    let stated = Stated::by(&names).ok_or_else(|| CloudError::Columns {
        path: path.into(),
        expected: columns::EXPECTED,
        found: names.iter().map(shortened).collect(),
    })?;

    let slots: Vec<Option<usize>> = names.iter().map(columns::slot).collect();
    let mut points = Vec::new();
    for record in reader.records() {
        let record = record.map_err(csv_fault)?;
        let mut numbers = Numbers::default();
        for (cell, slot) in record.iter().zip(&slots) {
            let Some(slot) = slot else { continue };
            numbers.0[*slot] = cell.parse().map_err(|_| CloudError::Line {
                path: path.into(),
                line: record.position().map_or(0, csv::Position::line),
                expected: "a number",
                found: shortened(cell),
            })?;
        }
        points.push(stated.point(&numbers));
    }

    Ok(Cloud::from_points(points))
}
