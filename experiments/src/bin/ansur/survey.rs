//! ANSUR II as published: a row a person, millimetres, mass in tenths of a kilogram.

use std::path::{Path, PathBuf};

/// The measures that the quantities are made of, by their names in the survey's files.
const MEASURES: [&str; 33] = [
    "stature",
    "weightkg",
    "acromialheight",
    "acromionradialelength",
    "anklecircumference",
    "biacromialbreadth",
    "bicepscircumferenceflexed",
    "buttockdepth",
    "buttockkneelength",
    "calfcircumference",
    "cervicaleheight",
    "chestbreadth",
    "chestdepth",
    "crotchheight",
    "footbreadthhorizontal",
    "footlength",
    "forearmcircumferenceflexed",
    "handbreadth",
    "handlength",
    "headbreadth",
    "headlength",
    "heelbreadth",
    "hipbreadth",
    "lateralfemoralepicondyleheight",
    "lateralmalleolusheight",
    "lowerthighcircumference",
    "neckcircumference",
    "radialestylionlength",
    "thighcircumference",
    "tragiontopofhead",
    "waistbreadth",
    "waistdepth",
    "wristcircumference",
];

/// Why the survey cannot be used.
#[derive(Debug, thiserror::Error)]
pub(crate) enum SurveyError {
    #[error("cannot read {path}: {source}")]
    Read { path: PathBuf, source: csv::Error },
    #[error("{path}: expected a column {measure}, found none; is it ANSUR II's public file?")]
    Column { path: PathBuf, measure: &'static str },
    #[error("{path}: expected a number as {measure} of person {row}, found {found:?}")]
    Number { path: PathBuf, measure: &'static str, row: usize, found: String },
}

/// One measured person.
#[derive(Debug, Clone)]
pub(crate) struct Person([f64; MEASURES.len()]);

impl Person {
    /// A length, breadth or girth, m.
    pub(crate) fn metres(&self, measure: &str) -> f64 {
        1e-3 * self.raw(measure)
    }

    /// Mass, kg.
    pub(crate) fn mass_kg(&self) -> f64 {
        0.1 * self.raw("weightkg")
    }

    fn raw(&self, measure: &str) -> f64 {
        let index = MEASURES.iter().position(|m| *m == measure);
        self.0[index.expect("every measure that a quantity names is in MEASURES")]
    }
}

/// Everybody in one of the survey's two files.
///
/// # Errors
/// [`SurveyError`] with the file, and the column or the person.
pub(crate) fn read(path: &Path) -> Result<Vec<Person>, SurveyError> {
    let error = |source| SurveyError::Read { path: path.to_owned(), source };
    let mut reader = csv::Reader::from_path(path).map_err(error)?;
    let header = reader.byte_headers().map_err(error)?.clone();
    let mut columns = [0; MEASURES.len()];
    for (column, measure) in columns.iter_mut().zip(MEASURES) {
        let found = header.iter().position(|name| name.eq_ignore_ascii_case(measure.as_bytes()));
        let missing = || SurveyError::Column { path: path.to_owned(), measure };
        *column = found.ok_or_else(missing)?;
    }

    let mut people = Vec::new();
    for (row, record) in reader.byte_records().enumerate() {
        let record = record.map_err(error)?;
        let mut person = Person([0.0; MEASURES.len()]);
        for ((value, column), measure) in person.0.iter_mut().zip(columns).zip(MEASURES) {
            let found = String::from_utf8_lossy(record.get(column).unwrap_or_default());
            let wrong = |found: &str| SurveyError::Number {
                path: path.to_owned(),
                measure,
                row: row + 1,
                found: found.to_owned(),
            };
            *value = found.trim().parse().map_err(|_| wrong(&found))?;
        }
        people.push(person);
    }
    Ok(people)
}
