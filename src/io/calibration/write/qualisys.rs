//! Qualisys' `.qca.txt`; see the reader in `qualisys.rs` for units, axes and what is left out.

use std::fmt::Write;
use std::path::Path;

use super::CalibrationWriteError;
use crate::camera::{Camera, Distortion, Rig};
use crate::io::calibration::Unit;

/// Subpixels in a pixel.
const SUBPIXELS: f64 = 64.0;

/// The cameras, by serial number.
pub(super) fn text(rig: &Rig, path: &Path) -> Result<String, CalibrationWriteError> {
    let mut text = String::from(
        "<?xml version='1.0' encoding='UTF-8'?>\n<calibration type=\"regular\">\n  <cameras>\n",
    );
    for camera in &rig.cameras {
        let lens = lens(camera, path)?;
        // writing to a String cannot fail
        let _ = section(camera, lens, &mut text);
    }
    Ok(text + "  </cameras>\n</calibration>\n")
}

/// k₁ k₂ p₁ p₂ k₃.
fn lens(camera: &Camera, path: &Path) -> Result<[f64; 5], CalibrationWriteError> {
    let cannot =
        |lens| CalibrationWriteError::Lens { path: path.into(), camera: camera.name.clone(), lens };
    match camera.distortion {
        Distortion::None => Ok([0.0; 5]),
        Distortion::BrownConrady { k1, k2, p1, p2, k3, k4, k5, k6 } => {
            let is_rational = [k4, k5, k6].iter().any(|k| k.abs() > 0.0);
            match is_rational {
                true => Err(cannot("a rational lens (k4 k5 k6)")),
                false => Ok([k1, k2, p1, p2, k3]),
            }
        }
        Distortion::Fisheye { .. } => Err(cannot("a fisheye")),
        Distortion::RadialCorrection { .. } => Err(cannot("a lens that corrects")),
    }
}

fn section(camera: &Camera, lens: [f64; 5], text: &mut String) -> std::fmt::Result {
    let k = &camera.intrinsics;
    let [k1, k2, p1, p2, k3] = lens;
    writeln!(
        text,
        "    <camera active=\"1\" model=\"none\" serial=\"{}\" viewrotation=\"0\">\n      \
         <fov_video left=\"0\" top=\"0\" right=\"{}\" bottom=\"{}\"/>",
        escaped(&camera.name),
        camera.width_px - 1,
        camera.height_px - 1,
    )?;

    // Qualisys' camera looks along its −z with y up: R = diag(1, −1, −1)·(r11 … r33)
    let rotation = camera.camera_from_world.rotation.to_rotation_matrix();
    write!(text, "      <transform")?;
    for (i, row) in rotation.matrix().row_iter().enumerate() {
        let sign = if i == 0 { 1.0 } else { -1.0 };
        for (j, value) in row.iter().enumerate() {
            write!(text, " r{}{}=\"{:?}\"", i + 1, j + 1, sign * value)?;
        }
    }
    let centre = camera.centre_world() / Unit::Millimetre.in_metres();
    writeln!(text, " x=\"{:?}\" y=\"{:?}\" z=\"{:?}\"/>", centre.x, centre.y, centre.z)?;

    let [fx, fy, cx, cy, skew] =
        [k.fx_px, k.fy_px, k.cx_px, k.cy_px, k.skew_px].map(|value| SUBPIXELS * value);
    writeln!(
        text,
        "      <intrinsic focalLengthU=\"{fx:?}\" focalLengthV=\"{fy:?}\" centerPointU=\"{cx:?}\" centerPointV=\"{cy:?}\" \
         skew=\"{skew:?}\" radialDistortion1=\"{k1:?}\" radialDistortion2=\"{k2:?}\" radialDistortion3=\"{k3:?}\" \
         tangentalDistortion1=\"{p1:?}\" tangentalDistortion2=\"{p2:?}\"/>\n    </camera>"
    )
}

/// A text within quotation marks of XML.
fn escaped(text: &str) -> String {
    let escape = |c: char| match c {
        '&' => "&amp;".into(),
        '<' => "&lt;".into(),
        '"' => "&quot;".into(),
        c if c.is_control() => format!("&#{};", u32::from(c)),
        c => c.to_string(),
    };
    text.chars().map(escape).collect()
}
