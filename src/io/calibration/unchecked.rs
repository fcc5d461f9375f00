//! Numbers as found in a file, and their way to a [`Rig`]: every check and conversion that all formats share.

use super::{CalibrationError, CalibrationOptions, Place, Poses, Unit};
use crate::camera::{Camera, Distortion, Intrinsics, Rig};
use crate::math::Rigid3;
use nalgebra::{Matrix3, Rotation3, Translation3, UnitQuaternion, Vector3};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// Largest |RᵀR − I| of a rotation matrix; one written with three decimals stays below.
const ROTATION_DEFECT: f64 = 2e-3;
/// Images are no wider or higher.
const LARGEST_SIZE: f64 = 65535.0;

/// Numbers with the place they came from.
#[derive(Debug, Clone)]
pub(super) struct Numbers {
    pub(super) path: PathBuf,
    pub(super) line: usize,
    pub(super) key: String,
    pub(super) values: Vec<f64>,
}

impl Numbers {
    pub(super) fn new(path: &Path, line: usize, key: &str, values: Vec<f64>) -> Self {
        Self { path: path.into(), line, key: key.into(), values }
    }

    pub(super) fn place(&self, camera: &str) -> Place {
        Place::new(&self.path, Some(self.line), Some(camera))
    }

    /// Exactly `N` finite numbers.
    pub(super) fn exactly<const N: usize>(
        &self,
        expected: &'static str,
        camera: &str,
    ) -> Result<[f64; N], CalibrationError> {
        let values = self.finite(camera)?;
        <[f64; N]>::try_from(values).map_err(|_| self.count(expected, camera))
    }

    fn finite(&self, camera: &str) -> Result<&[f64], CalibrationError> {
        match self.values.iter().find(|value| !value.is_finite()) {
            None => Ok(&self.values),
            Some(&found) => Err(CalibrationError::NotFinite {
                place: self.place(camera),
                key: self.key.clone(),
                found,
            }),
        }
    }

    fn count(&self, expected: &'static str, camera: &str) -> CalibrationError {
        CalibrationError::Count {
            place: self.place(camera),
            key: self.key.clone(),
            expected,
            found: self.values.len(),
        }
    }
}

/// How large the image is.
#[derive(Debug, Clone)]
pub(super) enum Size {
    /// As the file says, [width, height].
    Stated(Numbers),
    /// The file states the size of the sensor, the middle of which may have been recorded.
    Sensor(Numbers),
    /// The file does not say.
    Unstated,
}

/// A lens as the file describes it.
#[derive(Debug, Clone)]
pub(super) enum Lens {
    /// OpenCV's standard coefficients.
    BrownConrady(Numbers),
    /// OpenCV's fisheye coefficients.
    Fisheye(Numbers),
    /// Centre and three coefficients of [`Distortion::RadialCorrection`].
    RadialCorrection(Numbers),
}

/// One camera as found in a file.
#[derive(Debug, Clone)]
pub(super) struct UncheckedCamera {
    pub(super) name: String,
    pub(super) path: PathBuf,
    pub(super) line: usize,
    pub(super) size: Size,
    /// K, row by row.
    pub(super) matrix: Numbers,
    pub(super) lens: Lens,
    /// `camera_from_world`, or what [`CalibrationOptions::pose_form`] says: Rodrigues vector, or matrix row by row; no numbers where the file has
    /// none.
    pub(super) rotation: Numbers,
    /// The same, in the file's unit.
    pub(super) translation: Numbers,
    /// The format's own unit.
    pub(super) unit: Unit,
}

/// The checked rig, in metres with Z up.
pub(super) fn check(
    path: &Path,
    cameras: &[UncheckedCamera],
    options: &CalibrationOptions,
) -> Result<Rig, CalibrationError> {
    if cameras.is_empty() {
        return Err(CalibrationError::NoCameras { path: path.into() });
    }
    let mut names = BTreeSet::new();
    for camera in cameras {
        if !names.insert(camera.name.as_str()) {
            return Err(CalibrationError::Duplicate { place: camera.place() });
        }
    }
    let cameras: Result<_, _> = cameras.iter().map(|camera| camera.check(options)).collect();
    Ok(Rig { cameras: cameras? })
}

impl UncheckedCamera {
    fn place(&self) -> Place {
        Place::new(&self.path, Some(self.line), Some(&self.name))
    }

    fn check(&self, options: &CalibrationOptions) -> Result<Camera, CalibrationError> {
        let ([width_px, height_px], crop_px) = self.image_size(options)?;
        let mut intrinsics = self.intrinsics()?;
        intrinsics.cx_px -= crop_px[0];
        intrinsics.cy_px -= crop_px[1];
        Ok(Camera {
            name: self.name.clone(),
            width_px,
            height_px,
            intrinsics,
            distortion: self.distortion()?,
            camera_from_world: self.pose(options)?,
        })
    }

    /// The image's size, and what was cut off the sensor on the left and at the top.
    fn image_size(
        &self,
        options: &CalibrationOptions,
    ) -> Result<([u32; 2], [f64; 2]), CalibrationError> {
        let given = options.image_sizes_px.get(&self.name).copied();
        match (&self.size, given) {
            (Size::Stated(size), _) | (Size::Sensor(size), None) => {
                Ok((self.whole_size(size)?, [0.0; 2]))
            }
            (Size::Sensor(sensor), Some(image)) => {
                let sensor = self.whole_size(sensor)?;
                Ok((image, self.crop(image, sensor)?))
            }
            (Size::Unstated, Some(image)) => Ok((image, [0.0; 2])),
            (Size::Unstated, None) => Err(CalibrationError::MissingSize { place: self.place() }),
        }
    }

    /// What is cut off on the left and at the top when the middle of the sensor is recorded.
    fn crop(&self, image: [u32; 2], sensor: [u32; 2]) -> Result<[f64; 2], CalibrationError> {
        if image[0] > sensor[0] || image[1] > sensor[1] {
            return Err(CalibrationError::LargerThanSensor { place: self.place(), image, sensor });
        }
        Ok([0, 1].map(|i| 0.5 * f64::from(sensor[i] - image[i])))
    }

    /// Width and height rounded to whole pixels: some tools write twice the principal point.
    fn whole_size(&self, size: &Numbers) -> Result<[u32; 2], CalibrationError> {
        let [width, height] = size.exactly::<2>("2", &self.name)?.map(f64::round);
        let whole = |x: f64| (1.0..=LARGEST_SIZE).contains(&x).then(|| to_pixels(x));
        match (whole(width), whole(height)) {
            (Some(width), Some(height)) => Ok([width, height]),
            _ => Err(CalibrationError::Size { place: size.place(&self.name), width, height }),
        }
    }

    fn intrinsics(&self) -> Result<Intrinsics, CalibrationError> {
        let [fx_px, skew_px, cx_px, k21, fy_px, cy_px, k31, k32, k33] =
            self.matrix.exactly::<9>("9", &self.name)?;
        if let Some(focal_px) = [fx_px, fy_px].into_iter().find(|&f| f <= 0.0) {
            return Err(CalibrationError::Focal { place: self.matrix.place(&self.name), focal_px });
        }

        // these entries are 0 in a camera matrix, and the last is 1
        let defects = [(k21, k21), (k31, k31), (k32, k32), (k33 - 1.0, k33)];
        if let Some((_, found)) = defects.into_iter().find(|(defect, _)| defect.abs() > 1e-9) {
            return Err(CalibrationError::Intrinsics {
                place: self.matrix.place(&self.name),
                key: self.matrix.key.clone(),
                found,
            });
        }

        Ok(Intrinsics { fx_px, fy_px, cx_px, cy_px, skew_px })
    }

    fn distortion(&self) -> Result<Distortion, CalibrationError> {
        match &self.lens {
            Lens::BrownConrady(numbers) => Distortion::brown_conrady(numbers.finite(&self.name)?)
                .ok_or_else(|| numbers.count("0, 4, 5 or 8", &self.name)),
            Lens::Fisheye(numbers) => Distortion::fisheye(numbers.finite(&self.name)?)
                .ok_or_else(|| numbers.count("4", &self.name)),
            Lens::RadialCorrection(numbers) => {
                let [centre_x, centre_y, k1, k2, k3] = numbers.exactly::<5>("5", &self.name)?;
                Ok(Distortion::RadialCorrection { centre_x, centre_y, k1, k2, k3 })
            }
        }
    }

    fn pose(&self, options: &CalibrationOptions) -> Result<Rigid3, CalibrationError> {
        if options.poses == Poses::Ignored {
            return Ok(Rigid3::identity());
        }
        let lacking: Vec<&Numbers> = [&self.rotation, &self.translation]
            .into_iter()
            .filter(|n| n.values.is_empty())
            .collect();
        match lacking.as_slice() {
            [] => {}
            [one] => {
                let (place, key) = (self.place(), one.key.clone());
                return Err(CalibrationError::MissingKey { place, key });
            }
            _ => return Err(CalibrationError::NoPose { place: self.place() }),
        }
        let rotation = self.rotation(&self.rotation)?;
        let translation = Vector3::from(self.translation.exactly::<3>("3", &self.name)?);
        let metres = options.unit.unwrap_or(self.unit).in_metres();
        let written = Rigid3::from_parts(Translation3::from(translation * metres), rotation);
        let camera_from_file = options.pose_form.camera_from_file(&written);
        Ok(camera_from_file * options.up.file_from_world())
    }

    /// From a Rodrigues vector, or from a matrix, which is brought to the nearest rotation.
    fn rotation(&self, numbers: &Numbers) -> Result<UnitQuaternion<f64>, CalibrationError> {
        if numbers.values.len() == 3 {
            let vector = numbers.exactly::<3>("3 or 9", &self.name)?;
            return Ok(UnitQuaternion::from_scaled_axis(Vector3::from(vector)));
        }
        let matrix = Matrix3::from_row_slice(&numbers.exactly::<9>("3 or 9", &self.name)?);
        let defect = (matrix.transpose() * matrix - Matrix3::identity()).norm();
        // written so that an overflow to NaN is an error
        if defect <= ROTATION_DEFECT {
            self.nearest_rotation(&matrix)
        } else {
            Err(defect_of(numbers, &self.name, defect))
        }
    }

    fn nearest_rotation(
        &self,
        matrix: &Matrix3<f64>,
    ) -> Result<UnitQuaternion<f64>, CalibrationError> {
        if matrix.determinant() < 0.0 {
            return Err(CalibrationError::Reflection {
                place: self.rotation.place(&self.name),
                key: self.rotation.key.clone(),
            });
        }
        // the orthogonal factor UVᵀ of R = UΣVᵀ is the rotation nearest to R
        let svd = matrix.svd(true, true);
        let rotation = svd.u.zip(svd.v_t).map_or(*matrix, |(u, v_t)| u * v_t);
        let rotation = Rotation3::from_matrix_unchecked(rotation);
        Ok(UnitQuaternion::from_rotation_matrix(&rotation))
    }
}

/// A rotation that is none.
pub(super) fn defect_of(numbers: &Numbers, camera: &str, defect: f64) -> CalibrationError {
    CalibrationError::Rotation { place: numbers.place(camera), key: numbers.key.clone(), defect }
}

/// A whole number of pixels, known to lie between 1 and [`LARGEST_SIZE`].
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "the range was checked")]
fn to_pixels(x: f64) -> u32 {
    x as u32
}
