//! Reading a result back: the body as it was fitted.

use std::io;
use std::path::{Path, PathBuf};

use nalgebra::{DVector, Rotation3, Vector3};
use serde::Deserialize;

use super::check::{self, OddField};
use super::{FORMAT, FramePart, JOINTS, RESULT, ResultFile, VERSION, seal};
use crate::body::{BodyModel, Motion, Shape};
use crate::camera::Rig;
use crate::inference::camera_offset::CameraOffset;
use crate::io::input::{self, MOST_OF_A_TABLE, shortened};

/// What a file says that it is.
#[derive(Deserialize)]
struct Head {
    format: String,
    version: u32,
    #[serde(default)]
    joints_blake3: String,
}

/// Whether the points beside a result are those that were written with it; removed points are no fault.
fn check_joints(path: &Path, blake3: &str) -> Result<(), ResultError> {
    match input::read(path, MOST_OF_A_TABLE) {
        Err(fault) if fault.kind() == io::ErrorKind::NotFound => Ok(()),
        Err(source) => Err(ResultError::Read { path: path.into(), source }),
        Ok(bytes) if blake3::hash(&bytes).to_string() == blake3 => Ok(()),
        Ok(_) => Err(ResultError::Joints { path: path.into() }),
    }
}

/// Why a result cannot be used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ResultError {
    /// No result there.
    #[error(
        "{}: cannot be read: {source}; expected the folder of a finished `maquette fit`",
        path.display()
    )]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// Not the fields of a result.
    #[error("{}:{}: not a result of `maquette fit`: {source}", path.display(), source.line())]
    Syntax {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        source: serde_json::Error,
    },
    /// A result of other fields than this program knows.
    #[error(
        "{}: version {found} of the format; this program reads version {VERSION}: {}",
        path.display(), if *found < VERSION { "fit the recording again, with --overwrite" } else { "use the newer program that wrote it" }
    )]
    Version {
        /// The file.
        path: PathBuf,
        /// Its version.
        found: u32,
    },
    /// Another file.
    #[error("{}: expected the format {FORMAT:?}, found {found:?}: this is no result of `maquette fit`", path.display())]
    Format {
        /// The file.
        path: PathBuf,
        /// Its format.
        found: String,
    },
    /// A file that does not end with the sum of what stands before.
    #[error(
        "{}: changed since `maquette fit` wrote it, or not whole: take the original back, or fit again (--resume keeps what was finished)",
        path.display()
    )]
    Changed {
        /// The file.
        path: PathBuf,
    },
    /// Points of another fit than the result's.
    #[error(
        "{}: changed since it was written with result.json, or another fit's: take the original back, remove it, or fit again (--resume keeps what was finished)",
        path.display()
    )]
    Joints {
        /// The file.
        path: PathBuf,
    },
    /// A number that no fit writes.
    #[error("{}: {field}: expected {expected}", path.display())]
    Field {
        /// The file.
        path: PathBuf,
        /// The field.
        field: &'static str,
        /// What it should be.
        expected: &'static str,
    },
    /// A result of another body than the one that is given.
    #[error(
        "this result was fitted with body model {body} ({expected} {kind}); the given model {found_body} has {found} or other names: give the fitted body with --body"
    )]
    Body {
        /// Name of the model in the result.
        body: String,
        /// Name of the model that is given.
        found_body: String,
        /// angles or shape coefficients.
        kind: &'static str,
        /// Their number in the result.
        expected: usize,
        /// Their number in the model.
        found: usize,
    },
}

impl ResultFile {
    /// The cameras of a rig where they were found to be; those that the result does not name as they are.
    pub fn rig(&self, calibrated: &Rig) -> Rig {
        let offset = |name: &str| {
            let of_camera = self.quality.cameras.iter().find(|c| c.camera == name);
            of_camera.map_or(CameraOffset::none(), |c| c.found.offset())
        };
        CameraOffset::applied(calibrated, calibrated.names().map(offset))
    }

    /// Reads the `result.json` of a folder, and checks that it and `joints.trc` are as they were written together. Where
    /// `joints.trc` was removed, that is no fault.
    ///
    /// # Errors
    /// [`ResultError`] of everything but the body.
    pub fn read(folder: &Path) -> Result<Self, ResultError> {
        let path = || folder.join(RESULT);
        let bytes = input::read(&path(), MOST_OF_A_TABLE)
            .map_err(|source| ResultError::Read { path: path(), source })?;
        let syntax = |source| ResultError::Syntax { path: path(), source };

        // what it says that it is
        let head: Head = serde_json::from_slice(&bytes).map_err(syntax)?;
        if head.format != FORMAT {
            return Err(ResultError::Format { path: path(), found: shortened(&head.format) });
        }
        if head.version != VERSION {
            return Err(ResultError::Version { path: path(), found: head.version });
        }
        if !seal::is_whole(&bytes) {
            return Err(ResultError::Changed { path: path() });
        }
        check_joints(&folder.join(JOINTS), &head.joints_blake3)?;

        // what it holds
        let result: Self = serde_json::from_slice(&bytes).map_err(syntax)?;
        match check::odd_field(&result) {
            Some(OddField { field, expected }) => {
                Err(ResultError::Field { path: path(), field, expected })
            }
            None => Ok(result),
        }
    }

    /// The body that was fitted, in as much detail as the result has, if the result is of this model.
    ///
    /// # Errors
    /// [`ResultError::Body`] if the coefficients or angles of the model have other names.
    pub fn body_of(&self, model: &BodyModel) -> Result<BodyModel, ResultError> {
        let has_more = self.shape.coefficients.len() > model.coefficients.len();
        let body = if has_more { model.detailed() } else { model.clone() };
        self.check_body(&body)?;
        Ok(body)
    }

    /// s of the coefficients that a model has, if the result is of this model.
    ///
    /// # Errors
    /// [`ResultError::Body`] if the coefficients or angles of the model have other names.
    pub fn shape_of(&self, model: &BodyModel) -> Result<Shape, ResultError> {
        if self.check_body(model).is_err() {
            self.check_body(&model.detailed())?;
        }
        let values = self.shape.coefficients.iter().map(|c| c.value);
        let values: Vec<f64> = values.take(model.coefficients.len()).collect();
        Ok(Shape(DVector::from_vec(values)))
    }

    fn check_body(&self, model: &BodyModel) -> Result<(), ResultError> {
        let coefficients = &self.shape.coefficients;
        let names = coefficients.iter().map(|c| c.name.as_str());
        let expected = model.coefficients.iter().map(String::as_str);
        if !names.eq(expected) {
            let [expected, found] = [coefficients.len(), model.coefficients.len()];
            return Err(self.other_body(model, "shape coefficients", expected, found));
        }
        let angles = self.motion.angles.iter().map(String::as_str);
        let joints = model.joints.iter().map(|j| j.name.as_str());
        let whole = |frame: &FramePart| frame.angles_rad.len() == model.joints.len();
        if !angles.eq(joints) || !self.motion.frames.iter().all(whole) {
            let [expected, found] = [self.motion.angles.len(), model.joints.len()];
            return Err(self.other_body(model, "angles", expected, found));
        }
        Ok(())
    }

    fn other_body(
        &self,
        model: &BodyModel,
        kind: &'static str,
        expected: usize,
        found: usize,
    ) -> ResultError {
        ResultError::Body {
            body: self.body.clone(),
            found_body: model.name.clone(),
            kind,
            expected,
            found,
        }
    }
}

impl FramePart {
    /// mᵢ.
    pub fn motion(&self) -> Motion {
        Motion {
            position_world: Vector3::from(self.position_m),
            world_from_root: Rotation3::from_scaled_axis(Vector3::from(self.rotation_rad)),
            angles: DVector::from_column_slice(&self.angles_rad),
        }
    }
}
