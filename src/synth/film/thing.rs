//! Things with a surface and a texture, from which a room is made.

use nalgebra::{Rotation3, Vector3};
use rand::{Rng, RngExt};

use super::texture::Texture;

/// Triangles with one texture.
#[derive(Debug, Clone)]
pub(super) struct Thing {
    pub(super) vertices: Vec<Vector3<f64>>,
    pub(super) triangles: Vec<[u32; 3]>,
    /// Where in the texture each vertex lies, metres.
    pub(super) places: Vec<Vector3<f64>>,
    pub(super) texture: Texture,
}

/// How thick shelves and boards are, metres.
const BOARD: f64 = 0.02;

impl Thing {
    /// A box upright on z = `low.z`, turned about its own middle.
    pub(super) fn cuboid(
        low: Vector3<f64>,
        high: Vector3<f64>,
        turn: f64,
        texture: Texture,
    ) -> Self {
        let middle = (low + high) * 0.5;
        let about = Rotation3::from_axis_angle(&Vector3::z_axis(), turn);
        let corner = |k: usize| {
            let side = |axis: usize| {
                if k >> axis & 1 == 0 { low[axis] } else { high[axis] }
            };
            middle + about * (Vector3::new(side(0), side(1), side(2)) - middle)
        };
        let vertices: Vec<_> = (0..8).map(corner).collect();

        // corner k lies at high x, y, z where bit 0, 1, 2 is set
        let faces =
            [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]];
        Self {
            places: vertices.clone(),
            triangles: faces.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect(),
            vertices,
            texture,
        }
    }

    /// A sheet of `columns` × `rows` pieces; `at` takes (0, 0) to (1, 1) to a place.
    pub(super) fn sheet(
        columns: usize,
        rows: usize,
        at: impl Fn(f64, f64) -> Vector3<f64>,
        texture: Texture,
    ) -> Self {
        let place = |k: usize| {
            let (i, j) = (k % (columns + 1), k / (columns + 1));
            at(i as f64 / columns as f64, j as f64 / rows as f64)
        };
        let vertices: Vec<_> = (0..(columns + 1) * (rows + 1)).map(place).collect();

        let quad = |k: usize| {
            let a = (k / columns * (columns + 1) + k % columns) as u32;
            let below = a + columns as u32 + 1;
            [[a, a + 1, below + 1], [a, below + 1, below]]
        };

        Self {
            places: vertices.clone(),
            triangles: (0..columns * rows).flat_map(quad).collect(),
            vertices,
            texture,
        }
    }

    /// A shelf that is open to the front, as boards, with books on each.
    pub(super) fn shelf(
        corner: Vector3<f64>,
        width: f64,
        height: f64,
        rng: &mut impl Rng,
    ) -> Vec<Self> {
        let depth = 0.28;
        let wood = Texture::wooden(rng);
        let board = |low: [f64; 3], high: [f64; 3]| {
            Self::cuboid(corner + Vector3::from(low), corner + Vector3::from(high), 0.0, wood)
        };

        // back and sides
        let mut all = vec![
            board([0.0, 0.0, 0.0], [depth, BOARD, height]),
            board([0.0, width - BOARD, 0.0], [depth, width, height]),
            board([0.0, 0.0, 0.0], [BOARD, width, height]),
        ];

        // boards, each but the highest with books
        let storeys = (height / 0.36).ceil() as usize;
        for storey in 0..=storeys {
            let z = height * storey as f64 / storeys as f64;
            all.push(board([0.0, 0.0, z - BOARD], [depth, width, z]));
            let mut y = BOARD + 0.01;
            while y < width - 0.08 && storey < storeys {
                let (thick, tall) = (rng.random_range(0.03..0.09), rng.random_range(0.16..0.29));
                let low = corner + Vector3::new(BOARD, y, z);
                let high = low + Vector3::new(rng.random_range(0.15..0.24), thick, tall);
                all.push(Self::cuboid(low, high, 0.0, Texture::printed(rng)));
                y += thick + 0.004;
            }
        }
        all
    }

    /// A pot with leaves on stems, each a rhombus that hangs outwards.
    pub(super) fn plant(foot: Vector3<f64>, height: f64, rng: &mut impl Rng) -> Vec<Self> {
        let (low, high) =
            (foot - Vector3::new(0.12, 0.12, 0.0), foot + Vector3::new(0.12, 0.12, 0.3));

        let green = [0.16, rng.random_range(0.3..0.5), 0.12];
        let mut leaves = Self {
            vertices: Vec::new(),
            triangles: Vec::new(),
            places: Vec::new(),
            texture: Texture { contrast: 1.5, ..Texture::plain(green, 0.6, rng) },
        };

        for _ in 0..70 {
            let (sin, cos) = rng.random_range(0.0..std::f64::consts::TAU).sin_cos();
            let outward = Vector3::new(cos, sin, 0.0);
            let base = foot
                + Vector3::z() * rng.random_range(0.4..height)
                + outward * rng.random_range(0.0..0.12);
            let along = (outward + Vector3::z() * rng.random_range(-0.6..0.8))
                * rng.random_range(0.12..0.26);
            let across =
                Vector3::new(-sin, cos, rng.random_range(-0.5..0.5)) * rng.random_range(0.03..0.06);
            leaves.add_leaf(base, along, across);
        }

        vec![Self::cuboid(low, high, 0.3, Texture::printed(rng)), leaves]
    }

    fn add_leaf(&mut self, base: Vector3<f64>, along: Vector3<f64>, across: Vector3<f64>) {
        let first = self.vertices.len() as u32;
        let droop = Vector3::z() * -0.3 * along.norm();
        let middle = base + along * 0.5;
        let corners = [base, middle + across, base + along + droop, middle - across];
        self.vertices.extend(corners);
        self.places.extend(corners);
        self.triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
    }
}
