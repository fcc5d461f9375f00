//! The grid on which the surface of a part is offset.
//!
//! A part is divided about every 10 cm along its longest axis, and into quarters around it. Of the hat functions φ of this grid four are
//! not 0 at a place, and they add up to one. Both sides of the body are alike: the place of a left part is that of its mirror image
//! on the right, and a part in the middle has one half.

use std::ops::Range;

use nalgebra::Vector3;

/// Distance of the nodes along a part, metres: errors of the surface go together over so much.
const ALONG_M: f64 = 0.1;
/// Nodes around a part.
const AROUND: usize = 4;
/// Nearer to the axis than the root of this, m², a place has no direction around it.
const LEAST_SQUARE: f64 = 1e-6;

/// The nodes of one part.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Grid {
    /// x, y or z of the part: along it.
    axis: usize,
    /// The first node along it, and the distance to the next, metres.
    low_m: f64,
    step_m: f64,
    /// Nodes along it.
    along: usize,
    /// The axis around which the others stand, metres.
    centre: Vector3<f64>,
    /// The first coefficient.
    first: usize,
    side: GridSide,
}

/// How the places of the left side are those of the right one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum GridSide {
    Right,
    Left,
    /// Both halves of the part are one.
    Middle,
}

impl Grid {
    /// Of the box around a part's flesh, its least and greatest x, y, z; the coefficients begin with `first`.
    pub(super) fn new(
        (low, high): (Vector3<f64>, Vector3<f64>),
        side: GridSide,
        first: usize,
    ) -> Self {
        let (extent, mut centre) = (high - low, 0.5 * (low + high));
        let axis = if extent.x > extent.z { 0 } else { 2 };
        if side == GridSide::Middle {
            centre.y = 0.0;
        }

        let intervals = (extent[axis] / ALONG_M).round().max(1.0);
        let low_m = low[axis] - centre[axis];
        let step_m = extent[axis] / intervals;
        Self { axis, low_m, step_m, along: intervals as usize + 1, centre, first, side }
    }

    /// That of the left part, of the right part's.
    pub(super) fn mirrored(self) -> Self {
        let centre = self.centre.component_mul(&Vector3::new(1.0, -1.0, 1.0));
        Self { side: GridSide::Left, centre, ..self }
    }

    /// Nodes around: a quarter each; of a half, its two ends and its middle.
    fn around(self) -> usize {
        if self.side == GridSide::Middle { AROUND / 2 + 1 } else { AROUND }
    }

    pub(super) fn nodes(self) -> usize {
        self.along * self.around()
    }

    /// The coefficients of its nodes.
    pub(super) fn coefficients(self) -> Range<usize> {
        self.first..self.first + self.nodes()
    }

    /// The nodes around a place.
    pub(super) fn cell(self, place: &Vector3<f64>) -> Cell {
        let mut place = place - self.centre;
        let mirror = match self.side {
            GridSide::Right => 1.0,
            GridSide::Left => -1.0,
            GridSide::Middle => place.y.signum(),
        };
        place.y *= mirror;

        // along: beyond the ends b stays
        let last = (self.along - 1) as f64;
        let t = (place[self.axis] - self.low_m) / self.step_m;
        let is_between = (0.0..last).contains(&t);
        let t = t.clamp(0.0, last);
        let row = (t.floor() as usize).min(self.along.saturating_sub(2));
        let (next_row, t) = ((row + 1).min(self.along - 1), t - row as f64);

        // around: y is always one of the two axes across
        let across_axis = if self.axis == 0 { 2 } else { 0 };
        let across = place[across_axis];
        let quarter = std::f64::consts::TAU / AROUND as f64;
        let u = place.y.atan2(across).rem_euclid(std::f64::consts::TAU) / quarter;
        let column = u.floor() as usize;
        let u = u - column as f64;
        let around = self.around();
        let wrapped = |column: usize| match self.side {
            GridSide::Middle => column.min(around - 1),
            _ => column % around,
        };
        let (column, next) = (wrapped(column), wrapped(column + 1));

        let per_square = 1.0 / (quarter * (across * across + place.y * place.y).max(LEAST_SQUARE));
        let mut by_u = Vector3::zeros();
        by_u.y = mirror * across * per_square;
        by_u[across_axis] = -place.y * per_square;
        let mut by_t = Vector3::zeros();
        by_t[self.axis] = if is_between { 1.0 / self.step_m } else { 0.0 };

        let node = |row: usize, column: usize| self.first + row * around + column;
        Cell {
            nodes: [
                [node(row, column), node(row, next)],
                [node(next_row, column), node(next_row, next)],
            ],
            at: [t, u],
            slopes: [by_t, by_u],
        }
    }
}

/// Four nodes, and where a place lies between them.
#[derive(Debug, Clone, Copy)]
pub(super) struct Cell {
    /// [along][around].
    nodes: [[usize; 2]; 2],
    /// t and u: 0 at the first node, 1 at the second.
    at: [f64; 2],
    /// Their slopes by the place, in the part's axes, 1/m.
    slopes: [Vector3<f64>; 2],
}

impl Cell {
    /// φ of each node.
    pub(super) fn hats(&self) -> [(usize, f64); 4] {
        let ([[a, b], [c, d]], [t, u]) = (self.nodes, self.at);
        [(a, (1.0 - t) * (1.0 - u)), (b, (1.0 - t) * u), (c, t * (1.0 - u)), (d, t * u)]
    }

    /// The gradient of what has these values at the nodes.
    pub(super) fn gradient(&self, value: impl Fn(usize) -> f64) -> Vector3<f64> {
        let ([[a, b], [c, d]], [t, u]) = (self.nodes.map(|row| row.map(&value)), self.at);
        let by_t = (1.0 - u) * (c - a) + u * (d - b);
        let by_u = (1.0 - t) * (b - a) + t * (d - c);
        self.slopes[0] * by_t + self.slopes[1] * by_u
    }
}
