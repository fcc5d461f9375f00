//! The true surface: triangles whose vertices are the same in every frame.

use std::collections::HashMap;
use std::path::Path;

use nalgebra::{Point3, Vector3};

use crate::Fault;

/// Triangles are looked for in cells of this size around a point, m.
const CELL: f64 = 0.06;

/// A surface of one frame.
pub(crate) struct Mesh {
    pub(crate) vertices: Vec<Point3<f64>>,
    triangles: Vec<[usize; 3]>,
    cells: HashMap<[i64; 3], Vec<usize>>,
}

/// A place on the surface: a triangle, and the weights of its corners.
#[derive(Clone, Copy)]
pub(crate) struct Place {
    pub(crate) triangle: usize,
    pub(crate) weights: [f64; 3],
}

impl Mesh {
    /// Reads a binary PLY of floats with triangles.
    pub(crate) fn read(path: &Path) -> Result<Self, Fault> {
        let bytes = std::fs::read(path)?;
        let end = b"end_header\n";
        let at = bytes.windows(end.len()).position(|w| w == end).ok_or("no header")? + end.len();
        let header = String::from_utf8_lossy(&bytes[..at]).into_owned();
        let count = |what: &str| -> Result<usize, Fault> {
            let line = header.lines().find_map(|l| l.strip_prefix(what)).ok_or("no element")?;
            Ok(line.trim().parse()?)
        };
        let (vertices, faces) = (count("element vertex ")?, count("element face ")?);
        let body =
            bytes.get(at..).filter(|b| b.len() >= 12 * vertices + 13 * faces).ok_or("too short")?;
        let number = |b: &[u8]| [b[0], b[1], b[2], b[3]];
        let (points, faces) = body.split_at(12 * vertices);
        let vertices = points
            .chunks_exact(12)
            .map(|b| {
                Point3::from([0, 4, 8].map(|i| f64::from(f32::from_le_bytes(number(&b[i..])))))
            })
            .collect();
        let triangles = faces
            .chunks_exact(13)
            .map(|b| [1, 5, 9].map(|i| i32::from_le_bytes(number(&b[i..])) as usize))
            .collect();
        Ok(Self { vertices, triangles, cells: HashMap::new() }.sorted())
    }

    fn sorted(mut self) -> Self {
        for (i, triangle) in self.triangles.iter().enumerate() {
            let middle =
                triangle.iter().map(|v| self.vertices[*v].coords).sum::<Vector3<f64>>() / 3.0;
            self.cells.entry(cell(&middle.into())).or_default().push(i);
        }
        self
    }

    /// The nearest place of the surface and its distance, m; `None` beyond 6 cm.
    pub(crate) fn nearest(&self, point: &Point3<f64>) -> Option<(f64, Place)> {
        let [x, y, z] = cell(point);
        let around = (0..27).map(|i| [x + i % 3 - 1, y + i / 3 % 3 - 1, z + i / 9 - 1]);
        let near = around.filter_map(|cell| self.cells.get(&cell)).flatten();
        let distances = near.map(|triangle| {
            let weights = closest(self.triangles[*triangle].map(|v| self.vertices[v]), point);
            let place = Place { triangle: *triangle, weights };
            ((self.at(&place) - point).norm(), place)
        });
        distances.min_by(|a, b| a.0.total_cmp(&b.0)).filter(|found| found.0 <= CELL)
    }

    /// Where a place is in this frame.
    pub(crate) fn at(&self, place: &Place) -> Point3<f64> {
        let corners = self.triangles[place.triangle];
        let sum = corners.iter().zip(place.weights).map(|(v, w)| self.vertices[*v].coords * w);
        sum.sum::<Vector3<f64>>().into()
    }
}

fn cell(point: &Point3<f64>) -> [i64; 3] {
    [0, 1, 2].map(|i| (point[i] / CELL).floor() as i64)
}

/// Weights of the corners of a triangle's point nearest to `p` (Ericson, Real-Time Collision Detection, 5.1.5).
fn closest([a, b, c]: [Point3<f64>; 3], p: &Point3<f64>) -> [f64; 3] {
    let (ab, ac) = (b - a, c - a);
    let (d1, d2) = (ab.dot(&(p - a)), ac.dot(&(p - a)));
    let (d3, d4) = (ab.dot(&(p - b)), ac.dot(&(p - b)));
    let (d5, d6) = (ab.dot(&(p - c)), ac.dot(&(p - c)));
    let (va, vb, vc) = (d3 * d6 - d5 * d4, d5 * d2 - d1 * d6, d1 * d4 - d3 * d2);
    if d1 <= 0.0 && d2 <= 0.0 {
        [1.0, 0.0, 0.0]
    } else if d3 >= 0.0 && d4 <= d3 {
        [0.0, 1.0, 0.0]
    } else if d6 >= 0.0 && d5 <= d6 {
        [0.0, 0.0, 1.0]
    } else if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        let t = d1 / (d1 - d3);
        [1.0 - t, t, 0.0]
    } else if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        let t = d2 / (d2 - d6);
        [1.0 - t, 0.0, t]
    } else if va <= 0.0 && d4 >= d3 && d5 >= d6 {
        let t = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        [0.0, 1.0 - t, t]
    } else {
        let sum = va + vb + vc;
        [va / sum, vb / sum, vc / sum]
    }
}
