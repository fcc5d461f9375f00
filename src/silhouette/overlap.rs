//! How well a model covers a silhouette.

use nalgebra::{Point2, Vector2};

use super::Silhouette;

/// Steps along the longer side of the silhouette's box.
const STEPS: f64 = 100.0;
/// Most steps along the longer side of both boxes together: a model that has gone astray costs no more.
const MOST_STEPS: f64 = 400.0;

/// Areas of the intersection and of the union of a silhouette and a model, undistorted px².
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Overlap {
    /// In both.
    pub intersection: f64,
    /// In at least one.
    pub union: f64,
    /// In the model.
    pub model: f64,
    /// Of that, far outside the silhouette.
    pub astray: f64,
}

impl Overlap {
    /// Intersection over union, 0 (apart) to 1 (the same); 0 if both are empty.
    pub fn iou(&self) -> f64 {
        if self.union > 0.0 { self.intersection / self.union } else { 0.0 }
    }

    /// The share of the model that lies far outside the silhouette; 0 for one that is not seen.
    pub fn astray_share(&self) -> f64 {
        if self.model > 0.0 { self.astray / self.model } else { 0.0 }
    }
}

/// The points at which areas are counted: the centres of square cells.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OverlapGrid {
    /// The corner of the first cell, undistorted px.
    pub low: Point2<f64>,
    /// Side of a cell, px.
    pub step: f64,
    /// Cells across.
    pub columns: usize,
    /// Cells down.
    pub rows: usize,
}

impl OverlapGrid {
    /// The centre of a cell.
    pub fn centre(&self, column: usize, row: usize) -> Point2<f64> {
        self.low + Vector2::new(column as f64 + 0.5, row as f64 + 0.5) * self.step
    }
}

impl Silhouette {
    /// The grid over the silhouette's box and that of a model.
    ///
    /// Its step is 1/100 of the longer side of the silhouette's box or 1/400 of that of both boxes, whichever is more, and at
    /// least 1 px. What lies beyond the image is not counted: there the silhouette is unknown.
    pub fn overlap_grid(&self, model_bounds: (Point2<f64>, Point2<f64>)) -> OverlapGrid {
        let (low, high) = self.bounds;
        let size_px = (high - low).max();
        let (image_low, image_high) = self.outside.image_bounds();
        let low = low.inf(&model_bounds.0).sup(&image_low);
        let high = high.sup(&model_bounds.1).inf(&image_high);

        let step = (size_px / STEPS).max((high - low).max() / MOST_STEPS).max(1.0);
        let cells = |from: f64, to: f64| ((to - from) / step).ceil().max(0.0) as usize;
        OverlapGrid { low, step, columns: cells(low.x, high.x), rows: cells(low.y, high.y) }
    }

    /// Overlap with the model that covers the cells of a grid for which `is_model` holds: column, row, and the cell's centre. What
    /// lies more than `far_px` outside the silhouette is astray.
    pub fn overlap(
        &self,
        grid: &OverlapGrid,
        far_px: f64,
        is_model: impl Fn(usize, usize, &Point2<f64>) -> bool,
    ) -> Overlap {
        let [mut intersection, mut union, mut covered, mut astray] = [0usize; 4];
        for row in 0..grid.rows {
            for column in 0..grid.columns {
                let pixel = grid.centre(column, row);
                let (mask, model) = (self.contains(&pixel), is_model(column, row, &pixel));
                if (mask || model) && self.sees(&pixel) {
                    union += 1;
                    covered += usize::from(model);
                    intersection += usize::from(mask && model);
                    let is_far = model && !mask && self.outside.sample(&pixel).0 > far_px;
                    astray += usize::from(is_far);
                }
            }
        }

        let area = |cells: usize| cells as f64 * grid.step * grid.step;
        Overlap {
            intersection: area(intersection),
            union: area(union),
            model: area(covered),
            astray: area(astray),
        }
    }
}
