//! Vicon's `.xcp`, an XML file.
//!
//! POSITION is the camera's centre in millimetres. ORIENTATION is a quaternion x y z w, scalar last, that turns world
//! axes to camera axes (x right, y down, z forward): `camera_from_world` is R(q)·(X − position); the readers of OpenCap
//! and Pose2Sim agree. f_v = FOCAL_LENGTH/PIXEL_ASPECT_RATIO. PRINCIPAL_POINT counts on the whole sensor.
//!
//! The lens corrects: with w = (u − c_u, a·(v − c_v)) in **pixels** of the distorted image and ρ = |w|, the undistorted
//! image is at c + w·(1 + k₁ρ² + k₂ρ⁴ + k₃ρ⁶); `VICON_RADIAL2="ViconRadial2 c_u c_v k₁ k₂ k₃"` also gives the centre,
//! `VICON_RADIAL="k₁ k₂"` has the principal point there. On normalised coordinates the coefficients are multiplied by
//! f², f⁴, f⁶, as Vicon's own plug-in for Unreal does with them; the direction is that of the reader in Imaginarium's
//! GRIP. No file with known truth was at hand to confirm either.
//!
//! **Differs** from the readers of OpenCap and Pose2Sim, which hand the tokens to OpenCV as they stand, where a k₁ of some
//! 1e-8 per square pixel does nothing. Coefficients so large that in pixels they would bend the corner of the image
//! beyond all lenses are taken as those readers take them, as OpenCV's k₁, k₂, k₃.

use super::{
    CalibrationError, Unit,
    natural_order::natural,
    unchecked::{Lens, Size, UncheckedCamera, defect_of},
    xml::{Element, document},
};
use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use std::path::Path;

/// Largest | |q| − 1 | of an orientation.
const QUATERNION_DEFECT: f64 = 1e-3;
/// No lens moves a corner by more than twice its distance from the centre.
const LARGEST_BEND: f64 = 2.0;

/// The calibrated cameras of an `.xcp` file, sorted by device number; only video cameras if it says which these are.
pub(super) fn parse(path: &Path, text: &str) -> Result<Vec<UncheckedCamera>, CalibrationError> {
    let document = document(path, text)?;
    let elements: Vec<Element<'_, '_>> = document
        .descendants()
        .filter(|node| node.has_tag_name("Camera"))
        .map(|node| Element {
            path,
            camera: node.attribute("DEVICEID").unwrap_or("without DEVICEID"),
            node,
        })
        .filter(|camera| !key_frames(camera).is_empty())
        .collect();

    // where some cameras record video, the others see only markers
    let any_video = elements.iter().any(records_video);
    let mut cameras = elements
        .iter()
        .filter(|camera| !any_video || records_video(camera))
        .map(camera)
        .collect::<Result<Vec<_>, _>>()?;

    cameras.sort_by(|a, b| natural(&a.name, &b.name));
    Ok(cameras)
}

fn records_video(camera: &Element<'_, '_>) -> bool {
    ["TYPE", "DISPLAY_TYPE"].iter().any(|key| {
        let kind = camera.node.attribute(*key).unwrap_or("").to_lowercase();
        kind.contains("video") || kind.contains("vue")
    })
}

fn key_frames<'a, 'i>(camera: &Element<'a, 'i>) -> Vec<Element<'a, 'i>> {
    camera
        .node
        .descendants()
        .filter(|node| node.has_tag_name("KeyFrame"))
        .map(|node| Element { node, ..*camera })
        .collect()
}

fn camera(camera: &Element<'_, '_>) -> Result<UncheckedCamera, CalibrationError> {
    let frames = key_frames(camera);
    let [frame] = frames.as_slice() else {
        return Err(CalibrationError::MovingCamera {
            place: camera.place(),
            key_frames: frames.len(),
        });
    };

    let aspect = match camera.node.attribute("PIXEL_ASPECT_RATIO") {
        Some(_) => camera.number("PIXEL_ASPECT_RATIO")?,
        None => 1.0,
    };

    let focal = frame.number("FOCAL_LENGTH")?;
    let [cu, cv] = frame.numbers("PRINCIPAL_POINT")?.exactly::<2>("2", camera.camera)?;
    let matrix = vec![focal, 0.0, cu, 0.0, focal / aspect, cv, 0.0, 0.0, 1.0];

    let size = match camera.node.attribute("SENSOR_SIZE") {
        Some(_) => Size::Sensor(camera.numbers("SENSOR_SIZE")?),
        None => Size::Unstated,
    };

    let (rotation, translation) = pose(frame)?;
    Ok(UncheckedCamera {
        name: camera.text("DEVICEID")?.into(),
        path: camera.path.into(),
        line: camera.line(),
        size,
        lens: lens(frame, &Sensor { focal, aspect, principal: [cu, cv] })?,
        matrix: frame.computed("FOCAL_LENGTH", matrix),
        rotation: frame.computed("ORIENTATION", rotation),
        translation: frame.computed("POSITION", translation),
        unit: Unit::Millimetre,
    })
}

/// R(q), and t = −R·position.
fn pose(frame: &Element<'_, '_>) -> Result<(Vec<f64>, Vec<f64>), CalibrationError> {
    let orientation = frame.numbers("ORIENTATION")?;
    let [x, y, z, w] = orientation.exactly::<4>("4", frame.camera)?;
    let quaternion = Quaternion::new(w, x, y, z);
    let defect = (quaternion.norm() - 1.0).abs();
    if defect > QUATERNION_DEFECT {
        return Err(defect_of(&orientation, frame.camera, defect));
    }
    let rotation = UnitQuaternion::from_quaternion(quaternion);
    let centre = frame.numbers("POSITION")?.exactly::<3>("3", frame.camera)?;
    let translation = -(rotation * Vector3::from(centre));
    let by_rows = rotation.to_rotation_matrix().matrix().transpose();
    Ok((by_rows.as_slice().into(), translation.as_slice().into()))
}

/// What makes pixels of normalised coordinates.
struct Sensor {
    focal: f64,
    aspect: f64,
    principal: [f64; 2],
}

impl Sensor {
    /// Squared distance from the principal point to the farthest corner of a sensor centred on it, in pixels.
    fn corner_squared(&self) -> f64 {
        let [cu, cv] = self.principal;
        cu * cu + (self.aspect * cv).powi(2)
    }
}

fn lens(frame: &Element<'_, '_>, sensor: &Sensor) -> Result<Lens, CalibrationError> {
    let (key, centre, k) = coefficients(frame, sensor)?;

    let bend = |i: usize| k[i].abs() * sensor.corner_squared().powi([1, 2, 3][i]);
    if (0..3).any(|i| bend(i) > LARGEST_BEND) {
        let opencv = vec![k[0], k[1], 0.0, 0.0, k[2]];
        return Ok(Lens::BrownConrady(frame.computed(key, opencv)));
    }

    if k.iter().all(|k| k.abs() <= 0.0) {
        return Ok(Lens::BrownConrady(frame.computed(key, Vec::new())));
    }

    let (f, f_squared) = (sensor.focal, sensor.focal.powi(2));
    let normalized = vec![
        (centre[0] - sensor.principal[0]) / f,
        (centre[1] - sensor.principal[1]) * sensor.aspect / f,
        k[0] * f_squared,
        k[1] * f_squared.powi(2),
        k[2] * f_squared.powi(3),
    ];
    Ok(Lens::RadialCorrection(frame.computed(key, normalized)))
}

/// The attribute's name, the centre in pixels, and k₁ k₂ k₃ as written.
fn coefficients(
    frame: &Element<'_, '_>,
    sensor: &Sensor,
) -> Result<(&'static str, [f64; 2], [f64; 3]), CalibrationError> {
    if let Some(text) = frame.node.attribute("VICON_RADIAL2") {
        // the first token is the model's name
        let key = "VICON_RADIAL2";
        let mut numbers = frame.parse(key, text.split_whitespace().skip(1))?;
        if numbers.values.len() == 4 {
            numbers.values.push(0.0);
        }
        let [cu, cv, k1, k2, k3] = numbers.exactly("4 or 5", frame.camera)?;
        let unset = cu.abs() + cv.abs() <= 0.0;
        let centre = if unset { sensor.principal } else { [cu, cv] };
        return Ok((key, centre, [k1, k2, k3]));
    }
    let key = "VICON_RADIAL";
    let [k1, k2] = frame.numbers(key)?.exactly("2", frame.camera)?;
    Ok((key, sensor.principal, [k1, k2, 0.0]))
}
