//! Cameras in OpenCV's `FileStorage`: EasyMocap's pair of files, one file for all cameras, or one per camera.
//!
//! With several cameras each key ends in `_` and the camera's name (`K_1`, `dist_1`, `R_1`, `Rot_1`, `T_1`, `H_1`,
//! `W_1`); a file for one camera has the long names of OpenCV's samples. A rotation is a Rodrigues vector or a matrix.

use super::{
    CalibrationError, Place, Unit,
    opencv_storage::{Entry, Storage},
    unchecked::{Lens, Numbers, Size, UncheckedCamera},
};
use std::path::Path;

/// Names of one value: short, as with several cameras; then long, as OpenCV's samples write it; then others in use.
const MATRIX: &[&str] = &["K", "camera_matrix", "cameraMatrix", "intrinsicMatrix"];
const DISTORTION: &[&str] =
    &["dist", "distortion_coefficients", "distCoeffs", "distortionCoefficients", "D"];
const ROTATION: &[&str] =
    &["R", "rotation_vectors", "rotation_vector", "rotation_matrix", "rvec", "Rot"];
const TRANSLATION: &[&str] = &["T", "translation_vectors", "translation_vector", "tvec"];
const WIDTH: &[&str] = &["W", "image_width", "image_Width", "width"];
const HEIGHT: &[&str] = &["H", "image_height", "image_Height", "height"];
const FISHEYE: &[&str] = &["fisheye_model"];

/// The cameras of these files taken together; `alone` names the camera of a file that describes only one.
pub(super) fn cameras(
    storages: &[Storage],
    alone: &str,
) -> Result<Vec<UncheckedCamera>, CalibrationError> {
    let (paired, unpaired) = paired(storages);
    // without a camera that both describe, the first fault says what is missing
    let names = if paired.is_empty() { unpaired } else { paired };
    if names.is_empty() {
        let source = Source { storages, name: alone, suffix: String::new() };
        return Ok(vec![source.camera()?]);
    }

    let cameras = names.iter().map(|name| {
        let source = Source { storages, name, suffix: format!("_{name}") };
        source.camera()
    });
    cameras.collect()
}

/// The cameras that have a lens in the first file and a pose in the last, and those that have one of them.
pub(super) fn paired(storages: &[Storage]) -> (Vec<String>, Vec<String>) {
    let (Some(first), Some(last)) = (storages.first(), storages.last()) else {
        return (Vec::new(), Vec::new());
    };
    let has = |storage: &Storage, keys: &[&str], name: &str| {
        let keys: Vec<String> = keys.iter().map(|key| format!("{key}_{name}")).collect();
        storage.find(&keys).is_some()
    };
    let mut all = names(storages);
    let listed: Vec<String> =
        storages[1..].iter().flat_map(|s| names(std::slice::from_ref(s))).collect();
    all.extend(listed.into_iter().filter(|name| !all.contains(name)).collect::<Vec<_>>());
    all.into_iter().partition(|name| {
        has(first, MATRIX, name) && (has(last, ROTATION, name) || has(last, TRANSLATION, name))
    })
}

/// As listed under `names`, or, without a list, as the keys `K_…` say.
fn names(storages: &[Storage]) -> Vec<String> {
    let listed = storages.iter().find_map(|s| s.find(&["names".to_owned()]));
    if let Some(entry) = listed {
        return entry.texts().map(str::to_owned).collect();
    }
    let entries = storages.iter().flat_map(|storage| &storage.entries);
    let name = |entry: &Entry| entry.key.strip_prefix("K_").map(str::to_owned);
    entries.filter_map(name).collect()
}

/// Where the values of one camera are.
struct Source<'a> {
    storages: &'a [Storage],
    name: &'a str,
    suffix: String,
}

impl Source<'_> {
    fn camera(&self) -> Result<UncheckedCamera, CalibrationError> {
        let matrix = self.required(MATRIX)?;
        Ok(UncheckedCamera {
            name: self.name.into(),
            path: matrix.path.clone(),
            line: matrix.line,
            size: self.size()?,
            lens: self.lens()?,
            matrix,
            rotation: self.required(ROTATION)?,
            translation: self.required(TRANSLATION)?,
            unit: Unit::Metre,
        })
    }

    fn size(&self) -> Result<Size, CalibrationError> {
        let (Some(mut width), Some(height)) = (self.find(WIDTH)?, self.find(HEIGHT)?) else {
            return Ok(Size::Unstated);
        };
        width.values.extend(height.values);
        Ok(Size::Stated(width))
    }

    fn lens(&self) -> Result<Lens, CalibrationError> {
        let coefficients = self.required(DISTORTION)?;
        let flag = self.find(FISHEYE)?;
        let is_fisheye = flag.is_some_and(|flag| flag.values.iter().any(|v| v.abs() > 0.0));
        Ok(if is_fisheye { Lens::Fisheye(coefficients) } else { Lens::BrownConrady(coefficients) })
    }

    fn find(&self, keys: &[&str]) -> Result<Option<Numbers>, CalibrationError> {
        let keys: Vec<String> = keys.iter().map(|key| format!("{key}{}", self.suffix)).collect();
        let found = self.storages.iter().find_map(|storage| Some((storage, storage.find(&keys)?)));
        found.map(|(storage, entry)| storage.numbers(entry, self.name)).transpose()
    }

    /// A value that must be there: intrinsics in the first file, extrinsics in the last.
    fn required(&self, keys: &[&str]) -> Result<Numbers, CalibrationError> {
        let extrinsic = keys == ROTATION || keys == TRANSLATION;
        let storage = if extrinsic { self.storages.last() } else { self.storages.first() };
        let path = storage.map_or(Path::new(""), |storage| &storage.path);
        let usual = keys.get(usize::from(self.suffix.is_empty())).copied();
        self.find(keys)?.ok_or_else(|| CalibrationError::MissingKey {
            place: Place::new(path, None, Some(self.name)),
            key: format!("{}{}", usual.unwrap_or_default(), self.suffix),
        })
    }
}
