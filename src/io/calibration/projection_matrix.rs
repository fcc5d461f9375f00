//! Plain 3 × 4 projection matrices in a text file.
//!
//! ```text
//! 800 600                      # width height, of all cameras that follow
//! cam_01                       # a name; in a file for one camera it may be missing
//! 760.0 0.0 399.5 120.0        # three rows of four numbers
//! …
//! ```
//!
//! A size between a name and its rows holds for that camera only. `P0: ` with twelve numbers on the line is accepted
//! too; commas and `#` remarks are passed over.

use super::{
    CalibrationError, Place, Unit,
    unchecked::{Lens, Numbers, Size, UncheckedCamera},
};
use crate::io::input::shortened;
use nalgebra::{Matrix3, Matrix3x4, Vector3};
use std::path::Path;

/// Smallest sine of an angle between rows for which they are independent.
const INDEPENDENT: f64 = 1e-12;

/// The cameras of a file; `alone` names the camera of a file with one nameless matrix.
pub(super) fn parse(
    path: &Path,
    text: &str,
    alone: &str,
) -> Result<Vec<UncheckedCamera>, CalibrationError> {
    let mut reader = Reader { path, common_size: Size::Unstated, blocks: Vec::new() };

    for (index, line) in text.lines().enumerate() {
        reader.line(index + 1, line)?;
    }

    // a single camera may go without a name
    let nameless = reader.blocks.len() == 1;
    let mut cameras = Vec::new();
    for mut block in reader.blocks {
        if block.name.is_empty() && nameless {
            block.name = alone.into();
        }
        cameras.push(block.camera(path)?);
    }

    Ok(cameras)
}

struct Reader<'a> {
    path: &'a Path,
    common_size: Size,
    blocks: Vec<Block>,
}

/// A name and the numbers that follow it.
struct Block {
    name: String,
    line: usize,
    size: Size,
    values: Vec<f64>,
}

impl Reader<'_> {
    fn line(&mut self, number: usize, line: &str) -> Result<(), CalibrationError> {
        let line = line.split('#').next().unwrap_or("").trim();
        let tokens: Vec<&str> = line
            .split(|c: char| c.is_whitespace() || c == ',')
            .filter(|token| !token.is_empty())
            .collect();
        let values: Option<Vec<f64>> = tokens.iter().map(|token| token.parse().ok()).collect();
        match values {
            Some(values) if values.is_empty() => Ok(()),
            Some(values) if values.len() == 2 => {
                self.size(number, values);
                Ok(())
            }
            Some(values) if values.len() > 1 => self.row(number, &values),
            // one token: a name, even if it is a number
            _ => self.name(number, line, &tokens),
        }
    }

    fn size(&mut self, line: usize, values: Vec<f64>) {
        let size = Size::Stated(Numbers::new(self.path, line, "width height", values));
        match self.blocks.last_mut().filter(|block| block.values.is_empty()) {
            Some(block) => block.size = size,
            None => self.common_size = size,
        }
    }

    fn row(&mut self, line: usize, values: &[f64]) -> Result<(), CalibrationError> {
        if !matches!(values.len(), 4 | 12) {
            let camera = self.blocks.last().map(|block| block.name.as_str());
            return Err(CalibrationError::Count {
                place: Place::new(self.path, Some(line), camera.filter(|name| !name.is_empty())),
                key: "projection matrix row".into(),
                expected: "4",
                found: values.len(),
            });
        }

        // a row after a full matrix begins the next camera
        let full = self.blocks.last().is_none_or(|block| block.values.len() >= 12);
        if full {
            self.start(line, "");
        }
        if let Some(block) = self.blocks.last_mut() {
            block.values.extend(values);
        }

        Ok(())
    }

    fn name(&mut self, line: usize, text: &str, tokens: &[&str]) -> Result<(), CalibrationError> {
        // "P0:" and twelve numbers on one line
        let numbers: Vec<f64> = tokens.iter().filter_map(|token| token.parse().ok()).collect();
        if numbers.len() == 12 && tokens.len() == 13 && tokens[0].ends_with(':') {
            self.start(line, tokens[0].trim_end_matches(':'));
            return self.row(line, &numbers);
        }
        // a broken number among numbers is not a name
        let broken = tokens.iter().find(|token| token.parse::<f64>().is_err());
        if let Some(found) = broken.filter(|_| numbers.len() > 1) {
            return Err(CalibrationError::NotANumber {
                place: Place::new(self.path, Some(line), None),
                key: "projection matrix row".into(),
                found: shortened(found),
            });
        }
        self.start(line, text.trim_end_matches(':').trim());
        Ok(())
    }

    fn start(&mut self, line: usize, name: &str) {
        self.blocks.push(Block {
            name: name.into(),
            line,
            size: self.common_size.clone(),
            values: Vec::new(),
        });
    }
}

impl Block {
    fn camera(self, path: &Path) -> Result<UncheckedCamera, CalibrationError> {
        let place = Place::new(path, Some(self.line), Some(&self.name));
        if self.name.is_empty() {
            return Err(CalibrationError::MissingKey {
                place: Place::new(path, Some(self.line), None),
                key: "the camera's name above its matrix".into(),
            });
        }

        let numbers = |key: &str, values| Numbers::new(path, self.line, key, values);
        let entries = numbers("projection matrix", self.values).exactly::<12>("12", &self.name)?;
        let matrix = Matrix3x4::from_row_slice(&entries);
        let (k, r, t) = decompose(&matrix).ok_or(CalibrationError::Projection { place })?;
        let by_rows = |m: &Matrix3<f64>| m.transpose().as_slice().to_vec();

        Ok(UncheckedCamera {
            path: path.into(),
            line: self.line,
            size: self.size,
            matrix: numbers("projection matrix", by_rows(&k)),
            lens: Lens::BrownConrady(numbers("distortion", Vec::new())),
            rotation: numbers("projection matrix", by_rows(&r)),
            translation: numbers("projection matrix", t.as_slice().to_vec()),
            unit: Unit::Metre,
            name: self.name,
        })
    }
}

/// K, R and t of P ≃ K·\[R|t\] with positive focal lengths, K₃₃ = 1 and det R = +1; `None` if P's left block is singular.
///
/// RQ decomposition of the left 3 × 3 block by Gram–Schmidt from the last row up. P is known up to a factor; its sign
/// follows from det R = +1.
///
/// # Source
/// Hartley & Zisserman, *Multiple View Geometry*, 2nd ed., §6.2.4 and A4.1.
fn decompose(p: &Matrix3x4<f64>) -> Option<(Matrix3<f64>, Matrix3<f64>, Vector3<f64>)> {
    let m = p.fixed_columns::<3>(0);
    let scale = m.row(2).norm().copysign(m.determinant());
    let p = p / scale;
    let row = |i: usize| p.fixed_columns::<3>(0).row(i).transpose();
    let r3 = row(2);
    // m₂ = f_y r₂ + c_y r₃
    let cy = row(1).dot(&r3);
    let across = row(1) - r3 * cy;
    let fy = across.norm();
    let r2 = across / fy;
    // m₁ = f_x r₁ + s r₂ + c_x r₃
    let (cx, skew) = (row(0).dot(&r3), row(0).dot(&r2));
    let along = row(0) - r3 * cx - r2 * skew;
    let fx = along.norm();
    let r1 = along / fx;
    let independent = fy > INDEPENDENT * row(1).norm() && fx > INDEPENDENT * row(0).norm();
    if !independent || !scale.is_normal() {
        return None;
    }
    let tz = p[(2, 3)];
    let ty = (p[(1, 3)] - cy * tz) / fy;
    let tx = (p[(0, 3)] - skew * ty - cx * tz) / fx;
    let k = Matrix3::new(fx, skew, cx, 0.0, fy, cy, 0.0, 0.0, 1.0);
    let r = Matrix3::from_rows(&[r1.transpose(), r2.transpose(), r3.transpose()]);
    Some((k, r, Vector3::new(tx, ty, tz)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Rotation3;

    #[test]
    fn a_matrix_of_any_scale_and_sign_gives_its_camera_back() {
        let k = Matrix3::new(760.0, 2.5, 399.5, 0.0, 755.0, 299.5, 0.0, 0.0, 1.0);
        let r = Rotation3::new(Vector3::new(1.0, 1.6, -1.5)).into_inner();
        let t = Vector3::new(0.14, 0.89, 4.5);
        let mut pose = Matrix3x4::zeros();
        pose.fixed_columns_mut::<3>(0).copy_from(&r);
        pose.set_column(3, &t);
        for scale in [1.0, -1.0, 1e-4, -350.0] {
            let (k_back, r_back, t_back) = decompose(&(k * pose * scale)).unwrap();
            approx::assert_relative_eq!(k_back, k, epsilon = 1e-9);
            approx::assert_relative_eq!(r_back, r, epsilon = 1e-12);
            approx::assert_relative_eq!(t_back, t, epsilon = 1e-12);
        }
    }

    #[test]
    fn a_singular_matrix_has_no_camera() {
        assert!(decompose(&Matrix3x4::zeros()).is_none());
        let mut parallel = Matrix3x4::identity();
        parallel.set_row(1, &parallel.row(2).into_owned());
        assert!(decompose(&parallel).is_none());
    }
}
