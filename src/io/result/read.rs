//! Reading a result back: the body as it was fitted.

use std::path::{Path, PathBuf};

use nalgebra::{DVector, Rotation3, Vector2, Vector3};

use super::{FramePart, ResultFile};
use crate::body::{BodyModel, Motion, Shape};
use crate::camera::Rig;

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
    /// The pointing errors of a rig's cameras, see [`Rig::aimed`]; 0 for a camera that the result does not name.
    pub fn aims_px(&self, rig: &Rig) -> Vec<Vector2<f64>> {
        let aim = |name: &str| {
            let of_camera = self.quality.cameras.iter().find(|c| c.camera == name);
            of_camera.map_or(Vector2::zeros(), |c| c.aim_px)
        };
        rig.names().map(aim).collect()
    }

    /// Reads the `result.json` of a folder.
    ///
    /// # Errors
    /// [`ResultError::Read`] and [`ResultError::Syntax`].
    pub fn read(folder: &Path) -> Result<Self, ResultError> {
        let path = folder.join("result.json");
        match std::fs::read(&path) {
            Ok(bytes) => {
                let parsed = serde_json::from_slice(&bytes);
                parsed.map_err(|source| ResultError::Syntax { path, source })
            }
            Err(source) => Err(ResultError::Read { path, source }),
        }
    }

    /// s, if the result is of this model.
    ///
    /// # Errors
    /// [`ResultError::Body`] if the coefficients or angles of the model have other names.
    pub fn shape_of(&self, model: &BodyModel) -> Result<Shape, ResultError> {
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
        let values = coefficients.iter().map(|c| c.value);
        Ok(Shape(DVector::from_iterator(coefficients.len(), values)))
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
