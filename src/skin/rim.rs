//! Where a limb grows out of another tube: a loop of vertices that both share.

use std::f64::consts::PI;

use nalgebra::Vector3;

use super::flesh::{Flesh, Hit};
use super::surface::{Grid, Surface};

/// Radius of a hole, over that of the limb.
const ROOM: f64 = 1.25;
/// How far the ridge between two limbs may lie outside the trunk's own flesh, metres.
const RIDGE: f64 = 0.03;

/// A closed loop of vertices that a limb begins with.
#[derive(Debug, Clone)]
pub(super) struct Rim {
    /// Counter-clockwise about the way into the limb.
    pub(super) vertices: Vec<u32>,
    /// The direction into the limb in a pose in which it does not bend; `None`: square to the rim.
    pub(super) straight_on: Option<Vector3<f64>>,
}

/// The rims of two limbs that grow out of the first row of a trunk, as legs do, the one on the side of angle −π/2 first.
///
/// Each is one half of that row and the ridge between the limbs, which both share: from the back (angle π) below the
/// trunk to the front (angle 0). `middle` is a place within the flesh, between the limbs; `trunk` is the trunk's flesh, and
/// `whole` that of trunk and limbs. `None` if the ridge finds no skin.
pub(super) fn fork(
    surface: &mut Surface,
    grid: &Grid,
    middle: &Vector3<f64>,
    trunk: &Flesh,
    whole: &Flesh,
    per_m: f64,
) -> Option<[Rim; 2]> {
    let (first, half) = (&grid.rows[0], grid.columns / 2);
    let ends = [first[0], first[half]].map(|i| surface.vertices[i as usize]);
    let above = (surface.positions(first).iter().sum::<Vector3<f64>>()) / first.len() as f64;
    let down = (middle - above).try_normalize(1e-6)?;

    let line = ridge(middle, &down, ends, trunk, whole)?;
    let length: f64 = line.windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum();
    let count = ((length * per_m).round() as usize).max(4);
    let ridge: Vec<u32> =
        (1..count).map(|k| surface.add(along(&line, length * k as f64 / count as f64))).collect();

    let side = |from: usize, to: usize| (to..=from).rev().map(|j| first[j % grid.columns]);
    let right = side(grid.columns, half).chain(ridge.iter().rev().copied());
    let left = side(half, 0).chain(ridge.iter().copied());
    Some(
        [right.collect(), left.collect()].map(|vertices| Rim { vertices, straight_on: Some(down) }),
    )
}

/// The ridge between two limbs, from its front end to its back end: where rays in the plane between the limbs leave the flesh.
fn ridge(
    middle: &Vector3<f64>,
    down: &Vector3<f64>,
    ends: [Vector3<f64>; 2],
    trunk: &Flesh,
    whole: &Flesh,
) -> Option<Vec<Vector3<f64>>> {
    let front = ends[0] - ends[1];
    let front = (front - down * front.dot(down)).try_normalize(1e-6)?;
    let angle = |end: &Vector3<f64>| {
        let to = end - middle;
        to.dot(down).atan2(to.dot(&front))
    };
    let begin = angle(&ends[0]);
    let mut sweep = angle(&ends[1]) - begin;
    if sweep <= 0.0 {
        sweep += 2.0 * PI;
    }

    // on the trunk's skin, or on that of the limbs where it lies a little farther out
    let point = |share: f64| {
        let angle = begin + sweep * share;
        let ray = front * angle.cos() + down * angle.sin();
        let reach = match trunk.cast(middle, &ray, 0.5) {
            Hit::Skin(reach) => reach,
            Hit::Flesh(_) | Hit::Nothing => return None,
        };
        let farther = match whole.cast(middle, &ray, reach + RIDGE) {
            Hit::Skin(farther) => farther,
            Hit::Flesh(_) | Hit::Nothing => reach,
        };
        Some(middle + ray * farther.max(reach))
    };

    let between = (1..32).map(|k| point(f64::from(k) / 32.0));
    let between: Vec<_> = between.collect::<Option<_>>()?;
    let front_end = std::iter::once(ends[0]);
    Some(front_end.chain(between).chain([ends[1]]).collect())
}

/// The point of a polyline at a distance along it.
fn along(line: &[Vector3<f64>], distance: f64) -> Vector3<f64> {
    let mut left = distance;
    for pair in line.windows(2) {
        let length = (pair[1] - pair[0]).norm();
        if left <= length {
            return pair[0] + (pair[1] - pair[0]) * (left / length.max(1e-12));
        }
        left -= length;
    }
    line[line.len() - 1]
}

/// Cuts a hole into a grid where a limb of this radius at its root grows out; its rim is counter-clockwise seen from
/// outside. `None` if there is no room: at an end of the tube, or beside another hole.
pub(super) fn hole(
    surface: &Surface,
    grid: &mut Grid,
    root: &Vector3<f64>,
    radius: f64,
) -> Option<Rim> {
    let (rows, columns) = (grid.rows.len(), grid.columns);
    let place = |i: usize, j: usize| surface.vertices[grid.rows[i][j % columns] as usize];

    // the vertex nearest to the root, in rows that are no pole and no end
    let inner = 1..rows - 1;
    let all = inner.clone().flat_map(|i| (0..columns).map(move |j| (i, j)));
    let distance = |&(i, j): &(usize, usize)| (place(i, j) - root).norm();
    let middle = all.clone().min_by(|a, b| distance(a).total_cmp(&distance(b)))?;
    let centre = place(middle.0, middle.1);

    // the rectangle of all vertices near it, columns counted from its own
    let mut low = [middle.0 as isize - 1, -1];
    let mut high = [middle.0 as isize + 1, 1];
    for (i, j) in all {
        if (place(i, j) - centre).norm() < ROOM * radius {
            let turn = (j + columns + columns / 2 - middle.1) % columns;
            let at = [i as isize, turn as isize - (columns / 2) as isize];
            for k in 0..2 {
                low[k] = low[k].min(at[k]);
                high[k] = high[k].max(at[k]);
            }
        }
    }

    // between the ends, and at most half around
    let is_within = low[0] >= 1 && high[0] <= rows as isize - 2;
    if !is_within || high[1] - low[1] > (columns / 2) as isize {
        return None;
    }

    let column = |j: isize| (j + (middle.1 + columns) as isize) as usize % columns;
    let cells: Vec<usize> = (low[0]..high[0])
        .flat_map(|i| (low[1]..high[1]).map(move |j| i as usize * columns + column(j)))
        .collect();
    // not even a corner may touch another hole
    let around = (low[0] - 1..=high[0])
        .flat_map(|i| (low[1] - 1..=high[1]).map(move |j| i as usize * columns + column(j)));
    if around.into_iter().any(|cell| grid.removed[cell]) {
        return None;
    }
    cells.into_iter().for_each(|cell| grid.removed[cell] = true);

    // counter-clockwise around the rectangle
    let at = |i: isize, j: isize| grid.rows[i as usize][column(j)];
    let bottom = (low[1]..high[1]).map(|j| at(low[0], j));
    let ahead = (low[0]..high[0]).map(|i| at(i, high[1]));
    let top = (low[1] + 1..=high[1]).rev().map(|j| at(high[0], j));
    let back = (low[0] + 1..=high[0]).rev().map(|i| at(i, low[1]));
    Some(Rim { vertices: bottom.chain(ahead).chain(top).chain(back).collect(), straight_on: None })
}
