//! Pose2Sim's TOML, which aniposelib and caliscope read too.

use std::fmt::Write;

use super::CameraEstimate;
use crate::camera::{Camera, Distortion, Rig};
use crate::io::calibration::pose2sim::RADIAL_CORRECTION;

/// A rig as Pose2Sim's TOML, in metres; reading it back gives the same rig to rounding.
///
/// [`Distortion::RadialCorrection`] has no OpenCV coefficients: it is written as `radial_correction` = \[centre x, centre
/// y, k₁, k₂, k₃\] in place of `distortions`, so that another tool misses a key instead of misreading the lens.
pub fn write_toml(rig: &Rig) -> String {
    text(rig, 1.0, &[])
}

/// The same in a unit of so many metres; what is known of the cameras' estimates stands under `[metadata]`.
pub(super) fn text(rig: &Rig, unit_m: f64, known: &[CameraEstimate]) -> String {
    let mut text: String = rig.cameras.iter().map(|camera| section(camera, unit_m)).collect();
    if rig.by_name("metadata").is_none() {
        let _ = writeln!(text, "[metadata]\nadjusted = {}\nerror = 0.0", !known.is_empty());
        text.extend(known.iter().map(estimate));
    }
    text
}

/// A table below the metadata, which readers of calibrations pass over.
fn estimate(known: &CameraEstimate) -> String {
    match known {
        CameraEstimate::Refined(refined) => format!(
            "\n[metadata.refined.{}]\nturn_deg = {}\nturn_sd_deg = {}\ndisplacement_m = {}\ndisplacement_sd_m = {}\nzoom = {:?}\nzoom_sd = {:?}\n",
            key(&refined.camera),
            list(&refined.turn_deg),
            list(&refined.turn_sd_deg),
            list(&refined.displacement_m),
            list(&refined.displacement_sd_m),
            refined.zoom,
            refined.zoom_sd,
        ),
        CameraEstimate::Placed { camera, turn_sd_deg, place_sd_m } => format!(
            "\n[metadata.placed.{}]\nturn_sd_deg = {turn_sd_deg:?}\nplace_sd_m = {place_sd_m:?}\n",
            key(camera),
        ),
    }
}

fn section(camera: &Camera, unit_m: f64) -> String {
    let (key, name) = (key(&camera.name), quoted(&camera.name));

    let k = camera.intrinsics.matrix();
    let row = |i: usize| list(&[k[(i, 0)], k[(i, 1)], k[(i, 2)]]);
    let size = list(&[camera.width_px.into(), camera.height_px.into()]);
    let pose = &camera.camera_from_world;
    let rotation = list(pose.rotation.scaled_axis().as_slice());
    let translation = list((pose.translation.vector / unit_m).as_slice());

    format!(
        "[{key}]\nname = {name}\nsize = {size}\nmatrix = [ {}, {}, {}]\n{}\nrotation = {rotation}\n\
         translation = {translation}\nfisheye = {}\n\n",
        row(0),
        row(1),
        row(2),
        lens(&camera.distortion),
        matches!(camera.distortion, Distortion::Fisheye { .. }),
    )
}

/// As many coefficients as are needed: 4, 5 or 8.
fn lens(distortion: &Distortion) -> String {
    let coefficients = match *distortion {
        Distortion::None => vec![0.0; 4],
        Distortion::BrownConrady { k1, k2, p1, p2, k3, k4, k5, k6 } => {
            let all = [k1, k2, p1, p2, k3, k4, k5, k6];

            // OpenCV reads 4, 5 or 8 coefficients
            let used = all.iter().rposition(|k| k.abs() > 0.0).map_or(0, |i| i + 1);
            let length = [4, 5, 8].into_iter().find(|&n| n >= used).unwrap_or(8);
            all[..length].to_vec()
        }
        Distortion::Fisheye { k1, k2, k3, k4 } => vec![k1, k2, k3, k4],
        Distortion::RadialCorrection { centre_x, centre_y, k1, k2, k3 } => {
            let values = list(&[centre_x, centre_y, k1, k2, k3]);
            return format!("{RADIAL_CORRECTION} = {values}");
        }
    };
    format!("distortions = {}", list(&coefficients))
}

fn list(values: &[f64]) -> String {
    let values: Vec<String> = values.iter().map(|value| format!("{value:?}")).collect();
    format!("[ {}]", values.join(", "))
}

/// A name as a key, bare where it may be.
fn key(name: &str) -> String {
    let is_bare = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
    match !name.is_empty() && name.chars().all(is_bare) {
        true => name.into(),
        false => quoted(name),
    }
}

/// A TOML basic string.
fn quoted(text: &str) -> String {
    let mut quoted = String::from("\"");
    for c in text.chars() {
        match c {
            '"' | '\\' => quoted.extend(['\\', c]),
            c if c.is_control() => {
                // writing to a String cannot fail
                let _ = write!(quoted, "\\u{:04X}", u32::from(c));
            }
            c => quoted.push(c),
        }
    }
    quoted.push('"');
    quoted
}
