//! A silhouette: its border, its inside, its outside.

use std::sync::Arc;

use nalgebra::{Point2, Vector2};

use super::DistanceMap;
use crate::image::Scanlines;

/// A point of a silhouette's border, which stands for a piece of it. Undistorted pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContourPoint {
    /// Where.
    pub pixel: Point2<f64>,
    /// Unit normal, outward: away from the person, also where the border is that of a hole.
    pub normal: Vector2<f64>,
    /// Length of the border that this point stands for.
    pub length_px: f64,
    /// How sure it is that the border is here, 0 to 1; of a mask always 1.
    pub reliability: f64,
}

impl ContourPoint {
    /// The length of border that it counts for: less where the border is unsure.
    pub fn counted_px(&self) -> f64 {
        self.length_px * self.reliability
    }
}

/// What one camera sees of the person in one frame. Everything in undistorted pixels.
#[derive(Clone, Debug)]
pub struct Silhouette {
    /// The outer and inner borders, piece after piece, without the parts on the image edge. Each piece runs with the
    /// person on the left as seen on the screen.
    pub contour: Vec<ContourPoint>,
    /// Distance from a pixel outside to the silhouette; of one person's share, to that of all people.
    pub outside: Arc<DistanceMap>,
    /// Area without the holes, px².
    pub area_px: f64,
    /// Centroid of the area.
    pub centroid: Point2<f64>,
    /// Corners of the smallest box that holds the silhouette: least x and y, greatest x and y.
    pub bounds: (Point2<f64>, Point2<f64>),
    /// Length of the border along the image edge, where the image cuts the person, px; that border is not in `contour`.
    pub cut_px: f64,
    /// Index into `contour` of the first point of each unbroken piece of border.
    pub(super) pieces: Vec<usize>,
    pub(super) inside: Scanlines,
    /// Where other people are seen, who may hide this one; empty unless this is one person's [share](Silhouette::share).
    pub(super) others: Scanlines,
}

impl Silhouette {
    /// Whether an undistorted pixel lies in the silhouette, to half a pixel (a thousandth of its height when that is more).
    pub fn contains(&self, pixel: &Point2<f64>) -> bool {
        self.inside.contains(pixel)
    }

    /// Whether it is known if the person is seen at an undistorted pixel: it lies in the camera's image, and nobody else is seen there.
    pub fn sees(&self, pixel: &Point2<f64>) -> bool {
        self.outside.sees(pixel) && !self.others.contains(pixel)
    }

    /// Some of the contour's points, as equally spaced along each piece as they allow.
    ///
    /// A piece of length L keeps max(1, round(L/spacing)) points at most. The lengths that they stand for add up to that of
    /// the whole contour, and a kept point is as reliable as those it stands for on average.
    pub fn thinned(&self, spacing_px: f64) -> Vec<ContourPoint> {
        let ends = self.pieces.iter().skip(1).copied();
        let ends = ends.chain(std::iter::once(self.contour.len()));
        let pieces = self.pieces.iter().zip(ends);
        pieces
            .filter_map(|(start, end)| self.contour.get(*start..end))
            .flat_map(|piece| thinned_piece(piece, spacing_px))
            .collect()
    }

    /// Bytes on the heap.
    pub fn heap_bytes(&self) -> usize {
        std::mem::size_of::<ContourPoint>() * self.contour.capacity()
            + std::mem::size_of::<usize>() * self.pieces.capacity()
            + self.inside.heap_bytes()
            + self.others.heap_bytes()
            + self.outside.heap_bytes()
    }
}

/// Cuts the piece into arcs of equal length and keeps the point nearest to the middle of each.
fn thinned_piece(piece: &[ContourPoint], spacing_px: f64) -> Vec<ContourPoint> {
    let length: f64 = piece.iter().map(|point| point.length_px).sum();
    let count = (length / spacing_px).round().max(1.0);
    if count >= piece.len() as f64 || count.is_nan() {
        return piece.to_vec();
    }

    let arc = length / count;
    let mut kept: Vec<(f64, ContourPoint)> = Vec::with_capacity(count as usize);
    let mut along = 0.0;
    let mut last_group = None;
    for point in piece {
        let position = (along + 0.5 * point.length_px) / arc;
        along += point.length_px;
        let off_middle = (position.fract() - 0.5).abs();

        // one point for each arc, which takes the lengths of all others in it
        match kept.last_mut() {
            Some((least, chosen)) if last_group == Some(position as usize) => {
                let length_px = chosen.length_px + point.length_px;
                let counted_px = chosen.counted_px() + point.counted_px();
                if off_middle < *least {
                    (*least, *chosen) = (off_middle, *point);
                }
                chosen.length_px = length_px;
                chosen.reliability = counted_px / length_px.max(f64::MIN_POSITIVE);
            }
            _ => kept.push((off_middle, *point)),
        }

        last_group = Some(position as usize);
    }
    kept.into_iter().map(|(_, point)| point).collect()
}
