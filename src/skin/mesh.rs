//! A surface of triangles, and whether it is closed.

use std::collections::BTreeMap;

use nalgebra::Vector3;

/// A surface of triangles in the world, metres.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Mesh {
    /// Corners.
    pub vertices: Vec<Vector3<f64>>,
    /// Outward direction at each corner, of length 1.
    pub normals: Vec<Vector3<f64>>,
    /// Corners of each triangle, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
}

impl Mesh {
    /// The mesh of corners and triangles; normals are the mean of the adjoining triangles', weighted by their angles.
    ///
    /// # Source
    /// Thürmer & Wüthrich 1998 (weights).
    pub fn new(vertices: Vec<Vector3<f64>>, triangles: Vec<[u32; 3]>) -> Self {
        let mut normals = vec![Vector3::zeros(); vertices.len()];
        for triangle in &triangles {
            let corners = triangle.map(|i| vertices[i as usize]);
            for k in 0..3 {
                let a = corners[(k + 1) % 3] - corners[k];
                let b = corners[(k + 2) % 3] - corners[k];
                if let Some(normal) = a.cross(&b).try_normalize(1e-18) {
                    normals[triangle[k] as usize] += normal * a.angle(&b);
                }
            }
        }

        let unit = |n: Vector3<f64>| n.try_normalize(1e-12).unwrap_or_else(Vector3::z);
        Self { vertices, normals: normals.into_iter().map(unit).collect(), triangles }
    }

    /// The volume that it encloses, cubic metres; positive if its triangles face outwards.
    ///
    /// V = Σ a · (b × c)/6 over the triangles (a, b, c) of a closed surface.
    pub fn volume(&self) -> f64 {
        let six_times = |triangle: &[u32; 3]| {
            let [a, b, c] = triangle.map(|i| self.vertices[i as usize]);
            a.dot(&b.cross(&c))
        };
        self.triangles.iter().map(six_times).sum::<f64>() / 6.0
    }

    /// Corners − edges + triangles: 2 for a closed surface without handles.
    pub fn euler_characteristic(&self) -> i64 {
        let edges: std::collections::BTreeSet<_> =
            self.triangles.iter().flat_map(edges).map(|[a, b]| [a.min(b), a.max(b)]).collect();
        self.vertices.len() as i64 - edges.len() as i64 + self.triangles.len() as i64
    }
}

fn edges(triangle: &[u32; 3]) -> [[u32; 2]; 3] {
    let [a, b, c] = *triangle;
    [[a, b], [b, c], [c, a]]
}

/// Why a mesh is not a closed surface.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum MeshFault {
    /// A triangle names a corner that does not exist, or one corner twice.
    #[error(
        "triangle {triangle}: expected three different corners below {vertices}, found {found:?}"
    )]
    Corners {
        /// Its index.
        triangle: usize,
        /// Number of vertices.
        vertices: usize,
        /// Its corners.
        found: [u32; 3],
    },
    /// An edge that does not belong to exactly one triangle in each direction.
    #[error(
        "edge {from}–{to}: expected one triangle on each side, found {forwards} that run along it and {backwards} against it"
    )]
    Edge {
        /// Corner.
        from: u32,
        /// Corner.
        to: u32,
        /// Triangles that run from `from` to `to`.
        forwards: usize,
        /// Triangles that run from `to` to `from`.
        backwards: usize,
    },
    /// A corner of no triangle.
    #[error("vertex {vertex} belongs to no triangle")]
    Unused {
        /// Its index.
        vertex: usize,
    },
}

/// Checks that a mesh is closed and consistently oriented: each edge has two triangles that run along it in opposite
/// directions.
///
/// # Errors
/// The first fault found.
pub fn check_watertight(mesh: &Mesh) -> Result<(), MeshFault> {
    let vertices = mesh.vertices.len();
    let mut used = vec![false; vertices];
    // of each edge, how many triangles run along it forwards and backwards
    let mut count: BTreeMap<[u32; 2], [usize; 2]> = BTreeMap::new();

    for (index, triangle) in mesh.triangles.iter().enumerate() {
        let [a, b, c] = *triangle;
        let is_there = triangle.iter().all(|i| (*i as usize) < vertices);
        if !is_there || a == b || b == c || c == a {
            return Err(MeshFault::Corners { triangle: index, vertices, found: *triangle });
        }

        for [from, to] in edges(triangle) {
            used[from as usize] = true;
            let backwards = usize::from(from > to);
            count.entry([from.min(to), from.max(to)]).or_default()[backwards] += 1;
        }
    }

    if let Some(vertex) = used.iter().position(|used| !used) {
        return Err(MeshFault::Unused { vertex });
    }
    match count.into_iter().find(|(_, runs)| *runs != [1, 1]) {
        None => Ok(()),
        Some(([from, to], [forwards, backwards])) => {
            Err(MeshFault::Edge { from, to, forwards, backwards })
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tetrahedron() -> Mesh {
        let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        Mesh::new(
            corners.map(Vector3::from).to_vec(),
            vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
        )
    }

    #[test]
    fn a_tetrahedron_is_closed_and_has_its_volume() {
        let mesh = tetrahedron();
        assert_eq!(check_watertight(&mesh), Ok(()));
        assert_eq!(mesh.euler_characteristic(), 2);
        approx::assert_relative_eq!(mesh.volume(), 1.0 / 6.0);
        let middle = Vector3::from_element(0.25);
        for (vertex, normal) in mesh.vertices.iter().zip(&mesh.normals) {
            assert!(normal.dot(&(vertex - middle)) > 0.0);
        }
    }

    #[test]
    fn a_hole_a_turned_triangle_and_a_loose_corner_are_found() {
        let mut hole = tetrahedron();
        hole.triangles.pop();
        assert!(matches!(check_watertight(&hole), Err(MeshFault::Edge { .. })));
        let mut turned = tetrahedron();
        turned.triangles[2].swap(0, 1);
        assert!(matches!(
            check_watertight(&turned),
            Err(MeshFault::Edge { forwards: 2, .. } | MeshFault::Edge { backwards: 2, .. })
        ));
        let mut loose = tetrahedron();
        loose.vertices.push(Vector3::zeros());
        assert_eq!(check_watertight(&loose), Err(MeshFault::Unused { vertex: 4 }));
        let mut nowhere = tetrahedron();
        nowhere.triangles[0][1] = 9;
        assert!(matches!(check_watertight(&nowhere), Err(MeshFault::Corners { triangle: 0, .. })));
    }
}
