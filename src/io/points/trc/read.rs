//! Trajectories from any program's TRC.

use std::path::{Path, PathBuf};

use nalgebra::{Point3, Vector3};

use super::Trajectories;
use super::clock::{self, Stamp};
use crate::camera::UpAxis;
use crate::io::frame_rate;
use crate::io::input::shortened;

/// Why a TRC file could not be used.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum TrcError {
    /// No line that starts with `Frame#`.
    #[error("{}: expected a line that starts with Frame#, found none: this is no TRC file", path.display())]
    NoNames {
        /// File.
        path: PathBuf,
    },
    /// No line of numbers before the names.
    #[error("{}:{line}: expected the values of DataRate … OrigNumFrames, found {found:?}", path.display())]
    Header {
        /// File.
        path: PathBuf,
        /// Line, from 1.
        line: usize,
        /// What stands there.
        found: String,
    },
    /// A frame rate that is none.
    #[error("{}:{line}: expected {}, found {found:?}", path.display(), frame_rate::EXPECTED)]
    Rate {
        /// File.
        path: PathBuf,
        /// Line, from 1.
        line: usize,
        /// What stands there.
        found: String,
    },
    /// A unit that is neither metre nor millimetre.
    #[error("{}:{line}: expected the unit m or mm, found {found:?}", path.display())]
    Unit {
        /// File.
        path: PathBuf,
        /// Line, from 1.
        line: usize,
        /// What stands there.
        found: String,
    },
    /// A frame number or a time that is none.
    #[error("{}:{line}: {column}: expected a number, found {found:?}", path.display())]
    Stamp {
        /// File.
        path: PathBuf,
        /// Line, from 1.
        line: usize,
        /// `Frame#` or `Time`.
        column: &'static str,
        /// What stands there.
        found: String,
    },
    /// A row that comes twice, or too early.
    #[error(
        "{}:{line}: frame {number} follows frame {before}: expected ascending numbers, each once", path.display()
    )]
    Order {
        /// File.
        path: PathBuf,
        /// Line, from 1.
        line: usize,
        /// Of the row.
        number: usize,
        /// Of the row before.
        before: usize,
    },
    /// Too many numbers without a row.
    #[error(
        "{}: {rows} rows, and {missing} frame numbers between them have none: expected a row for every frame, or nearly",
        path.display()
    )]
    Missing {
        /// File.
        path: PathBuf,
        /// How many rows there are.
        rows: usize,
        /// How many there are not.
        missing: usize,
    },
    /// Times that do not grow as the frame numbers do.
    #[error(
        "{}:{line}: {found_s:.6} s from frame {before} to frame {number}, expected {expected_s:.6} s by the other rows: are rows missing, doubled or out of order?",
        path.display()
    )]
    Time {
        /// File.
        path: PathBuf,
        /// Line, from 1.
        line: usize,
        /// Of the row.
        number: usize,
        /// Of the row before.
        before: usize,
        /// Between the two.
        found_s: f64,
        /// The same by the other rows.
        expected_s: f64,
    },
    /// A row of a file without tabs that has not three numbers for each name.
    #[error("{}:{line}: expected {expected} cells ({points} points) between spaces, found {found}", path.display())]
    Cells {
        /// File.
        path: PathBuf,
        /// Line, from 1.
        line: usize,
        /// Frame, time, and three for each name.
        expected: usize,
        /// Number of names.
        points: usize,
        /// Number of cells.
        found: usize,
    },
    /// A cell that is not a number.
    #[error("{}:{line}: point {point}: expected a number or nothing, found {found:?}", path.display())]
    Cell {
        /// File.
        path: PathBuf,
        /// Line, from 1.
        line: usize,
        /// Name of the point.
        point: String,
        /// What stands there.
        found: String,
    },
}

/// The points of a TRC file's text; `path` is what errors name.
///
/// Takes Pose2Sim's, OpenSim's and caliscope's: metres or millimetres, padded cells, marker names with spaces, an
/// empty line before the data or none, trailing tabs, and empty or NaN cells for a missing point; and files in which
/// spaces stand for tabs, if no name has a space and no cell is empty. Frame numbers and times must grow together; a number
/// that is left out with its time is a frame without points. The stated number of frames is not relied on.
///
/// # Errors
/// [`TrcError`] names the line and what was expected.
pub fn read_trc(text: &str, path: &Path) -> Result<Trajectories, TrcError> {
    read_with_rate(text, path).map(|(trajectories, _)| trajectories)
}

/// The same, and how many frames a second has by the times of the rows, if they say.
pub(crate) fn read_with_rate(
    text: &str,
    path: &Path,
) -> Result<(Trajectories, Option<f64>), TrcError> {
    let mut lines = text.lines().enumerate().map(|(i, line)| (i + 1, line));

    // the last line above the names holds the rate and the unit
    let (mut line, mut rate_line) = (1, "");
    let names = loop {
        match lines.next() {
            Some((_, line)) if line.trim_start().starts_with("Frame#") => break line,
            Some((i, text)) if !text.trim().is_empty() => (line, rate_line) = (i, text),
            Some(_) => {}
            None => {
                return Err(TrcError::NoNames { path: path.to_owned() });
            }
        }
    };

    let between = Separator::used_in(names);
    let names = names_of(names, between);
    let (rate_hz, metres) = rate_and_unit(line, rate_line, between, path)?;

    let (mut stamps, mut rows) = (Vec::new(), Vec::new());
    let is_data = |row: &str| !row.trim().is_empty() && !row.trim_start().starts_with("X1");
    for (line, row) in lines.filter(|(_, row)| is_data(row)) {
        let cells = split(row, between);
        let expected = 2 + 3 * names.len();
        if between == Separator::Spaces && cells.len() != expected {
            let (points, found) = (names.len(), cells.len());
            return Err(TrcError::Cells { path: path.to_owned(), line, expected, points, found });
        }
        stamps.push(Stamp::read(&cells, line, path)?);
        rows.push(frame_of(&cells, line, &names, metres, path)?);
    }

    let counted_hz = clock::check(&stamps, path)?;
    let first = stamps.first().map_or(1, |stamp| stamp.number);
    let mut frames: Vec<Vec<_>> = Vec::new();
    for (stamp, row) in stamps.iter().zip(rows) {
        frames.resize(stamp.number - first, vec![None; names.len()]);
        frames.push(row);
    }
    let first_frame = first.saturating_sub(1);
    Ok((Trajectories { rate_hz, first_frame, names, frames }, counted_hz))
}

/// The cells after Frame# and Time that are not empty.
fn names_of(line: &str, between: Separator) -> Vec<String> {
    let cells = split(line, between).into_iter().skip(2);
    cells.filter(|c| !c.is_empty()).map(str::to_owned).collect()
}

/// The data rate, and the metres of one unit.
fn rate_and_unit(
    line: usize,
    text: &str,
    between: Separator,
    path: &Path,
) -> Result<(f64, f64), TrcError> {
    let path = || path.to_owned();
    let cells = split(text, between).into_iter();
    let cells: Vec<&str> = cells.filter(|c| !c.is_empty()).collect();
    let [rate, _, _, _, unit, ..] = cells[..] else {
        let found = shortened(text);
        return Err(TrcError::Header { path: path(), line, found });
    };

    let metres = match unit.to_ascii_lowercase().as_str() {
        "m" => 1.0,
        "cm" => 1e-2,
        "mm" => 1e-3,
        _ => {
            let found = shortened(unit);
            return Err(TrcError::Unit { path: path(), line, found });
        }
    };

    match rate.parse::<f64>() {
        Ok(rate_hz) if frame_rate::is_one(rate_hz) => Ok((rate_hz, metres)),
        _ => Err(TrcError::Rate { path: path(), line, found: shortened(rate) }),
    }
}

fn frame_of(
    cells: &[&str],
    line: usize,
    names: &[String],
    metres: f64,
    path: &Path,
) -> Result<Vec<Option<Point3<f64>>>, TrcError> {
    let mut cells = cells.iter().skip(2).copied();
    let mut point = |name: &String| {
        let mut coordinate = || match cells.next() {
            None | Some("") => Ok(f64::NAN),
            Some(cell) => cell.parse::<f64>().map_err(|_| TrcError::Cell {
                path: path.to_owned(),
                line,
                point: name.clone(),
                found: shortened(cell),
            }),
        };

        let place = Vector3::new(coordinate()?, coordinate()?, coordinate()?);
        let point_world = Point3::from(UpAxis::Y.from_export(&place) * metres);
        let is_there = point_world.iter().all(|v| v.is_finite());
        Ok(is_there.then_some(point_world))
    };
    names.iter().map(&mut point).collect()
}

/// What stands between two cells.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Separator {
    Tabs,
    Spaces,
}

impl Separator {
    fn used_in(line: &str) -> Self {
        match line.contains('\t') {
            true => Self::Tabs,
            false => Self::Spaces,
        }
    }
}

/// The cells of a line: between tabs, or between spaces where a file has none.
fn split(line: &str, between: Separator) -> Vec<&str> {
    match between {
        Separator::Tabs => line.split('\t').map(str::trim).collect(),
        Separator::Spaces => line.split_whitespace().collect(),
    }
}
