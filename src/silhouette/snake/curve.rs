//! Polylines, closed and open: their sides, their normals, and places at equal distances along them.

use nalgebra::{Point2, Vector2};

/// Whether a curve's last point is joined to its first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ends {
    /// It goes around.
    Closed,
    /// It has two ends.
    Open,
}

/// Unit normal to the right of the curve's course as seen on the screen: outward; `None` where it turns back on itself.
pub(super) fn normal(points: &[Point2<f64>], ends: Ends, i: usize) -> Option<Vector2<f64>> {
    let n = points.len();
    let (before, after) = match ends {
        Ends::Closed => ((i + n - 1) % n, (i + 1) % n),
        Ends::Open => (i.saturating_sub(1), (i + 1).min(n - 1)),
    };
    let along = points[after] - points[before];
    Vector2::new(-along.y, along.x).try_normalize(f64::EPSILON)
}

/// Unit normal of a closed curve, outward if the inside is on the left as seen on the screen; 0 where it turns back on itself.
pub fn outward(closed: &[Point2<f64>], i: usize) -> Vector2<f64> {
    normal(closed, Ends::Closed, i).unwrap_or_default()
}

/// The length of each side.
pub(super) fn sides(points: &[Point2<f64>], ends: Ends) -> Vec<f64> {
    let next = points.iter().cycle().skip(1);
    let count = match ends {
        Ends::Closed => points.len(),
        Ends::Open => points.len().saturating_sub(1),
    };
    let pairs = points.iter().zip(next).take(count);
    pairs.map(|(a, b)| (b - a).norm()).collect()
}

/// A place on a polyline: a fraction of the way from a point to the next.
pub(super) struct Place {
    from: usize,
    fraction: f64,
}

impl Place {
    pub(super) fn on(&self, curve: &[Point2<f64>]) -> Point2<f64> {
        let (a, b) = (curve[self.from], curve[(self.from + 1) % curve.len()]);
        a + (b - a) * self.fraction
    }
}

/// Places at equal distances of about the spacing along a polyline; on an open one from end to end.
pub(super) fn evenly(curve: &[Point2<f64>], ends: Ends, spacing_px: f64) -> Vec<Place> {
    let sides = sides(curve, ends);
    let length: f64 = sides.iter().sum();
    let count = (length / spacing_px).round();
    if !(1.0..1e6).contains(&count) {
        return Vec::new();
    }
    let step = length / count;
    let wanted = count as usize + usize::from(ends == Ends::Open);

    let mut places = Vec::with_capacity(wanted);
    let mut walked = 0.0;
    for (from, side) in sides.iter().enumerate() {
        while places.len() < wanted && places.len() as f64 * step <= walked + side {
            let fraction = (places.len() as f64 * step - walked) / side.max(f64::MIN_POSITIVE);
            places.push(Place { from, fraction: fraction.clamp(0.0, 1.0) });
        }
        walked += side;
    }

    // rounding decides whether the far end was reached
    if places.len() < wanted && !sides.is_empty() {
        places.push(Place { from: sides.len() - 1, fraction: 1.0 });
    }
    places
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_open_curve_is_walked_from_end_to_end_and_a_closed_one_around() {
        let square =
            [(0.0, 0.0), (8.0, 0.0), (8.0, 8.0), (0.0, 8.0)].map(|(x, y)| Point2::new(x, y));
        let at = |ends| -> Vec<Point2<f64>> {
            let places = evenly(&square, ends, 2.0);
            places.iter().map(|p| p.on(&square)).collect()
        };
        let (open, closed) = (at(Ends::Open), at(Ends::Closed));
        assert_eq!((open.len(), closed.len()), (13, 16));
        assert!((open[12] - square[3]).norm() < 1e-9);
        assert!((closed[15] - Point2::new(0.0, 2.0)).norm() < 1e-9);
    }

    #[test]
    fn a_spacing_that_is_none_and_a_curve_without_length_have_no_places() {
        let pair = [Point2::new(0.0, 0.0), Point2::new(8.0, 0.0)];
        for spacing_px in [0.0, -1.0, f64::NAN, 1e-9] {
            assert!(evenly(&pair, Ends::Open, spacing_px).is_empty());
        }
        assert!(evenly(&[], Ends::Closed, 2.0).is_empty());
    }
}
