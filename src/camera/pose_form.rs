//! How a file writes where a camera stands.

use std::f64::consts::PI;
use std::fmt;

use nalgebra::{Translation3, Vector3};
use serde::{Deserialize, Serialize};

use crate::math::Rigid3;

/// What R and t of a calibration mean, x a place in its world and y the same place in the frame of the camera (x right, y down, z forward).
///
/// In OpenGL and Blender a camera has y up and looks along −z; D = diag(1, −1, −1) turns its frame to ours.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum PoseForm {
    /// y = R x + t, as in OpenCV, and here.
    #[default]
    WorldToCamera,
    /// x = R y + t: where the camera stands and how it is turned.
    CameraToWorld,
    /// y = R (x − t): t is where the camera stands.
    RotationAndCentre,
    /// y = Rᵀ x + t: the rotation was written column by column.
    RotationTransposed,
    /// x = R D y + t, as Blender's `matrix_world`.
    BlenderToWorld,
    /// y = D (R x + t), as OpenGL's view matrix.
    WorldToOpengl,
}

impl PoseForm {
    /// Every form.
    pub const ALL: [Self; 6] = [
        Self::WorldToCamera,
        Self::CameraToWorld,
        Self::RotationAndCentre,
        Self::RotationTransposed,
        Self::BlenderToWorld,
        Self::WorldToOpengl,
    ];

    /// The pose of a camera of which a file writes (R, t).
    pub fn camera_from_file(self, written: &Rigid3) -> Rigid3 {
        let (rotation, translation) = (written.rotation, written.translation.vector);
        let ours_from_opengl = Rigid3::rotation(Vector3::x() * PI);
        match self {
            Self::WorldToCamera => *written,
            Self::CameraToWorld => written.inverse(),
            Self::RotationAndCentre => {
                Rigid3::from_parts(Translation3::from(rotation * -translation), rotation)
            }
            Self::RotationTransposed => Rigid3::from_parts(written.translation, rotation.inverse()),
            Self::BlenderToWorld => ours_from_opengl * written.inverse(),
            Self::WorldToOpengl => ours_from_opengl * written,
        }
    }

    /// What a file with this form means.
    pub fn formula(self) -> &'static str {
        match self {
            Self::WorldToCamera => "R x + t is in the camera's frame",
            Self::CameraToWorld => "R and t are from the camera to the world",
            Self::RotationAndCentre => "t is where the camera stands",
            Self::RotationTransposed => "R is transposed",
            Self::BlenderToWorld => {
                "R and t are from the camera to the world, and it looks along -z"
            }
            Self::WorldToOpengl => "the camera looks along -z",
        }
    }
}

impl fmt::Display for PoseForm {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::WorldToCamera => "world-to-camera",
            Self::CameraToWorld => "camera-to-world",
            Self::RotationAndCentre => "rotation-and-centre",
            Self::RotationTransposed => "rotation-transposed",
            Self::BlenderToWorld => "blender-to-world",
            Self::WorldToOpengl => "world-to-opengl",
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Matrix3, Point3};

    /// y of a place by each formula, with matrices.
    fn by_matrices(form: PoseForm, written: &Rigid3, x: &Point3<f64>) -> Vector3<f64> {
        let r = written.rotation.to_rotation_matrix().into_inner();
        let t = written.translation.vector;
        let d = Matrix3::from_diagonal(&Vector3::new(1.0, -1.0, -1.0));
        match form {
            PoseForm::WorldToCamera => r * x.coords + t,
            PoseForm::CameraToWorld => r.transpose() * (x.coords - t),
            PoseForm::RotationAndCentre => r * (x.coords - t),
            PoseForm::RotationTransposed => r.transpose() * x.coords + t,
            PoseForm::BlenderToWorld => (r * d).transpose() * (x.coords - t),
            PoseForm::WorldToOpengl => d * (r * x.coords + t),
        }
    }

    #[test]
    fn each_form_takes_places_to_the_frame_of_the_camera_by_its_formula() {
        let written = Rigid3::new(Vector3::new(0.3, -1.2, 4.0), Vector3::new(1.1, 0.4, -0.7));
        let x = Point3::new(0.5, 2.0, 1.1);
        for form in PoseForm::ALL {
            let y = form.camera_from_file(&written) * x;
            approx::assert_relative_eq!(y.coords, by_matrices(form, &written, &x), epsilon = 1e-12);
        }
    }

    #[test]
    fn forms_are_called_as_they_are_shown() {
        for form in PoseForm::ALL {
            assert_eq!(serde_json::to_value(form).expect("a name"), form.to_string());
        }
    }
}
