//! Rods in a silhouette: canes, crutches, walking frames, poles.
//!
//! No part of a person is thin and long at once. Of 1986 women (ANSUR II, Gordon et al. 2014) 95 % have wrists of 142 mm around and more, which
//! are 39 mm thick where their axes are as 3 to 4; the longest hand of 6068 adults measures 239 mm, and behind it a third of a
//! forearm, 90 mm, is hardly thicker than the wrist. So what an opening by a disk of [`THICKNESS_M`] takes away, what sticks out by
//! more than [`REACH_M`] and what is longer than [`LENGTH_M`] is no part of the person.
//!
//! Two tubes in line, or a tube in line with a hand, are thicker. They are found by the other cameras, which see them apart: so a
//! silhouette is handed out as [`CellMask`], whose slender part is looked at again.

use std::collections::HashSet;

use nalgebra::{Point2, Vector2};

use super::{BorderPoint, ContourPoint, Silhouette, SilhouetteOptions, from_curves};
use crate::camera::Camera;
use crate::image::{Component, Connectivity, Mask, Runs, opened, resample, trace, widened};

/// A silhouette is looked at in cells of this side, metres.
const CELL_M: f64 = 0.005;
/// Pixels larger than so many cells do not show how thick a rod is.
const MOST_CELLS: f64 = 2.0;
/// A rod is not thicker, metres; a walking frame's tubes are 25 mm thick, and masks are ragged.
const THICKNESS_M: f64 = 0.04;
/// What is nearer to the person may be a fold or a ragged border, metres.
const REACH_M: f64 = 0.03;
/// A rod sticks out longer than a hand and a third of a forearm, metres.
const LENGTH_M: f64 = 0.35;
/// Pieces of a smaller area, m², are where rods cross: a hand has 0.01.
const LEAST_AREA_M2: f64 = 0.005;
/// What is thinner is slender, metres: forearms, hands, ankles, feet, and two rods in line.
const SLENDER_M: f64 = 0.08;

/// What a silhouette holds, in square cells of the size of the person.
#[derive(Debug, Clone)]
pub(crate) struct CellMask {
    /// With a margin of nothing around it.
    mask: Mask,
    /// Of the first cell.
    corner: Point2<f64>,
    side_px: f64,
}

impl CellMask {
    /// Of a person at a distance where a metre measures `px_per_m`; `None` if the pixels are too large.
    pub(crate) fn new(silhouette: &Silhouette, px_per_m: f64) -> Option<Self> {
        let side_px = CELL_M * px_per_m;
        if side_px * MOST_CELLS < 1.0 {
            return None;
        }
        let (low, high) = silhouette.bounds;
        let margin = cells(SLENDER_M);
        let count = |length_px: f64| (length_px / side_px).ceil() as usize + 2 * margin;
        let corner = low - Vector2::repeat(margin as f64 * side_px);
        let mask = Mask::from_fn(count(high.x - low.x), count(high.y - low.y), |x, y| {
            let middle = Vector2::new(x as f64 + 0.5, y as f64 + 0.5);
            silhouette.contains(&(corner + middle * side_px))
        });
        Some(Self { mask, corner, side_px })
    }

    /// Whether a pixel is in one of the cells.
    pub(crate) fn contain(&self, pixel: &Point2<f64>) -> bool {
        let cell = (pixel - self.corner) / self.side_px;
        cell.min() >= 0.0 && self.mask.is_foreground(cell.x as usize, cell.y as usize)
    }

    /// The cells in which there are contour points.
    fn around(&self, contour: &[ContourPoint]) -> Mask {
        let cell = |point: &ContourPoint| {
            let at = (point.pixel - self.corner) / self.side_px;
            (at.x as usize, at.y as usize)
        };
        let cells: HashSet<(usize, usize)> = contour.iter().map(cell).collect();
        Mask::from_fn(self.mask.width(), self.mask.height(), |x, y| cells.contains(&(x, y)))
    }

    /// Those that are no rod's; `None` if there are no rods.
    pub(crate) fn without_rods(&self) -> Option<Self> {
        // what sticks out of the thick pieces and is long
        let whole = &self.mask;
        let thick = opened(whole, disk(THICKNESS_M));
        let large = pieces(&thick, |piece| piece.area >= square_cells(LEAST_AREA_M2));
        let beside = widened(&large, cells(REACH_M) as u8);
        let long = pieces(&without(whole, &beside), |piece| length_m(piece) > LENGTH_M);
        if Runs::from_mask(&long).area() == 0 {
            return None;
        }

        // to where they touch the person
        let near = widened(&long, cells(REACH_M) as u8 + 1);
        let thin = without(whole, &thick);
        let rods = Mask::from_fn(whole.width(), whole.height(), |x, y| {
            long.is_foreground(x, y) || near.is_foreground(x, y) && thin.is_foreground(x, y)
        });
        let own = pieces(&without(whole, &rods), |piece| piece.area >= square_cells(LEAST_AREA_M2));
        Some(Self { mask: own, ..*self })
    }

    /// Without the slender ones of which `is_own` does not hold, by the pixel in the middle of a block of them.
    pub(crate) fn without_slender(&self, is_own: impl Fn(&Point2<f64>) -> bool) -> Self {
        const BLOCK: usize = 4;
        let thick = opened(&self.mask, disk(SLENDER_M));
        let slender = without(&self.mask, &thick);
        let blocks = Mask::from_fn(
            self.mask.width().div_ceil(BLOCK),
            self.mask.height().div_ceil(BLOCK),
            |column, row| {
                let of_block = (0..BLOCK * BLOCK)
                    .map(|i| (column * BLOCK + i % BLOCK, row * BLOCK + i / BLOCK));
                let inside: Vec<_> =
                    of_block.filter(|(x, y)| slender.is_foreground(*x, *y)).collect();
                let Some((x, y)) = inside.get(inside.len() / 2) else { return false };
                let middle = Vector2::new(*x as f64 + 0.5, *y as f64 + 0.5);
                !is_own(&(self.corner + middle * self.side_px))
            },
        );
        let mask = Mask::from_fn(self.mask.width(), self.mask.height(), |x, y| {
            self.mask.is_foreground(x, y)
                && !(slender.is_foreground(x, y) && blocks.is_foreground(x / BLOCK, y / BLOCK))
        });
        Self { mask, ..*self }
    }
}

impl Silhouette {
    /// The silhouette of cells of it, before a camera; the rest is background. Of its border only what was a border before is sure.
    ///
    /// `None` if there is nothing.
    pub(crate) fn within(&self, own: &CellMask, camera: &Camera) -> Option<Self> {
        let lengths_px: f64 = self.contour.iter().map(|point| point.length_px).sum();
        let spacing = lengths_px / self.contour.len() as f64 / own.side_px;
        let was_border = CellMask { mask: widened(&own.around(&self.contour), 1), ..*own };
        let border_point = |cell: &Point2<f64>| {
            let pixel = own.corner + (cell.coords + Vector2::repeat(0.5)) * own.side_px;
            let reliability = f64::from(u8::from(was_border.contain(&pixel)));
            BorderPoint { pixel, reliability }
        };
        let curves = trace(&Runs::from_mask(&own.mask))
            .into_iter()
            .map(|closed| resample(&closed, spacing).iter().map(border_point).collect());
        let curves: Vec<Vec<BorderPoint>> = curves.collect();
        from_curves(&curves, camera, &SilhouetteOptions::default()).ok()
    }
}

/// The pieces of a mask for which something holds.
fn pieces(mask: &Mask, is_kept: impl Fn(&Component) -> bool) -> Mask {
    let runs = Runs::from_mask(mask);
    let (components, labels) = runs.components(Connectivity::Eight);
    runs.filtered(|run| is_kept(&components[labels[run]])).mask()
}

fn without(mask: &Mask, taken: &Mask) -> Mask {
    Mask::from_fn(mask.width(), mask.height(), |x, y| {
        mask.is_foreground(x, y) && !taken.is_foreground(x, y)
    })
}

/// From corner to corner of the box around a piece.
fn length_m(piece: &Component) -> f64 {
    let region = piece.region;
    let size = [region.right - region.left, region.bottom - region.top].map(|cells| cells as f64);
    size[0].hypot(size[1]) * CELL_M
}

/// The radius of a disk of this diameter.
fn disk(diameter_m: f64) -> u8 {
    (cells(diameter_m) / 2) as u8
}

fn cells(length_m: f64) -> usize {
    (length_m / CELL_M).round() as usize
}

fn square_cells(area_m2: f64) -> usize {
    (area_m2 / (CELL_M * CELL_M)).round() as usize
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::silhouette::{SilhouetteOptions, extract};
    use crate::synth::Ring;

    const PX_PER_M: f64 = 150.0;

    fn camera() -> Camera {
        let ring = Ring { width_px: 320, height_px: 240, ..Ring::default() };
        ring.regular().cameras.remove(0)
    }

    /// A mask of a trunk, 30 cm broad, with an arm 6 cm thick, and with what `is_more` adds.
    fn silhouette(is_more: impl Fn(f64, f64) -> bool) -> Silhouette {
        let mask = Mask::from_fn(320, 240, |x, y| {
            let [x, y] = [x, y].map(|pixel| pixel as f64 / PX_PER_M);
            let is_trunk = (0.8..1.1).contains(&x) && (0.2..1.2).contains(&y);
            let is_arm = (1.1..1.6).contains(&x) && (0.4..0.46).contains(&y);
            is_trunk || is_arm || is_more(x, y)
        });
        extract(&mask, &camera(), &SilhouetteOptions::default()).unwrap()
    }

    fn cane(x: f64, y: f64) -> bool {
        (1.5..1.53).contains(&x) && (0.4..1.4).contains(&y)
    }

    fn own(silhouette: &Silhouette) -> Option<Silhouette> {
        let own = CellMask::new(silhouette, PX_PER_M)?.without_rods()?;
        silhouette.within(&own, &camera())
    }

    #[test]
    fn a_cane_is_taken_out_and_an_arm_is_not() {
        assert!(own(&silhouette(|_, _| false)).is_none());
        let with_cane = silhouette(cane);
        let own = own(&with_cane).unwrap();
        let [on_arm, on_cane] =
            [(1.4, 0.43), (1.515, 1.0)].map(|(x, y)| Point2::new(x, y) * PX_PER_M);
        assert!(with_cane.contains(&on_cane));
        assert!(own.contains(&on_arm) && own.sees(&on_arm));
        assert!(!own.contains(&on_cane) && own.outside.sample(&on_cane).0 > 20.0);

        // the border is what it was, and not known where the cane went down from the arm
        let alone = silhouette(|_, _| false);
        approx::assert_relative_eq!(own.area_px, alone.area_px, max_relative = 0.01);
        let below_arm = |p: &&ContourPoint| (p.pixel.y / PX_PER_M - 0.46).abs() < 0.01;
        let of_cane = |p: &&ContourPoint| (p.pixel.x / PX_PER_M - 1.515).abs() < 0.01;
        let sure = |s: &Silhouette, at: &dyn Fn(&&ContourPoint) -> bool| {
            s.contour.iter().filter(at).map(ContourPoint::counted_px).sum::<f64>()
        };
        approx::assert_abs_diff_eq!(sure(&own, &|p| below_arm(p) && of_cane(p)), 0.0);
        let (now, before) = (sure(&own, &below_arm), sure(&alone, &below_arm));
        assert!((0.8..1.0).contains(&(now / before)), "{now} of {before}");
    }

    #[test]
    fn a_thing_as_thick_as_a_limb_and_a_short_one_stay() {
        let post = |x: f64, y: f64| (1.5..1.56).contains(&x) && (0.4..1.4).contains(&y);
        let finger = |x: f64, y: f64| (1.5..1.53).contains(&x) && (0.4..0.7).contains(&y);
        assert!(own(&silhouette(post)).is_none());
        assert!(own(&silhouette(finger)).is_none());
    }

    #[test]
    fn slender_cells_go_where_nobody_owns_them() {
        let silhouette = silhouette(|_, _| false);
        let all = CellMask::new(&silhouette, PX_PER_M).unwrap();
        let left = all.without_slender(|pixel| pixel.x < 1.4 * PX_PER_M);
        let has = |cells: &CellMask, x: f64, y: f64| cells.contain(&(Point2::new(x, y) * PX_PER_M));
        assert!(has(&all, 1.5, 0.43) && !has(&left, 1.5, 0.43));
        assert!(has(&left, 1.3, 0.43) && has(&left, 0.95, 0.7));
        // what is thick is nobody's question
        assert!(has(&all.without_slender(|_| false), 0.95, 0.7));
    }

    #[test]
    fn pixels_that_are_too_large_tell_nothing() {
        assert!(CellMask::new(&silhouette(cane), 50.0).is_none());
    }
}
