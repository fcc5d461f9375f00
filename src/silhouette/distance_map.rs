//! How far a pixel lies outside a silhouette.

use nalgebra::{Point2, Vector2};

use crate::image::{EvenSteps, NearestPoints, Scanlines};

/// Scan lines of the image's outline.
const IMAGE_ROWS: usize = 256;

/// Distance to a silhouette, on a grid around it. Undistorted pixels.
///
/// A node holds the exact distance to the border polygons, negative inside, so that the zero of the interpolant lies on
/// the border and not somewhere in the cell that it crosses. Nodes beyond the camera's image are unknown.
#[derive(Clone, Debug)]
pub struct DistanceMap {
    low: Point2<f64>,
    cell: Vector2<f64>,
    columns: usize,
    rows: usize,
    /// Signed distance, px, row by row; NaN beyond the image.
    signed: Vec<f32>,
    image: Scanlines,
    image_bounds: (Point2<f64>, Point2<f64>),
}

/// The area that a distance map covers, and how finely.
pub(super) struct MapExtent {
    /// The silhouette's box.
    pub(super) bounds: (Point2<f64>, Point2<f64>),
    /// How far to go beyond it, over the longer side of the box.
    pub(super) margin: f64,
    /// Cells along the longer side of the map.
    pub(super) cells: usize,
}

impl DistanceMap {
    pub(super) fn new(
        polygons: &[Vec<Point2<f64>>],
        image_outline: Vec<Point2<f64>>,
        extent: &MapExtent,
    ) -> Self {
        let (low, high) = extent.bounds;
        let image_bounds = image_outline.iter().fold((low, high), |(l, h), p| (l.inf(p), h.sup(p)));

        let margin = Vector2::repeat(extent.margin * (high - low).max());
        // a hair inside the image, so that its outermost nodes are known
        let hair = Vector2::repeat(1e-3);
        let low = (low - margin).sup(&(image_bounds.0 + hair));
        let high = (high + margin).inf(&(image_bounds.1 - hair));

        let size = (high - low).map(|side| side.max(1.0));
        let cell_px = (size.max() / extent.cells as f64).max(1.0);
        let cells = size.map(|side| (side / cell_px).ceil().max(1.0));

        let outline = [image_outline];
        let image_step = (image_bounds.1.y - image_bounds.0.y) / IMAGE_ROWS as f64;
        let image_rows = EvenSteps {
            first: image_bounds.0.y + 0.5 * image_step,
            step: image_step,
            count: IMAGE_ROWS,
        };

        let mut map = Self {
            low,
            cell: size.component_div(&cells),
            columns: cells.x as usize + 1,
            rows: cells.y as usize + 1,
            signed: Vec::new(),
            image: Scanlines::new(&outline, image_rows),
            image_bounds,
        };
        map.fill(polygons, &outline);
        map
    }

    /// Distance from an undistorted pixel to the silhouette, px, and its gradient; both 0 inside and beyond the image.
    ///
    /// The gradient is exactly that of the value: of the bilinear interpolant of the cell, and beyond the grid of the
    /// interpolant at the nearest point of its box plus the distance to that point. NaN gives NaN.
    pub fn sample(&self, pixel: &Point2<f64>) -> (f64, Vector2<f64>) {
        if pixel.x.is_nan() || pixel.y.is_nan() {
            return (f64::NAN, Vector2::repeat(f64::NAN));
        }

        let nearest = pixel.sup(&self.low).inf(&self.high());
        let (value, gradient) = self.interpolated(&nearest);
        let beyond = pixel - nearest;
        let distance = beyond.norm();

        let is_unknown = value.is_nan() || (distance > 0.0 && !self.sees(pixel));
        let (outside, slope) =
            if is_unknown || value <= 0.0 { (0.0, Vector2::zeros()) } else { (value, gradient) };
        if is_unknown || distance <= 0.0 {
            return (outside, slope);
        }

        // the nearest point follows the pixel only along the side of the box
        let along = slope.zip_map(&beyond, |g, held| if held.abs() > 0.0 { 0.0 } else { g });
        (outside + distance, along + beyond / distance)
    }

    /// Whether an undistorted pixel lies in the camera's image.
    pub fn sees(&self, pixel: &Point2<f64>) -> bool {
        self.image.contains(pixel)
    }

    /// A box around the undistorted image.
    pub(super) fn image_bounds(&self) -> (Point2<f64>, Point2<f64>) {
        self.image_bounds
    }

    pub(super) fn heap_bytes(&self) -> usize {
        4 * self.signed.capacity() + self.image.heap_bytes()
    }

    fn high(&self) -> Point2<f64> {
        let cells = Vector2::new(self.columns as f64 - 1.0, self.rows as f64 - 1.0);
        self.low + self.cell.component_mul(&cells)
    }

    /// Bilinear interpolant at a point of the grid's box and its gradient; NaN where a corner is unknown.
    fn interpolated(&self, point: &Point2<f64>) -> (f64, Vector2<f64>) {
        let at = (point - self.low).component_div(&self.cell);
        let x = (at.x as usize).min(self.columns - 2);
        let y = (at.y as usize).min(self.rows - 2);
        let (s, t) = (at.x - x as f64, at.y - y as f64);
        let node = |x: usize, y: usize| f64::from(self.signed[y * self.columns + x]);
        let (a, b) = (node(x, y), node(x + 1, y));
        let (c, d) = (node(x, y + 1), node(x + 1, y + 1));

        let (upper, lower) = (a + s * (b - a), c + s * (d - c));
        let by_s = (b - a) + t * ((d - c) - (b - a));
        let gradient = Vector2::new(by_s, lower - upper).component_div(&self.cell);
        (upper + t * (lower - upper), gradient)
    }

    /// The signed distance of every node within the image.
    fn fill(&mut self, polygons: &[Vec<Point2<f64>>], image_outline: &[Vec<Point2<f64>>]) {
        let segments = segments(polygons);
        let mut nearest = NearestPoints::new(segments.iter().map(|s| s.from));
        let nodes = |first: f64, step: f64, count: usize| EvenSteps { first, step, count };
        let rows = nodes(self.low.y, self.cell.y, self.rows);
        let columns = nodes(self.low.x, self.cell.x, self.columns);
        let inside = Scanlines::new(polygons, rows);
        let image = Scanlines::new(image_outline, rows);

        self.signed = vec![f32::NAN; self.columns * self.rows];
        for (row, signed) in self.signed.chunks_exact_mut(self.columns).enumerate() {
            let y = rows.at(row);
            let mut is_inside = Crossings::new(inside.row(row));
            let mut is_seen = Crossings::new(image.row(row));

            nearest.along_row(y, columns, |i, point| {
                let node = Point2::new(columns.at(i), y);
                let distance = segments[point].distance_around(&node, &segments);
                let sign = if is_inside.odd_before(node.x) { -1.0 } else { 1.0 };
                if is_seen.odd_before(node.x) {
                    signed[i] = (sign * distance) as f32;
                }
            });
        }
    }
}

/// A side of a border polygon.
struct Segment {
    from: Point2<f64>,
    along: Vector2<f64>,
    /// Index of the side that ends where this one starts.
    before: usize,
}

fn segments(polygons: &[Vec<Point2<f64>>]) -> Vec<Segment> {
    let mut segments = Vec::with_capacity(polygons.iter().map(Vec::len).sum());
    for polygon in polygons {
        let first = segments.len();
        let next = polygon.iter().cycle().skip(1);
        for (k, (a, b)) in polygon.iter().zip(next).enumerate() {
            segments.push(Segment {
                from: *a,
                along: b - a,
                before: first + (k + polygon.len() - 1) % polygon.len(),
            });
        }
    }
    segments
}

impl Segment {
    /// Distance to this segment or the one before it, whichever is nearer.
    fn distance_around(&self, point: &Point2<f64>, segments: &[Self]) -> f64 {
        let before = segments[self.before].squared_distance(point);
        self.squared_distance(point).min(before).sqrt()
    }

    fn squared_distance(&self, point: &Point2<f64>) -> f64 {
        let to = point - self.from;
        let length = self.along.norm_squared();
        let fraction = (to.dot(&self.along) / length.max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
        (to - self.along * fraction).norm_squared()
    }
}

/// Counts the crossings of a row to the left of places that go ever farther right.
struct Crossings<'a> {
    row: &'a [f32],
    passed: usize,
}

impl<'a> Crossings<'a> {
    fn new(row: &'a [f32]) -> Self {
        Self { row, passed: 0 }
    }

    fn odd_before(&mut self, x: f64) -> bool {
        let is_passed = |crossing: &f32| f64::from(*crossing) <= x;
        while self.row.get(self.passed).is_some_and(is_passed) {
            self.passed += 1;
        }
        self.passed % 2 == 1
    }
}
