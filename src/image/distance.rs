//! The nearest of many points, found for a whole row of a grid at once.

use nalgebra::Point2;

use super::EvenSteps;

/// Points sorted by x, among which the nearest to each node of a row is found.
///
/// The squared distance of a node (u, v) to the point k is the parabola (u − x_k)² + (v − y_k)² in u; the nearest
/// point belongs to the lowest parabola at u. One sweep builds the lower envelope of a row in O(points + nodes).
///
/// # Source
/// Felzenszwalb & Huttenlocher, *Distance Transforms of Sampled Functions*, Theory of Computing 8 (2012), Algorithm 1.
/// **Differs**: the apexes lie anywhere, not on pixels, so distances are exact for sub-pixel points.
#[derive(Clone, Debug)]
pub struct NearestPoints {
    /// x, y, and the index of the point in the caller's order.
    points: Vec<(f64, f64, usize)>,
    /// The lower envelope.
    envelope: Vec<Arc>,
}

/// The parabola of one point.
#[derive(Clone, Copy, Debug)]
struct Arc {
    /// Abscissa of the apex.
    x: f64,
    /// Height of the apex.
    height: f64,
    point: usize,
    /// Where it begins to be the lowest.
    from: f64,
}

impl NearestPoints {
    /// Sorts the points; those that are not finite are left out.
    pub fn new(points: impl Iterator<Item = Point2<f64>>) -> Self {
        let mut points: Vec<_> = points
            .enumerate()
            .filter(|(_, p)| p.x.is_finite() && p.y.is_finite())
            .map(|(i, p)| (p.x, p.y, i))
            .collect();
        points.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.2.cmp(&b.2)));
        Self { envelope: Vec::with_capacity(points.len()), points }
    }

    /// Calls `visit(i, nearest)` for the nodes (`columns.at(i)`, y), left to right; the step must be positive.
    ///
    /// `nearest` is the index of the nearest point in the order in which the points were given. Without points
    /// nothing is visited.
    pub fn along_row(&mut self, y: f64, columns: EvenSteps, mut visit: impl FnMut(usize, usize)) {
        self.build_envelope(y);
        let mut arcs = self.envelope.iter().peekable();
        let Some(mut arc) = arcs.next() else { return };
        for i in 0..columns.count {
            let u = columns.at(i);
            while let Some(next) = arcs.next_if(|next| next.from <= u) {
                arc = next;
            }
            visit(i, arc.point);
        }
    }

    fn build_envelope(&mut self, row_y: f64) {
        self.envelope.clear();
        for &(x, y, point) in &self.points {
            let height = (y - row_y) * (y - row_y);
            let mut from = f64::NEG_INFINITY;
            let mut is_hidden = false;

            // arcs that are nowhere the lowest any more go
            while let Some(last) = self.envelope.last() {
                // sorted by x: if not greater, it is equal
                if x <= last.x {
                    is_hidden = height >= last.height;
                } else {
                    // (u − x)² + height = (u − x_l)² + height_l
                    from = 0.5 * ((height - last.height) / (x - last.x) + x + last.x);
                }
                if is_hidden || (last.x < x && from > last.from) {
                    break;
                }
                self.envelope.pop();
            }

            if self.envelope.is_empty() {
                from = f64::NEG_INFINITY;
            }
            if !is_hidden {
                self.envelope.push(Arc { x, height, point, from });
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};

    use super::*;

    fn squared_distance_by_row(points: &[Point2<f64>], count: usize) -> Vec<(f64, f64)> {
        let mut nearest = NearestPoints::new(points.iter().copied());
        let columns = EvenSteps { first: -10.0, step: 0.9, count };
        let mut pairs = Vec::new();
        for row in 0..20 {
            let y = -3.0 + row as f64 * 1.7;
            nearest.along_row(y, columns, |i, point| {
                let node = Point2::new(columns.at(i), y);
                let distances = points.iter().map(|p| (p - node).norm_squared());
                let least = distances.fold(f64::INFINITY, f64::min);
                pairs.push(((points[point] - node).norm_squared(), least));
            });
        }
        pairs
    }

    #[test]
    fn the_nearest_point_is_that_of_trying_all() {
        let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(7);
        let points: Vec<_> = (0..300)
            .map(|_| Point2::new(random.random_range(-5.0..30.0), random.random_range(0.0..25.0)))
            .collect();
        let pairs = squared_distance_by_row(&points, 60);
        assert_eq!(pairs.len(), 1200);
        for (found, least) in pairs {
            approx::assert_relative_eq!(found, least, max_relative = 1e-12);
        }
    }

    #[test]
    fn points_above_each_other_are_told_apart() {
        let points: Vec<_> =
            (0..30).map(|i| Point2::new(f64::from(i % 3), f64::from(i / 3))).collect();
        for (found, least) in squared_distance_by_row(&points, 40) {
            approx::assert_relative_eq!(found, least, max_relative = 1e-12);
        }
    }

    #[test]
    fn without_points_nothing_is_visited() {
        let pairs = squared_distance_by_row(&[], 40);
        assert!(pairs.is_empty());
    }
}
