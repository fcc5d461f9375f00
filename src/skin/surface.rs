//! Patches to triangles: one surface that all tubes share.

use nalgebra::Vector3;

use super::flesh::{Flesh, TubeFlesh};
use super::mesh::Mesh;
use super::patch::Patch;
use super::tube::Tube;
use super::{Finish, SkinOptions};

/// Points along each row of control points at which the length of a patch is measured.
const FINE: usize = 6;
/// Columns along which it is measured.
const MEASURED: usize = 16;

/// The vertices and triangles of all tubes so far.
#[derive(Debug, Clone, Default)]
pub(super) struct Surface {
    pub(super) vertices: Vec<Vector3<f64>>,
    triangles: Vec<[u32; 3]>,
}

/// The vertices of a tessellated tube; a row of one vertex is a pole.
#[derive(Debug, Clone)]
pub(super) struct Grid {
    pub(super) rows: Vec<Vec<u32>>,
    pub(super) columns: usize,
    /// Cells that are no surface, row by row.
    pub(super) removed: Vec<bool>,
}

impl Surface {
    /// Adds a vertex.
    pub(super) fn add(&mut self, position: Vector3<f64>) -> u32 {
        self.vertices.push(position);
        (self.vertices.len() - 1) as u32
    }

    /// Places of vertices.
    pub(super) fn positions(&self, ids: &[u32]) -> Vec<Vector3<f64>> {
        ids.iter().map(|i| self.vertices[*i as usize]).collect()
    }

    /// Tessellates a tube; if it grows out of a rim, the rim's vertices are its first row.
    ///
    /// Rows stand evenly along the mean column. `None` if the tube has too few rows for a patch.
    pub(super) fn tessellate(
        &mut self,
        tube: &Tube,
        rim: Option<&[u32]>,
        flesh: TubeFlesh<'_>,
        options: &SkinOptions,
    ) -> Option<Grid> {
        let patch = Patch::new(&tube.rows)?;
        let columns = tube.rows[0].len();
        let joint_end = patch.place_of_row(tube.joint);
        let places = even_places(&patch, options.along_per_m);
        let last = places.len() - 1;

        let mut rows = Vec::with_capacity(places.len());
        for (i, v) in places.into_iter().enumerate() {
            let pole = match i {
                0 => pole(&tube.rows[0]),
                i if i == last => pole(&tube.rows[tube.rows.len() - 1]),
                _ => None,
            };
            rows.push(match (i, rim, pole) {
                (0, Some(rim), _) => rim.to_vec(),
                (_, _, Some(pole)) => vec![self.add(pole)],
                _ => {
                    let is_joint = v < joint_end;
                    let flesh = if is_joint { flesh.with_base } else { flesh.own };
                    let points = (0..columns).map(|j| patch.at(j as f64 / columns as f64, v));
                    points.map(|point| self.add(finished(point, flesh, options.finish))).collect()
                }
            });
        }

        let removed = vec![false; (rows.len() - 1) * columns];
        Some(Grid { rows, columns, removed })
    }

    /// Adds the triangles of a grid's cells that are not removed.
    pub(super) fn close(&mut self, grid: &Grid) {
        for (i, pair) in grid.rows.windows(2).enumerate() {
            for j in 0..grid.columns {
                if grid.removed[i * grid.columns + j] {
                    continue;
                }

                let next = (j + 1) % grid.columns;
                match (pair[0].len(), pair[1].len()) {
                    (1, 1) => {}
                    (1, _) => self.triangles.push([pair[0][0], pair[1][next], pair[1][j]]),
                    (_, 1) => self.triangles.push([pair[0][j], pair[0][next], pair[1][0]]),
                    _ => self.quadrangle([pair[0][j], pair[0][next], pair[1][next], pair[1][j]]),
                }
            }
        }
    }

    /// Two triangles, divided along the shorter diagonal.
    fn quadrangle(&mut self, corners: [u32; 4]) {
        let [a, b, c, d] = corners;
        let distance =
            |i: u32, j: u32| (self.vertices[i as usize] - self.vertices[j as usize]).norm_squared();
        if distance(a, c) <= distance(b, d) {
            self.triangles.extend([[a, b, c], [a, c, d]]);
        } else {
            self.triangles.extend([[a, b, d], [b, c, d]]);
        }
    }

    /// The finished mesh, without the vertices within holes.
    pub(super) fn mesh(self) -> Mesh {
        // the new number of each vertex that a triangle uses
        let mut index = vec![None; self.vertices.len()];
        for corner in self.triangles.iter().flatten() {
            index[*corner as usize] = Some(0);
        }
        let kept = index.iter_mut().flatten();
        (0..).zip(kept).for_each(|(new, old)| *old = new);
        let is_kept = |(vertex, index): (Vector3<f64>, &Option<u32>)| index.map(|_| vertex);
        let vertices = self.vertices.into_iter().zip(&index).filter_map(is_kept);
        let corner = |old: u32| index[old as usize].unwrap_or_default();
        let triangles = self.triangles.iter().map(|t| t.map(corner));
        Mesh::new(vertices.collect(), triangles.collect())
    }
}

/// The point in which all points of a row lie; `None` if they are more than one.
fn pole(row: &[Vector3<f64>]) -> Option<Vector3<f64>> {
    row.iter().all(|point| *point == row[0]).then(|| row[0])
}

fn finished(point: Vector3<f64>, flesh: &Flesh, finish: Finish) -> Vector3<f64> {
    match finish {
        Finish::Spline => point,
        Finish::Field => flesh.settle(&point).unwrap_or(point),
    }
}

/// Places v along a patch, from 0 to 1, between which the mean column is of equal length.
fn even_places(patch: &Patch, per_m: f64) -> Vec<f64> {
    let fine = (patch.rows() - 3) * FINE;
    let column = |v: f64, k: usize| patch.at(k as f64 / MEASURED as f64, v);

    // length of the mean column up to each of many places
    let mut reached = vec![0.0];
    for i in 0..fine {
        let (v, w) = (i as f64 / fine as f64, (i + 1) as f64 / fine as f64);
        let steps = (0..MEASURED).map(|k| (column(w, k) - column(v, k)).norm());
        let mean = steps.sum::<f64>() / MEASURED as f64;
        reached.push(reached[i] + mean);
    }

    let length = reached[fine];
    let count = (length * per_m).round().max(3.0) as usize;
    let place = |row: usize| {
        let wanted = length * row as f64 / count as f64;
        let after = reached.partition_point(|r| *r < wanted).clamp(1, fine);
        let step = (reached[after] - reached[after - 1]).max(1e-12);
        ((after - 1) as f64 + (wanted - reached[after - 1]) / step) / fine as f64
    };
    (0..=count).map(|row| place(row).clamp(0.0, 1.0)).collect()
}
