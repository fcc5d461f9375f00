//! Qualisys' `.qca.txt`, an XML file.
//!
//! Intrinsics are in 1/64 pixel. `x y z` is the camera's position in millimetres; r11 … r33 are stored column by column
//! as camera-to-world, so read row by row they are world-to-camera. The camera looks along its −z with y up: half a
//! turn about x makes that the frame used here.
//!
//! **Differs** from Pose2Sim's reader in the distortion coefficients, which that one divides by 64 like the focal
//! length. They are taken as they stand: 1/64 pixel is a unit of *length in the image*, and the coefficients act on
//! normalised coordinates, which have none: no choice of pixel changes them. The size agrees: k₁ = −0.046, k₂ = 0.14 of
//! Pose2Sim's demo file move the far corner of the image by 8 pixels, as such lenses do; divided by 64, by an eighth
//! of a pixel, which nobody would calibrate.

use super::{
    CalibrationError, Unit,
    natural_order::natural,
    unchecked::{Lens, Size, UncheckedCamera},
    xml::{Element, document},
};
use std::path::Path;

const SUBPIXELS: f64 = 64.0;

/// The video cameras of a Qualisys calibration, sorted by serial number.
pub(super) fn parse(path: &Path, text: &str) -> Result<Vec<UncheckedCamera>, CalibrationError> {
    let document = document(path, text)?;
    let mut cameras = document
        .descendants()
        .filter(|node| node.has_tag_name("camera"))
        .map(|node| Element {
            path,
            camera: node.attribute("serial").unwrap_or("without serial"),
            node,
        })
        .filter(is_used)
        .map(|element| camera(&element))
        .collect::<Result<Vec<_>, _>>()?;
    cameras.sort_by(|a, b| natural(&a.name, &b.name));
    Ok(cameras)
}

/// Calibrated, active, and a camera that records video.
fn is_used(camera: &Element<'_, '_>) -> bool {
    let attribute = |key: &str| camera.node.attribute(key).unwrap_or("").to_lowercase();
    let model = attribute("model");
    let records = ["video", "hybrid", "none"];
    attribute("active") != "0"
        && attribute("calibrated") != "false"
        && (model.is_empty() || records.iter().any(|kind| model.contains(kind)))
}

fn camera(camera: &Element<'_, '_>) -> Result<UncheckedCamera, CalibrationError> {
    let [fov, intrinsic, transform] =
        ["fov_video", "intrinsic", "transform"].map(|name| camera.child(name));
    let (fov, intrinsic, transform) = (fov?, intrinsic?, transform?);

    let (left, top) = (fov.number("left")?, fov.number("top")?);
    let size = vec![fov.number("right")? - left + 1.0, fov.number("bottom")? - top + 1.0];

    let pixels = |key: &str| intrinsic.number(key).map(|value| value / SUBPIXELS);
    let matrix = vec![
        pixels("focalLengthU")?,
        if intrinsic.node.has_attribute("skew") { pixels("skew")? } else { 0.0 },
        pixels("centerPointU")? - left,
        0.0,
        pixels("focalLengthV")?,
        pixels("centerPointV")? - top,
        0.0,
        0.0,
        1.0,
    ];

    let (rotation, translation) = pose(&transform)?;
    Ok(UncheckedCamera {
        name: camera.text("serial")?.into(),
        path: camera.path.into(),
        line: camera.line(),
        size: Size::Stated(fov.computed("fov_video", size)),
        matrix: intrinsic.computed("intrinsic", matrix),
        lens: Lens::BrownConrady(intrinsic.collect("distortion", &DISTORTION)?),
        rotation: transform.computed("r11 … r33", rotation),
        translation: transform.computed("x y z", translation),
        unit: Unit::Millimetre,
    })
}

/// In OpenCV's order; the spelling is Qualisys'.
const DISTORTION: [&str; 5] = [
    "radialDistortion1",
    "radialDistortion2",
    "tangentalDistortion1",
    "tangentalDistortion2",
    "radialDistortion3",
];

/// R = diag(1, −1, −1)·(r11 … r33) row by row, t = −R·(x y z).
fn pose(transform: &Element<'_, '_>) -> Result<(Vec<f64>, Vec<f64>), CalibrationError> {
    let centre =
        transform.collect("x y z", &["x", "y", "z"])?.exactly::<3>("3", transform.camera)?;
    let keys = ["r11", "r12", "r13", "r21", "r22", "r23", "r31", "r32", "r33"];
    let mut rotation = transform.collect("r11 … r33", &keys)?.values;
    for value in rotation.iter_mut().skip(3) {
        *value = -*value;
    }
    let dot = |row: &[f64]| row.iter().zip(&centre).map(|(r, c)| r * c).sum::<f64>();
    let translation = rotation.chunks(3).map(|row| -dot(row)).collect();
    Ok((rotation, translation))
}
