//! One thing among points: those that hang together.

use std::collections::BTreeMap;

use nalgebra::Point3;

use crate::stereo::CloudPoint;

/// Edge of a cell, m: gaps of less than a cell are none, as between a sleeve and the hand where stereo saw nothing.
const CELL: f64 = 0.08;

type Cell = [i64; 3];

/// The points of the largest group of touching cells, in their order.
///
/// What moves in a room is a person and a little of everything else: a curtain, a screen, and matches that are false. The person is the
/// largest thing that hangs together; cells of [`CELL`] touch across faces, edges and corners.
pub(super) fn largest(points: Vec<CloudPoint>) -> Vec<CloudPoint> {
    let mut cells: BTreeMap<Cell, Vec<usize>> = BTreeMap::new();
    for (i, point) in points.iter().enumerate() {
        if point.position_world.coords.iter().all(|x| x.is_finite()) {
            cells
                .entry(cell(&point.position_world))
                .or_default()
                .push(i);
        }
    }
    let mut best: Vec<usize> = Vec::new();
    while let Some(start) = cells.keys().next().copied() {
        let group = taken_with(start, &mut cells);
        if group.len() > best.len() {
            best = group;
        }
    }
    best.sort_unstable();
    best.into_iter().map(|i| points[i]).collect()
}

/// Takes a cell and all that hangs together with it out of `cells`.
fn taken_with(start: Cell, cells: &mut BTreeMap<Cell, Vec<usize>>) -> Vec<usize> {
    let mut group = cells.remove(&start).unwrap_or_default();
    let mut open = vec![start];
    while let Some(at) = open.pop() {
        for k in 0..27 {
            let next = [at[0] + k % 3 - 1, at[1] + k / 3 % 3 - 1, at[2] + k / 9 - 1];
            if let Some(points) = cells.remove(&next) {
                group.extend(points);
                open.push(next);
            }
        }
    }
    group
}

fn cell(point: &Point3<f64>) -> Cell {
    [0, 1, 2].map(|k| (point[k] / CELL).floor() as i64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stereo::Spread;

    fn row(x: f64, count: usize) -> impl Iterator<Item = CloudPoint> {
        (0..count).map(move |i| CloudPoint {
            position_world: Point3::new(x, 0.0, 0.1 * i as f64),
            spread: Spread::Full(nalgebra::Matrix3::identity()),
        })
    }

    #[test]
    fn the_larger_of_two_rows_stays_in_its_order_and_strays_go() {
        let points: Vec<_> = row(2.0, 5)
            .chain(row(0.0, 12))
            .chain(row(-3.0, 1))
            .collect();
        let kept = largest(points.clone());
        assert_eq!(kept, points[5..17]);
        assert!(largest(Vec::new()).is_empty());
    }

    #[test]
    fn a_point_that_is_nowhere_belongs_to_nothing() {
        let mut points: Vec<_> = row(0.0, 3).collect();
        points[1].position_world.x = f64::NAN;
        points[2].position_world.z = 0.1;
        assert_eq!(largest(points.clone()).len(), 2);
    }
}
