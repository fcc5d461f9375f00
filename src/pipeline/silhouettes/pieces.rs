//! Points that hang together, and the things that they show.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BTreeSet};

use nalgebra::{Point3, Vector2};

use super::staying::REACH_M;
use crate::math::stats::median;
use crate::stereo::CloudPoint;

/// Edge of the cells by which points hang together, m.
const CELL_M: f64 = 0.1;
/// A cell of fewer points is stray.
const LEAST_IN_CELL: usize = 3;

/// A piece, or what moves at a place, of fewer points than this share of the largest is no thing of its own (E).
pub(super) const LEAST_OF_LARGEST: f64 = 0.2;
/// At most so many things are told apart.
pub(super) const MOST_THINGS: usize = 3;

/// Neighbouring cells, and how many points are in them.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Piece {
    cells: BTreeSet<[i64; 3]>,
    pub(super) count: usize,
}

impl Piece {
    /// Whether a place is in one of its cells.
    pub(super) fn holds(&self, place: &Point3<f64>) -> bool {
        self.cells.contains(&cell(place))
    }

    /// Those of some points that are in it.
    pub(super) fn of(&self, points: &[CloudPoint]) -> Vec<CloudPoint> {
        points.iter().filter(|p| self.holds(&p.position_world)).copied().collect()
    }

    /// Takes over the cells of another.
    fn join(&mut self, other: Self) {
        self.cells.extend(other.cells);
        self.count += other.count;
    }
}

/// The sets of neighbouring cells that some points are in, the one of most points first.
fn pieces(points: &[CloudPoint]) -> Vec<Piece> {
    let mut counts: BTreeMap<[i64; 3], usize> = BTreeMap::new();
    for point in points {
        *counts.entry(cell(&point.position_world)).or_default() += 1;
    }
    counts.retain(|_, count| *count >= LEAST_IN_CELL);

    // from any cell that is left, all that hang together with it
    let mut pieces = Vec::new();
    while let Some((first, count)) = counts.pop_first() {
        let (mut piece, mut waiting) =
            (Piece { cells: BTreeSet::from([first]), count }, vec![first]);
        while let Some([x, y, z]) = waiting.pop() {
            for k in 0..27 {
                let next = [x + k % 3 - 1, y + k / 3 % 3 - 1, z + k / 9 - 1];
                if let Some(count) = counts.remove(&next) {
                    piece.cells.insert(next);
                    piece.count += count;
                    waiting.push(next);
                }
            }
        }
        pieces.push(piece);
    }
    pieces.sort_by_key(|piece| Reverse(piece.count));
    pieces
}

/// The points in the largest piece.
pub(super) fn largest_piece(points: &[CloudPoint]) -> Vec<CloudPoint> {
    pieces(points).first().map(|largest| largest.of(points)).unwrap_or_default()
}

/// The things that some points show, the largest first: pieces that are large enough, those of one place together.
///
/// Legs and trunk of a person can be two pieces, one above the other.
pub(super) fn things(points: &[CloudPoint]) -> Vec<Piece> {
    let mut pieces = pieces(points);
    let largest = pieces.first().map_or(0, |piece| piece.count);
    pieces.retain(|piece| piece.count as f64 >= LEAST_OF_LARGEST * largest as f64);

    let mut things: Vec<(Vector2<f64>, Piece)> = Vec::new();
    for piece in pieces {
        let Some(place) = middle(&piece.of(points)) else {
            continue;
        };
        match things.iter_mut().find(|(larger, _)| (*larger - place).norm() < REACH_M) {
            Some((_, thing)) => thing.join(piece),
            None => things.push((place, piece)),
        }
    }
    things.truncate(MOST_THINGS);
    things.into_iter().map(|(_, thing)| thing).collect()
}

/// The median place of some points, seen from above; `None` without points.
pub(super) fn middle(points: &[CloudPoint]) -> Option<Vector2<f64>> {
    let along = |axis: usize| median(&mut points.iter().map(|p| p.position_world[axis]).collect());
    Some(Vector2::new(along(0)?, along(1)?))
}

fn cell(place: &Point3<f64>) -> [i64; 3] {
    place.coords.map(|x| (x / CELL_M).floor() as i64).into()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stereo::Spread;

    fn points(place: impl Fn(f64) -> [f64; 3], count: usize) -> Vec<CloudPoint> {
        let at =
            |place: [f64; 3]| CloudPoint { position_world: place.into(), spread: Spread::Unknown };
        (0..count).map(|i| at(place(i as f64))).collect()
    }

    #[test]
    fn of_two_pieces_the_larger_comes_first_and_strays_are_in_none() {
        let near = points(|i| [0.01 * i, 0.0, 1.0], 90);
        let far = points(|i| [5.0 + 0.01 * i, 0.0, 1.0], 30);
        let stray = points(|_| [2.0, 0.0, 1.0], 1);
        let all = [near, far, stray].concat();
        let found = pieces(&all);
        assert_eq!(found.iter().map(|piece| piece.count).collect::<Vec<_>>(), [90, 30]);
        assert!(
            found[1].holds(&all[95].position_world) && !found[0].holds(&all[95].position_world)
        );
        assert_eq!(largest_piece(&all).len(), 90);
    }

    #[test]
    fn trunk_and_legs_are_one_thing_a_cart_is_another_and_a_hand_is_none() {
        let trunk = points(|i| [0.0, 0.0, 0.9 + 0.005 * i], 100);
        let legs = points(|i| [0.1, 0.2, 0.01 * i], 50);
        let cart = points(|i| [1.0 + 0.01 * i, 1.0, 0.3], 70);
        let hand = points(|i| [-1.0, 0.0, 1.0 + 0.01 * i], 10);
        let found = things(&[trunk, legs, cart, hand].concat());
        assert_eq!(found.iter().map(|thing| thing.count).collect::<Vec<_>>(), [150, 70]);
        assert!(found[0].holds(&Point3::new(0.1, 0.2, 0.3)));
    }
}
