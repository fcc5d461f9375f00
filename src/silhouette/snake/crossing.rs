//! Curves that cross themselves, and what remains of them.

use nalgebra::Point2;

/// A closed curve cut at its crossings into simple loops, as indices of its points; one loop for one that does not cross.
///
/// The part between the two passages of the first crossing is a loop of its own; both parts are cut again in the same way.
pub(super) fn loops(points: &[Point2<f64>]) -> Vec<Vec<usize>> {
    let mut waiting = vec![(0..points.len()).collect::<Vec<usize>>()];
    let mut simple = Vec::new();
    while let Some(curve) = waiting.pop() {
        match crossing(points, &curve) {
            // each cut makes both loops shorter, so this ends
            Some((i, j)) => {
                waiting.push(curve[i + 1..=j].to_vec());
                waiting.push([&curve[..=i], &curve[j + 1..]].concat());
            }
            None => simple.push(curve),
        }
    }
    simple
}

/// The first two sides of a closed curve that cross, by the index of the point where each begins.
fn crossing(points: &[Point2<f64>], curve: &[usize]) -> Option<(usize, usize)> {
    let n = curve.len();
    let side = |i: usize| [points[curve[i]], points[curve[(i + 1) % n]]];
    (0..n).find_map(|i| {
        let last = if i == 0 { n.saturating_sub(1) } else { n };
        (i + 2..last).find(|j| cross(side(i), side(*j))).map(|j| (i, j))
    })
}

/// Whether two sides cross.
fn cross(one: [Point2<f64>; 2], other: [Point2<f64>; 2]) -> bool {
    let ([a, b], [c, d]) = (one, other);
    if a.x.max(b.x) < c.x.min(d.x) || c.x.max(d.x) < a.x.min(b.x) {
        return false;
    }
    let side = |p: &Point2<f64>, q: &Point2<f64>, r: &Point2<f64>| (q - p).perp(&(r - p));
    side(&a, &b, &c) * side(&a, &b, &d) < 0.0 && side(&c, &d, &a) * side(&c, &d, &b) < 0.0
}

/// Area of a closed polygon, px²; positive if the inside is on the left as seen on the screen (y down).
pub fn area_on_the_left(points: &[Point2<f64>]) -> f64 {
    let next = points.iter().cycle().skip(1);
    0.5 * points.iter().zip(next).map(|(a, b)| b.x * a.y - a.x * b.y).sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_eight_is_two_loops_and_a_square_is_one() {
        let eight: Vec<_> = (0..40)
            .map(|i| f64::from(i) * std::f64::consts::TAU / 40.0 + 0.03)
            .map(|a| Point2::new(20.0 * a.sin(), 10.0 * (2.0 * a).sin()))
            .collect();
        let found = loops(&eight);
        assert_eq!(found.len(), 2);
        assert_eq!(found.iter().map(Vec::len).sum::<usize>(), 40);
        let square =
            [(0.0, 0.0), (9.0, 0.0), (9.0, 9.0), (0.0, 9.0)].map(|(x, y)| Point2::new(x, y));
        assert_eq!(loops(&square), [[0, 1, 2, 3]]);
        assert!(area_on_the_left(&square) < 0.0);
    }
}
