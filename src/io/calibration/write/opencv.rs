//! OpenCV's file storage, in YAML or XML: EasyMocap's pair, one file for all cameras, or one for each.

use std::fmt::Write;
use std::path::Path;

use nalgebra::{Matrix3, Vector3};

use super::CalibrationWriteError;
use crate::camera::{Camera, Distortion, Rig};

/// How a storage is spelt.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Syntax {
    Yaml,
    Xml,
}

/// A named value.
#[derive(Debug, Clone)]
pub(super) struct Value {
    key: String,
    content: Content,
}

#[derive(Debug, Clone)]
enum Content {
    Names(Vec<String>),
    Whole(u32),
    Matrix { rows: usize, values: Vec<f64> },
}

/// Which spelling of the keys: with the camera's name behind, or OpenCV's long ones.
struct Keys<'a> {
    matrix: &'a str,
    lens: &'a str,
    fisheye: &'a str,
    size: [&'a str; 2],
    vector: &'a str,
    rotation: &'a str,
    translation: &'a str,
}

const SHORT: Keys<'static> = Keys {
    matrix: "K",
    lens: "dist",
    fisheye: "fisheye_model",
    size: ["W", "H"],
    vector: "R",
    rotation: "Rot",
    translation: "T",
};

const LONG: Keys<'static> = Keys {
    matrix: "camera_matrix",
    lens: "distortion_coefficients",
    fisheye: "fisheye_model",
    size: ["image_width", "image_height"],
    vector: "rotation_vector",
    rotation: "rotation_matrix",
    translation: "translation_vector",
};

/// All cameras in one file.
pub(super) fn values(
    rig: &Rig,
    unit_m: f64,
    path: &Path,
) -> Result<Vec<Value>, CalibrationWriteError> {
    let (mut inner, outer) = halves(rig, unit_m, path)?;
    // the names stand once
    inner.extend(outer.into_iter().skip(1));
    Ok(inner)
}

/// Lenses, and poses: EasyMocap's two files.
pub(super) fn halves(
    rig: &Rig,
    unit_m: f64,
    path: &Path,
) -> Result<(Vec<Value>, Vec<Value>), CalibrationWriteError> {
    let names = || Value {
        key: "names".into(),
        content: Content::Names(rig.names().map(Into::into).collect()),
    };
    let (mut inner, mut outer) = (vec![names()], vec![names()]);
    for camera in &rig.cameras {
        check_name(camera, path)?;
        let behind = format!("_{}", camera.name);
        inner.extend(lens(camera, &SHORT, &behind, path)?);
        outer.extend(pose(camera, &SHORT, &behind, unit_m));
    }
    Ok((inner, outer))
}

/// One camera.
pub(super) fn alone(
    camera: &Camera,
    unit_m: f64,
    path: &Path,
) -> Result<Vec<Value>, CalibrationWriteError> {
    // the name becomes a part of the file's
    check_name(camera, path)?;
    let mut values = lens(camera, &LONG, "", path)?;
    values.extend(pose(camera, &LONG, "", unit_m));
    Ok(values)
}

fn check_name(camera: &Camera, path: &Path) -> Result<(), CalibrationWriteError> {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
    match !camera.name.is_empty() && camera.name.chars().all(is_plain) {
        true => Ok(()),
        false => {
            Err(CalibrationWriteError::Name { path: path.into(), camera: camera.name.clone() })
        }
    }
}

fn matrix(key: &str, behind: &str, rows: usize, values: Vec<f64>) -> Value {
    Value { key: format!("{key}{behind}"), content: Content::Matrix { rows, values } }
}

/// Row by row.
fn square(matrix: &Matrix3<f64>) -> Vec<f64> {
    matrix.transpose().as_slice().to_vec()
}

fn lens(
    camera: &Camera,
    keys: &Keys<'_>,
    behind: &str,
    path: &Path,
) -> Result<Vec<Value>, CalibrationWriteError> {
    let (coefficients, is_fisheye) = match camera.distortion {
        Distortion::None => (vec![0.0; 5], false),
        Distortion::BrownConrady { k1, k2, p1, p2, k3, k4, k5, k6 } => {
            let rational = [k4, k5, k6].iter().any(|k| k.abs() > 0.0);
            let all = [k1, k2, p1, p2, k3, k4, k5, k6];
            (all[..if rational { 8 } else { 5 }].to_vec(), false)
        }
        Distortion::Fisheye { k1, k2, k3, k4 } => (vec![k1, k2, k3, k4], true),
        Distortion::RadialCorrection { .. } => {
            let (path, camera) = (path.into(), camera.name.clone());
            return Err(CalibrationWriteError::Lens { path, camera, lens: "a lens that corrects" });
        }
    };

    let whole = |key: &str, value: u32| Value {
        key: format!("{key}{behind}"),
        content: Content::Whole(value),
    };
    Ok(vec![
        matrix(keys.matrix, behind, 3, square(&camera.intrinsics.matrix())),
        matrix(keys.lens, behind, 1, coefficients),
        whole(keys.fisheye, u32::from(is_fisheye)),
        whole(keys.size[0], camera.width_px),
        whole(keys.size[1], camera.height_px),
    ])
}

fn pose(camera: &Camera, keys: &Keys<'_>, behind: &str, unit_m: f64) -> Vec<Value> {
    let pose = &camera.camera_from_world;
    let rotation = pose.rotation.to_rotation_matrix();
    let column = |v: Vector3<f64>| v.as_slice().to_vec();
    vec![
        matrix(keys.vector, behind, 3, column(pose.rotation.scaled_axis())),
        matrix(keys.rotation, behind, 3, square(rotation.matrix())),
        matrix(keys.translation, behind, 3, column(pose.translation.vector / unit_m)),
    ]
}

/// The text of a storage.
pub(super) fn text(syntax: Syntax, values: &[Value]) -> String {
    let (head, foot) = match syntax {
        Syntax::Yaml => ("%YAML:1.0\n---\n", ""),
        Syntax::Xml => ("<?xml version=\"1.0\"?>\n<opencv_storage>\n", "</opencv_storage>\n"),
    };
    let mut text = head.to_owned();
    for value in values {
        // writing to a String cannot fail
        let _ = match syntax {
            Syntax::Yaml => yaml(value, &mut text),
            Syntax::Xml => xml(value, &mut text),
        };
    }
    text + foot
}

/// A number that is never taken for a whole one.
fn numbers(values: &[f64], between: &str) -> String {
    let values: Vec<String> = values.iter().map(|value| format!("{value:?}")).collect();
    values.join(between)
}

fn yaml(value: &Value, text: &mut String) -> std::fmt::Result {
    let key = &value.key;
    match &value.content {
        Content::Whole(whole) => writeln!(text, "{key}: {whole}"),
        Content::Names(names) => {
            writeln!(text, "{key}:")?;
            names.iter().try_for_each(|name| writeln!(text, "  - \"{name}\""))
        }
        Content::Matrix { rows, values } => {
            let (cols, data) = (values.len() / rows, numbers(values, ", "));
            writeln!(
                text,
                "{key}: !!opencv-matrix\n  rows: {rows}\n  cols: {cols}\n  dt: d\n  data: [ {data} ]"
            )
        }
    }
}

fn xml(value: &Value, text: &mut String) -> std::fmt::Result {
    let key = &value.key;
    match &value.content {
        Content::Whole(whole) => writeln!(text, "<{key}>{whole}</{key}>"),
        Content::Names(names) => {
            writeln!(text, "<{key}>")?;
            names.iter().try_for_each(|name| writeln!(text, "  <_>\"{name}\"</_>"))?;
            writeln!(text, "</{key}>")
        }
        Content::Matrix { rows, values } => {
            let (cols, data) = (values.len() / rows, numbers(values, " "));
            writeln!(
                text,
                "<{key} type_id=\"opencv-matrix\">\n  <rows>{rows}</rows>\n  <cols>{cols}</cols>\n  <dt>d</dt>\n  \
                 <data>\n    {data}</data></{key}>"
            )
        }
    }
}
