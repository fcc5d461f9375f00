//! One person's share of a silhouette that shows several.
//!
//! A mask of several people is their union. One person's share of it has
//!
//! - of the border the points that may be theirs, each as reliable as it is probable that it is; where two people meet in the picture
//!   there is no border;
//! - inside, the pixels that are theirs; those of the others are unknown, like what lies beyond the image, for the others may stand before
//!   this one;
//! - outside, what lies outside everybody.

use nalgebra::{Point2, Vector2};

use super::{ContourPoint, Silhouette};
use crate::image::{EvenSteps, Scanlines};

/// Border points that are theirs with less probability are left out.
const LEAST_PROBABILITY: f64 = 0.02;
/// Rows of pixels that are looked at over the longer side of the silhouette's box, unless they would be closer than a pixel.
const ROWS: f64 = 150.0;

impl Silhouette {
    /// One person's share: of each border point the `probability` that it is theirs, and of each pixel inside, whether it `is_own`.
    ///
    /// `None` if nothing is theirs.
    pub fn share(
        &self,
        probability: impl Fn(&ContourPoint) -> f64,
        is_own: impl Fn(&Point2<f64>) -> bool,
    ) -> Option<Self> {
        let (contour, pieces) = self.shared_contour(probability);
        let cells = Cells::new(self, is_own);
        let [low, high] = cells.bounds?;
        (!contour.is_empty()).then(|| Self {
            contour,
            pieces,
            outside: self.outside.clone(),
            area_px: cells.count as f64 * cells.area_px,
            centroid: (cells.sum / cells.count as f64).into(),
            bounds: (low, high),
            cut_px: cells.cut_px,
            inside: Scanlines::from_runs(cells.own, cells.rows),
            others: Scanlines::from_runs(cells.others, cells.rows),
        })
    }

    fn shared_contour(
        &self,
        probability: impl Fn(&ContourPoint) -> f64,
    ) -> (Vec<ContourPoint>, Vec<usize>) {
        let (mut contour, mut pieces) = (Vec::new(), Vec::new());
        let mut is_broken = true;
        for (i, point) in self.contour.iter().enumerate() {
            let probability = probability(point);
            is_broken |= self.pieces.binary_search(&i).is_ok();
            if probability < LEAST_PROBABILITY {
                is_broken = true;
                continue;
            }
            if is_broken {
                pieces.push(contour.len());
                is_broken = false;
            }
            contour.push(ContourPoint { reliability: point.reliability * probability, ..*point });
        }
        (contour, pieces)
    }
}

/// The pixels of a silhouette, row by row, in square cells.
struct Cells {
    rows: EvenSteps,
    /// Runs that are the person's, and that are others'.
    own: Vec<(usize, [f64; 2])>,
    others: Vec<(usize, [f64; 2])>,
    area_px: f64,
    count: usize,
    sum: Vector2<f64>,
    bounds: Option<[Point2<f64>; 2]>,
    /// Length along the image edge.
    cut_px: f64,
}

impl Cells {
    fn new(silhouette: &Silhouette, is_own: impl Fn(&Point2<f64>) -> bool) -> Self {
        let (low, high) = silhouette.bounds;
        let size = high - low;
        let step = (size.max() / ROWS).max(1.0);
        let count = |length: f64| (length / step).ceil() as usize;
        let rows = EvenSteps { first: low.y + 0.5 * step, step, count: count(size.y) };
        let mut cells = Self {
            rows,
            own: Vec::new(),
            others: Vec::new(),
            area_px: step * step,
            count: 0,
            sum: Vector2::zeros(),
            bounds: None,
            cut_px: 0.0,
        };
        for row in 0..rows.count {
            for column in 0..count(size.x) {
                let x = low.x + (column as f64 + 0.5) * step;
                let pixel = Point2::new(x, rows.at(row));
                if !silhouette.contains(&pixel) {
                    continue;
                }
                let run = (row, [x - 0.5 * step, x + 0.5 * step]);
                if is_own(&pixel) {
                    cells.add(silhouette, &pixel);
                    cells.own.push(run);
                } else {
                    cells.others.push(run);
                }
            }
        }
        cells.own = joined(cells.own);
        cells.others = joined(cells.others);
        cells
    }

    /// Adds a cell that is the person's.
    fn add(&mut self, silhouette: &Silhouette, pixel: &Point2<f64>) {
        let step = self.rows.step;
        let half = Vector2::repeat(0.5 * step);
        self.count += 1;
        self.sum += pixel.coords;
        let [low, high] = self.bounds.unwrap_or([*pixel, *pixel]);
        self.bounds = Some([low.inf(&(pixel - half)), high.sup(&(pixel + half))]);
        let around = [Vector2::x(), -Vector2::x(), Vector2::y(), -Vector2::y()];
        let is_cut = around.iter().any(|to| !silhouette.outside.sees(&(pixel + to * step)));
        self.cut_px += if silhouette.cut_px > 0.0 && is_cut { step } else { 0.0 };
    }
}

/// Runs of a row that touch each other, as one.
fn joined(runs: Vec<(usize, [f64; 2])>) -> Vec<(usize, [f64; 2])> {
    let mut all: Vec<(usize, [f64; 2])> = Vec::new();
    for (row, [from, to]) in runs {
        match all.last_mut() {
            Some((last, ends)) if *last == row && from - ends[1] < 1e-6 => ends[1] = to,
            _ => all.push((row, [from, to])),
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::Camera;
    use crate::image::Mask;
    use crate::silhouette::{SilhouetteOptions, extract};
    use crate::synth::Ring;

    /// Two people who touch, left of x = 40 and right of it, and the camera that sees them.
    fn touching() -> (Camera, Silhouette) {
        let ring = Ring { width_px: 160, height_px: 120, ..Ring::default() };
        let camera = ring.regular().cameras.remove(0);
        let mask = Mask::from_fn(160, 120, |x, y| (20..70).contains(&x) && (20..100).contains(&y));
        let silhouette = extract(&mask, &camera, &SilhouetteOptions::default()).unwrap();
        (camera, silhouette)
    }

    #[test]
    fn two_shares_have_each_border_point_once_and_each_others_pixels_are_unknown() {
        let (_, both) = touching();
        let is_left = |pixel: &Point2<f64>| pixel.x < 40.0;
        let share = |is_own: &dyn Fn(&Point2<f64>) -> bool| {
            both.share(|point| f64::from(u8::from(is_own(&point.pixel))), is_own).unwrap()
        };
        let (left, right) = (share(&is_left), share(&|pixel| !is_left(pixel)));

        assert_eq!(left.contour.len() + right.contour.len(), both.contour.len());
        assert!(left.contour.iter().all(|point| is_left(&point.pixel)));
        approx::assert_relative_eq!(
            left.area_px + right.area_px,
            both.area_px,
            max_relative = 0.02
        );
        approx::assert_relative_eq!(left.area_px / both.area_px, 0.4, epsilon = 0.02);
        approx::assert_abs_diff_eq!(left.bounds.1.x, 40.0, epsilon = 1.5);

        let (own, others, outside) =
            (Point2::new(30.0, 60.0), Point2::new(60.0, 60.0), Point2::new(10.0, 60.0));
        assert!(left.contains(&own) && left.sees(&own));
        assert!(!left.contains(&others) && !left.sees(&others));
        assert!(!left.contains(&outside) && left.sees(&outside));
        // nobody is punished for being hidden
        assert!(left.outside.sample(&others).0 <= 0.0 && left.outside.sample(&outside).0 > 5.0);
    }

    #[test]
    fn half_a_probability_is_half_as_reliable_and_who_has_nothing_has_no_share() {
        let (_, both) = touching();
        let half = both.share(|_| 0.5, |_| true).unwrap();
        let counted = |s: &Silhouette| s.contour.iter().map(ContourPoint::counted_px).sum::<f64>();
        approx::assert_relative_eq!(counted(&half), 0.5 * counted(&both), max_relative = 1e-9);
        assert_eq!(half.thinned(5.0).len(), both.thinned(5.0).len());
        assert!(both.share(|_| 0.0, |_| true).is_none());
        assert!(both.share(|_| 1.0, |_| false).is_none());
    }
}
