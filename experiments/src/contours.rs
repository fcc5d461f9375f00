//! How far silhouettes are from the true ones, and pictures of both.

use std::path::{Path, PathBuf};

use maquette::image::{Mask, Picture, Plane, Runs, trace};
use maquette::render::{Canvas, Pen, Rgb};
use nalgebra::Point2;

/// A silhouette is in error below this overlap, …
pub const LEAST_OVERLAP: f64 = 0.9;
/// … or beyond this mean distance of the contours, px.
pub const MOST_DISTANCE_PX: f64 = 4.0;

/// How far a silhouette is from the true one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Score {
    /// Area of both over area of either.
    pub overlap: f64,
    /// Mean distance of the borders, the mean of both ways, px.
    ///
    /// Every border point of one mask to the nearest segment of the other's border. Infinite if one has no border.
    pub distance_px: f64,
}

impl Score {
    /// Compares two masks of the same size.
    pub fn of(found: &Mask, truth: &Mask) -> Self {
        let borders = [found, truth].map(|mask| trace(&Runs::from_mask(mask)));
        let [there, back] = [(0, 1), (1, 0)].map(|(a, b)| mean_distance(&borders[a], &borders[b]));
        Self { overlap: overlap(found, truth), distance_px: 0.5 * (there + back) }
    }

    /// Whether the silhouette is in error.
    pub fn is_error(&self) -> bool {
        self.overlap < LEAST_OVERLAP || self.distance_px > MOST_DISTANCE_PX
    }
}

/// Compares a mask of one view in a folder with the true one; one that was not written is no silhouette.
///
/// # Errors
/// If a mask cannot be read, or the true one is missing.
pub fn score_of_view(
    found: &Path,
    truth: &Path,
    camera: &str,
    frame: usize,
) -> Result<Score, String> {
    let truth = read_mask(&mask_path(truth, camera, frame))?;
    let path = mask_path(found, camera, frame);
    let found = if path.is_file() {
        read_mask(&path)?
    } else {
        Mask::from_fn(truth.width(), truth.height(), |_, _| false)
    };
    Ok(Score::of(&found, &truth))
}

/// Where a folder keeps the mask of a camera in a frame.
pub fn mask_path(folder: &Path, camera: &str, frame: usize) -> PathBuf {
    folder.join("masks").join(camera).join(format!("{frame:06}.png"))
}

/// A mask of a file: what is brighter than the middle.
///
/// # Errors
/// If it cannot be read.
pub fn read_mask(path: &Path) -> Result<Mask, String> {
    let picture = image::open(path).map_err(|fault| format!("{}: {fault}", path.display()))?;
    let grey = picture.to_luma8();
    let (width, height) = (grey.width() as usize, grey.height() as usize);
    let plane = Plane::from_values(width, height, grey.into_raw());
    let plane = plane.ok_or_else(|| format!("{}: a mask of no size", path.display()))?;
    Ok(Mask::brighter_than(&plane, 127))
}

fn overlap(one: &Mask, other: &Mask) -> f64 {
    let (mut both, mut either) = (0u64, 0u64);
    for y in 0..one.height().min(other.height()) {
        for (a, b) in one.row(y).iter().zip(other.row(y)) {
            both += u64::from(a & b);
            either += u64::from(a | b);
        }
    }
    both as f64 / either.max(1) as f64
}

type Border = Vec<Point2<f64>>;

fn mean_distance(from: &[Border], to: &[Border]) -> f64 {
    let segments: Vec<_> = to.iter().flat_map(sides).collect();
    let points: Vec<_> = from.iter().flatten().collect();
    if points.is_empty() {
        return f64::INFINITY;
    }
    let nearest = |p: &&Point2<f64>| {
        let all = segments.iter().map(|(a, b)| squared_distance(p, a, b));
        all.fold(f64::INFINITY, f64::min).sqrt()
    };
    points.iter().map(nearest).sum::<f64>() / points.len() as f64
}

fn sides(border: &Border) -> impl Iterator<Item = (Point2<f64>, Point2<f64>)> + '_ {
    let next = border.iter().cycle().skip(1);
    border.iter().zip(next).map(|(a, b)| (*a, *b))
}

fn squared_distance(p: &Point2<f64>, a: &Point2<f64>, b: &Point2<f64>) -> f64 {
    let (side, to) = (b - a, p - a);
    let length = side.norm_squared().max(f64::MIN_POSITIVE);
    (to - side * (to.dot(&side) / length).clamp(0.0, 1.0)).norm_squared()
}

/// The true border, and the found one over it.
const TRUE: Rgb = [40, 220, 255];
const FOUND: Rgb = [255, 60, 40];

/// A photograph with the true border (light blue) and the found one (red) over it.
pub fn compared(photograph: &Picture, found: &Mask, truth: &Mask) -> Picture {
    compared_with(photograph, &trace(&Runs::from_mask(found)), truth)
}

/// The same of a border that is known as closed curves, px.
pub fn compared_with(photograph: &Picture, found: &[Vec<Point2<f64>>], truth: &Mask) -> Picture {
    let mut canvas = Canvas::from_pixels(photograph.clone());
    let truth = trace(&Runs::from_mask(truth));
    for (borders, color) in [(truth.as_slice(), TRUE), (found, FOUND)] {
        let segments = borders.iter().flat_map(sides);
        let segments: Vec<_> = segments.map(|(a, b)| [a, b]).collect();
        let pen = Pen { color, opacity: 0.9, width_px: 1.4 };
        canvas.draw(&segments, pen);
    }
    canvas.pixels().clone()
}

/// A mask as a picture, white on black.
pub fn black_and_white(mask: &Mask) -> Picture {
    Canvas::from_mask(mask, [0; 3], [255; 3]).pixels().clone()
}

/// Pictures of one size, row by row, cut to a window (left, top, width, height) and parted by white lines.
///
/// Empty without pictures.
pub fn sheet(rows: &[Vec<Picture>], [left, top, width, height]: [usize; 4]) -> Picture {
    const GAP: usize = 3;
    let columns = rows.iter().map(Vec::len).max().unwrap_or(0);
    let side = |count: usize, size: usize| (count * (size + GAP)).saturating_sub(GAP);
    let size = (side(columns, width), side(rows.len(), height));
    let mut sheet = Plane::filled(size.0, size.1, [255u8; 3]);
    for (row, pictures) in rows.iter().enumerate() {
        for (column, picture) in pictures.iter().enumerate() {
            let corner = column * (width + GAP);
            for y in 0..height.min(picture.height().saturating_sub(top)) {
                let line = picture.row(top + y);
                let used = line.get(left..(left + width).min(line.len())).unwrap_or(&[]);
                let into = sheet.row_mut(row * (height + GAP) + y);
                into[corner..corner + used.len()].copy_from_slice(used);
            }
        }
    }
    sheet
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(low: usize, high: usize) -> Mask {
        Mask::from_fn(60, 60, |x, y| (low..high).contains(&x) && (low..high).contains(&y))
    }

    #[test]
    fn a_silhouette_is_as_far_from_itself_as_nothing_and_a_larger_square_by_its_rim() {
        let same = Score::of(&square(10, 50), &square(10, 50));
        assert!(same.overlap >= 1.0);
        assert!(same.distance_px < 1e-9 && !same.is_error());
        let larger = Score::of(&square(7, 53), &square(10, 50));
        assert!((2.9..3.2).contains(&larger.distance_px), "{}", larger.distance_px);
        let much_larger = Score::of(&square(5, 55), &square(10, 50));
        assert!(much_larger.is_error());
    }

    #[test]
    fn nothing_is_in_error() {
        let nothing = Score::of(&square(0, 0), &square(10, 50));
        assert!(nothing.is_error() && nothing.distance_px.is_infinite());
    }

    #[test]
    fn a_sheet_puts_pictures_side_by_side() {
        let grey = |value| Picture::filled(8, 6, [value; 3]);
        let sheet = sheet(&[vec![grey(1), grey(2)], vec![grey(3)]], [2, 1, 4, 3]);
        assert_eq!((sheet.width(), sheet.height()), (11, 9));
        assert_eq!(sheet.get(0, 0), Some([1; 3]));
        assert_eq!(sheet.get(7, 2), Some([2; 3]));
        assert_eq!(sheet.get(1, 6), Some([3; 3]));
        assert_eq!(sheet.get(9, 8), Some([255; 3]));
    }
}
