//! Middlebury's cloth, seven views side by side: truth of the disparity for view 3, and views as cameras.

use std::path::Path;

use maquette::camera::{Camera, Distortion, Intrinsics};
use maquette::image::Plane;
use maquette::math::Rigid3;
use maquette::stereo::StereoView;
use nalgebra::{Translation3, UnitQuaternion};

use crate::Fault;

const FOCAL_PX: f64 = 1247.0;
const STEP_M: f64 = 0.04;

/// View `number` as a camera at x = 40 mm · number.
pub(crate) fn view(folder: &Path, number: usize) -> Result<StereoView, Fault> {
    let image = grey(&folder.join(format!("view{number}.pgm")))?;
    let camera = Camera {
        name: format!("view{number}"),
        width_px: image.width() as u32,
        height_px: image.height() as u32,
        intrinsics: Intrinsics {
            fx_px: FOCAL_PX,
            fy_px: FOCAL_PX,
            cx_px: 208.0,
            cy_px: 184.5,
            skew_px: 0.0,
        },
        distortion: Distortion::None,
        camera_from_world: Rigid3::from_parts(
            Translation3::new(-STEP_M * number as f64, 0.0, 0.0),
            UnitQuaternion::identity(),
        ),
    };
    Ok(StereoView::undistorted(&camera, &image)?)
}

/// The shift from view 3 to view 5 (or from 1 to 3) of a point at a depth, px.
pub(crate) fn shift_px(depth: f64) -> f64 {
    2.0 * STEP_M * FOCAL_PX / depth
}

/// The true shift of every pixel of view 3, px; NaN where it is not known.
///
/// `disp1` is given in steps of a third of a pixel between views 1 and 5. A pixel x₁ of view 1 lies at x₁ − d/2 in view 3;
/// between two of the same surface the shift is interpolated, and of several the nearest counts. `disp5` fills what
/// view 1 does not see.
pub(crate) fn truth(folder: &Path) -> Result<Plane<f64>, Fault> {
    let from_left = warped(&grey(&folder.join("disp1.pgm"))?, -1.0);
    let from_right = warped(&grey(&folder.join("disp5.pgm"))?, 1.0);
    let values = from_left.values().iter().zip(from_right.values());
    let values = values.map(|(a, b)| if a.is_nan() { *b } else { *a }).collect();
    Plane::from_values(from_left.width(), from_left.height(), values)
        .ok_or_else(|| "disparities of two sizes".into())
}

/// Shifts seen from view 3, of disparities seen from a view beside it.
fn warped(disparity: &Plane<u8>, sign: f64) -> Plane<f64> {
    let mut shifts = Plane::filled(disparity.width(), disparity.height(), f64::NAN);
    for y in 0..disparity.height() {
        let into = shifts.row_mut(y);
        for (x, pair) in disparity.row(y).windows(2).enumerate() {
            let [a, b] = [pair[0], pair[1]].map(|value| f64::from(value) / 6.0);
            if pair.contains(&0) || (a - b).abs() > 0.5 {
                continue;
            }
            let (from, to) = (x as f64 + sign * a, (x + 1) as f64 + sign * b);
            let first = from.min(to).ceil().max(0.0) as usize;
            for (place, shift) in into.iter_mut().enumerate().skip(first) {
                let t = (place as f64 - from) / (to - from);
                if !(0.0..=1.0).contains(&t) {
                    break;
                }
                let value = a + t * (b - a);
                // max of NaN and a number is the number
                *shift = shift.max(value);
            }
        }
    }
    shifts
}

fn grey(path: &Path) -> Result<Plane<u8>, Fault> {
    let image = image::open(path)?.to_luma8();
    let (width, height) = (image.width() as usize, image.height() as usize);
    Plane::from_values(width, height, image.into_raw()).ok_or_else(|| "an image of no size".into())
}
