//! Recorded pictures in a report: the part around the person, as JPEG of few bytes.

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use nalgebra::Point2;
use serde::Serialize;

use crate::camera::Camera;
use crate::image::Picture;
use crate::io::folder::jpeg;

/// Bytes that all pictures of a report have together, in base64.
const BUDGET_BYTES: usize = 12_000_000;
/// Fewer bytes show too little: rather fewer frames have a picture.
const LEAST_BYTES: usize = 5_000;
/// Greatest height, px.
const HIGHEST_PX: f64 = 480.0;
/// Qualities of JPEG that are tried before the picture is made smaller.
const QUALITIES: [u8; 3] = [75, 55, 40];
/// Side of a picture that is not made smaller any more, px.
const SMALLEST_PX: usize = 48;

/// How many pictures a report holds, and how large they are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PictureBudget {
    /// Every so many frames have pictures.
    pub every: usize,
    /// Bytes of one picture.
    bytes: usize,
}

impl PictureBudget {
    /// The budget of so many pictures in each of so many frames.
    pub fn new(cameras: usize, frames: usize) -> Self {
        // base64 has four letters for three bytes
        let all = BUDGET_BYTES / 4 * 3;
        let every = (cameras * frames * LEAST_BYTES).div_ceil(all).max(1);
        let pictures = (cameras * frames.div_ceil(every)).max(1);
        Self { every, bytes: all / pictures }
    }
}

/// A part of an image without distortion, px: it begins at the outer edge of its first column and row.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct ImagePart {
    /// First column.
    pub left: usize,
    /// First row.
    pub top: usize,
    /// Number of columns.
    pub width: usize,
    /// Number of rows.
    pub height: usize,
}

/// A part of a recorded picture without the lens's distortion.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct FramePicture {
    /// Frames after the first.
    pub frame: usize,
    /// The part.
    #[serde(flatten)]
    pub part: ImagePart,
    /// JPEG in base64.
    jpeg: String,
}

impl FramePicture {
    /// The part of a picture, `frame` frames after the first, as large and as good as the budget allows; `None` of a part
    /// without pixels.
    pub fn new(
        camera: &Camera,
        picture: &Picture,
        (frame, part): (usize, ImagePart),
        budget: PictureBudget,
    ) -> Option<Self> {
        let mut scale = (HIGHEST_PX / part.height as f64).min(1.0);
        loop {
            let small = shrunk(camera, picture, part, scale);

            // the best quality that the budget allows
            let is_smallest = small.width().min(small.height()) <= SMALLEST_PX;
            for quality in QUALITIES {
                let file = jpeg::encode(&small, quality).ok()?;
                let is_last = is_smallest && Some(&quality) == QUALITIES.last();
                if file.len() <= budget.bytes || is_last {
                    return Some(Self { frame, part, jpeg: BASE64_STANDARD.encode(file) });
                }
            }
            scale *= 0.75;
        }
    }

    /// Letters of the picture.
    pub fn bytes(&self) -> usize {
        self.jpeg.len()
    }
}

/// A part of a picture without distortion at a scale of at most 1; black beyond the picture.
fn shrunk(camera: &Camera, picture: &Picture, part: ImagePart, scale: f64) -> Picture {
    let size = |pixels: usize| ((pixels as f64 * scale).round() as usize).max(1);
    let (width, height) = (size(part.width), size(part.height));
    let steps = [part.width as f64 / width as f64, part.height as f64 / height as f64];
    // places in each pixel, across and down
    let fine = (1.0 / scale).round().clamp(1.0, 4.0) as usize;

    let value = |x: usize, y: usize| {
        let mut sum = [0.0; 3];
        for k in 0..fine * fine {
            let within = [k % fine, k / fine].map(|i| (i as f64 + 0.5) / fine as f64);
            let column = part.left as f64 - 0.5 + (x as f64 + within[0]) * steps[0];
            let row = part.top as f64 - 0.5 + (y as f64 + within[1]) * steps[1];
            let colour = nearest(picture, &camera.distort(&Point2::new(column, row)));
            (0..3).for_each(|c| sum[c] += f64::from(colour[c]));
        }
        sum.map(|s| (s / (fine * fine) as f64).round() as u8)
    };
    let mut small = Picture::filled(width, height, [0; 3]);
    for y in 0..height {
        for (x, pixel) in small.row_mut(y).iter_mut().enumerate() {
            *pixel = value(x, y);
        }
    }
    small
}

fn nearest(picture: &Picture, place: &Point2<f64>) -> [u8; 3] {
    let index = |v: f64, size: usize| {
        let rounded = v.round();
        (rounded >= 0.0 && rounded < size as f64).then_some(rounded as usize)
    };
    let pixel = index(place.x, picture.width()).zip(index(place.y, picture.height()));
    pixel.and_then(|(x, y)| picture.get(x, y)).unwrap_or([0; 3])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::{Distortion, Intrinsics};
    use crate::math::Rigid3;

    fn camera() -> Camera {
        let focal = 300.0;
        Camera {
            name: "a".into(),
            width_px: 200,
            height_px: 300,
            intrinsics: Intrinsics {
                fx_px: focal,
                fy_px: focal,
                cx_px: 99.5,
                cy_px: 149.5,
                skew_px: 0.0,
            },
            distortion: Distortion::None,
            camera_from_world: Rigid3::identity(),
        }
    }

    /// Noise, which no encoder makes small.
    fn noise() -> Picture {
        let mut state = 1_u32;
        let mut next = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 24) as u8
        };
        let values = (0..200 * 300).map(|_| [next(), next(), next()]).collect();
        Picture::from_values(200, 300, values).unwrap()
    }

    const WHOLE: ImagePart = ImagePart { left: 0, top: 0, width: 200, height: 300 };

    #[test]
    fn all_pictures_of_a_report_stay_within_the_budget() {
        for (cameras, frames) in [(7, 79), (8, 3000), (2, 1)] {
            let budget = PictureBudget::new(cameras, frames);
            let pictures = cameras * frames.div_ceil(budget.every);
            assert!(budget.bytes >= LEAST_BYTES && pictures * budget.bytes * 4 / 3 <= BUDGET_BYTES);
        }
        let budget = PictureBudget { every: 1, bytes: 4000 };
        let picture = FramePicture::new(&camera(), &noise(), (3, WHOLE), budget).unwrap();
        assert!(picture.bytes() <= 4000 * 4 / 3 + 4, "{}", picture.bytes());
        assert_eq!((picture.frame, picture.part), (3, WHOLE));
    }

    #[test]
    fn a_part_is_cut_out_where_it_is_and_shrunk_to_means() {
        let mut picture = Picture::filled(200, 300, [0; 3]);
        for y in 100..200 {
            picture.row_mut(y)[50..100].fill([200, 100, 0]);
        }
        let part = ImagePart { left: 40, top: 90, width: 80, height: 120 };
        let small = shrunk(&camera(), &picture, part, 0.5);
        assert_eq!((small.width(), small.height()), (40, 60));
        // its edges lie between two pixels of the smaller picture
        let at = |x, y| small.get(x, y).unwrap();
        assert_eq!([at(4, 30), at(5, 30), at(29, 30), at(30, 30)].map(|c| c[0]), [0, 200, 200, 0]);
        assert_eq!([at(10, 4), at(10, 5), at(10, 54), at(10, 55)].map(|c| c[1]), [0, 100, 100, 0]);
    }
}
