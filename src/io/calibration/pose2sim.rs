//! The TOML of Pose2Sim, aniposelib, caliscope and FreeMoCap.
//!
//! One table per camera, at the top or under `[cameras]`: `size`, `matrix`, `distortions`, `fisheye`, and the pose
//! `x_cam = R(rotation)·X + translation` with a Rodrigues vector, which may be missing where lenses alone are wanted. Metres, except FreeMoCap's millimetres. Cameras are
//! sorted by the key of their table; their name is `name`, or that key.

use super::{
    CalibrationError, Place, Unit,
    error::one_line,
    natural_order::natural,
    unchecked::{Lens, Numbers, Size, UncheckedCamera},
};
use std::path::Path;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// A table with one of these is a camera; all others are metadata.
const CAMERA_KEYS: [&str; 4] = ["matrix", "distortions", "rotation", "translation"];
/// Metadata that only FreeMoCap writes.
const FREEMOCAP_KEYS: [&str; 4] = [
    "charuco_square_size",
    "charuco_board_object",
    "path_to_recorded_videos",
    "date_time_calibrated",
];

/// The cameras of a TOML file.
pub(super) fn parse(path: &Path, text: &str) -> Result<Vec<UncheckedCamera>, CalibrationError> {
    let document = DeTable::parse(text).map_err(|error| syntax(path, text, &error))?;
    let document = document.get_ref();
    let unit = own_unit(document);
    let mut cameras = Vec::new();
    for section in sections(path, text, document) {
        if !section.is_left_out() {
            cameras.push(section.camera(unit)?);
        }
    }
    Ok(cameras)
}

fn syntax(path: &Path, text: &str, error: &toml::de::Error) -> CalibrationError {
    let line = error.span().map(|span| line_at(text, span.start));
    CalibrationError::Syntax {
        place: Place::new(path, line, None),
        expected: "TOML",
        found: one_line(&error.message().replace('\n', ", ")),
    }
}

fn line_at(text: &str, offset: usize) -> usize {
    let before = text.as_bytes().get(..offset).unwrap_or(text.as_bytes());
    1 + before.iter().filter(|&&byte| byte == b'\n').count()
}

fn own_unit(document: &DeTable<'_>) -> Unit {
    let metadata = get(document, "metadata").and_then(|value| value.get_ref().as_table());
    let is_freemocap = |table| FREEMOCAP_KEYS.iter().any(|key| get(table, key).is_some());
    if metadata.is_some_and(is_freemocap) { Unit::Millimetre } else { Unit::Metre }
}

fn get<'a, 'i>(table: &'a DeTable<'i>, key: &str) -> Option<&'a Spanned<DeValue<'i>>> {
    let mut entries = table.iter();
    entries
        .find(|(name, _)| name.get_ref() == key)
        .map(|(_, value)| value)
        // caliscope writes a value it does not have as the text "null"
        .filter(|value| value.get_ref().as_str() != Some("null"))
}

/// The tables that describe a camera, sorted.
fn sections<'a>(path: &'a Path, text: &'a str, document: &'a DeTable<'a>) -> Vec<Section<'a>> {
    let mut sections = Vec::new();
    for (key, value) in document {
        let Some(table) = value.get_ref().as_table() else {
            continue;
        };
        let is_camera = |table| CAMERA_KEYS.iter().any(|key| get(table, key).is_some());
        let section = |key: &'a str, value: &Spanned<DeValue<'_>>, table, nested| Section {
            path,
            text,
            key,
            line: line_at(text, value.span().start),
            table,
            nested,
        };

        if is_camera(table) {
            sections.push(section(key.get_ref(), value, table, false));
        } else if key.get_ref() == "cameras" {
            let inner = table.iter().filter_map(|(key, value)| {
                let table = value.get_ref().as_table().filter(|t| is_camera(t))?;
                Some(section(key.get_ref(), value, table, true))
            });
            sections.extend(inner);
        }
    }

    sections.sort_by(|a, b| natural(a.key, b.key));
    sections
}

struct Section<'a> {
    path: &'a Path,
    text: &'a str,
    key: &'a str,
    line: usize,
    table: &'a DeTable<'a>,
    /// Under `[cameras]`, as caliscope writes.
    nested: bool,
}

impl Section<'_> {
    /// What caliscope ignores, or has not posed.
    fn is_left_out(&self) -> bool {
        let ignored = get(self.table, "ignore").and_then(|value| value.get_ref().as_bool());
        let unposed = ["rotation", "translation"].iter().all(|key| get(self.table, key).is_none());
        ignored == Some(true) || self.nested && unposed
    }

    fn camera(&self, unit: Unit) -> Result<UncheckedCamera, CalibrationError> {
        let size = match get(self.table, "size") {
            Some(_) => Size::Stated(self.numbers("size")?),
            None => Size::Unstated,
        };
        Ok(UncheckedCamera {
            name: self.name(),
            path: self.path.into(),
            line: self.line,
            size,
            matrix: self.numbers("matrix")?,
            lens: self.lens()?,
            rotation: self.numbers_if_any("rotation")?,
            translation: self.numbers_if_any("translation")?,
            unit,
        })
    }

    fn name(&self) -> String {
        match get(self.table, "name").map(Spanned::get_ref) {
            Some(DeValue::String(name)) => name.to_string(),
            Some(DeValue::Integer(number)) => number.to_string(),
            _ => self.key.into(),
        }
    }

    fn lens(&self) -> Result<Lens, CalibrationError> {
        if get(self.table, RADIAL_CORRECTION).is_some() {
            return Ok(Lens::RadialCorrection(self.numbers(RADIAL_CORRECTION)?));
        }
        let distortions = self.numbers("distortions")?;
        let fisheye = get(self.table, "fisheye").and_then(|value| value.get_ref().as_bool());
        Ok(if fisheye == Some(true) {
            Lens::Fisheye(distortions)
        } else {
            Lens::BrownConrady(distortions)
        })
    }

    /// The numbers of an array of any depth, row by row.
    fn numbers(&self, key: &str) -> Result<Numbers, CalibrationError> {
        let value = get(self.table, key).ok_or_else(|| CalibrationError::MissingKey {
            place: self.place(self.line),
            key: key.into(),
        })?;
        let mut values = Vec::new();
        self.flatten(key, value, &mut values)?;
        let line = line_at(self.text, value.span().start);
        Ok(Numbers::new(self.path, line, key, values))
    }

    /// The same, or no numbers.
    fn numbers_if_any(&self, key: &str) -> Result<Numbers, CalibrationError> {
        match get(self.table, key) {
            Some(_) => self.numbers(key),
            None => Ok(Numbers::new(self.path, self.line, key, Vec::new())),
        }
    }

    fn flatten(
        &self,
        key: &str,
        value: &Spanned<DeValue<'_>>,
        values: &mut Vec<f64>,
    ) -> Result<(), CalibrationError> {
        let (number, found) = match value.get_ref() {
            DeValue::Array(array) => {
                return array.iter().try_for_each(|item| self.flatten(key, item, values));
            }
            DeValue::Integer(number) => (number.as_str().parse().ok(), number.to_string()),
            DeValue::Float(number) => (number.as_str().parse().ok(), number.to_string()),
            DeValue::String(text) => (None, text.to_string()),
            other => (None, other.type_str().to_owned()),
        };

        values.push(number.ok_or_else(|| CalibrationError::NotANumber {
            place: self.place(line_at(self.text, value.span().start)),
            key: key.into(),
            found,
        })?);
        Ok(())
    }

    fn place(&self, line: usize) -> Place {
        Place::new(self.path, Some(line), Some(&self.name()))
    }
}

/// Our own key, for the one lens that OpenCV's coefficients cannot say.
pub(super) const RADIAL_CORRECTION: &str = "radial_correction";
