//! The surface of a body of ellipsoids: a closed mesh for each of them, which one part carries.
//!
//! Such a body *is* the union of its ellipsoids, so the meshes are exact up to the size of their triangles. The point u of
//! the unit sphere stands at c + A·diag(r)·u with the normal A·diag(r)⁻¹·u, made a unit vector (c centre, A axes, r radii).
//! Where ellipsoids pass through each other the meshes do so too. Only metaballs have one closed surface; see
//! [`skin`](super::skin).

use std::f64::consts::{PI, TAU};

use nalgebra::Vector3;

use super::{BONES, Mesh, SkinnedMesh, bind_pose};
use crate::body::{BodyModel, Posed, Primitive, Shape};

/// Rings between the two poles of an ellipsoid.
const RINGS: u32 = 15;
/// Corners of each ring.
const AROUND: u32 = 24;

/// The ellipsoids of a posed body, mesh after mesh; empty if it has none.
pub fn ellipsoids(body: &Posed<'_>) -> Mesh {
    let (points, triangles) = sphere();
    let mut mesh = Mesh::default();
    for primitive in &body.model.ellipsoids {
        let first = mesh.vertices.len() as u32;
        let centre = body.primitive(primitive).centre;
        let axes = body.primitive_axes(primitive);
        let radii = body.primitive_radii(primitive);

        for u in &points {
            mesh.vertices.push(centre + axes * u.component_mul(&radii));
            let normal = (axes * u.component_div(&radii)).try_normalize(0.0);
            mesh.normals.push(normal.unwrap_or(*u));
        }

        let moved = triangles.iter().map(|t| t.map(|i| first + i));
        mesh.triangles.extend(moved);
    }
    mesh
}

/// The ellipsoids in the pose of binding, each with all its weight on its part: bones carry them without any error.
pub fn skinned_ellipsoids(model: &BodyModel, shape: &Shape) -> SkinnedMesh {
    let bind = bind_pose(model, shape);
    let mesh = ellipsoids(&Posed::new(model, shape, &bind));
    let corners = (RINGS * AROUND + 2) as usize;
    let part = |primitive: &Primitive| {
        let mut parts = [0; BONES];
        parts[0] = u8::try_from(primitive.part.0).unwrap_or(0);
        std::iter::repeat_n(parts, corners)
    };
    let mut whole = [0.0; BONES];
    whole[0] = 1.0;
    SkinnedMesh {
        parts: model.ellipsoids.iter().flat_map(part).collect(),
        weights: vec![whole; mesh.vertices.len()],
        mesh,
        bind,
    }
}

/// The unit sphere: its poles, then its rings from the upper pole downwards; triangles face outwards.
fn sphere() -> (Vec<Vector3<f64>>, Vec<[u32; 3]>) {
    let mut points = vec![Vector3::z(), -Vector3::z()];
    for ring in 1..=RINGS {
        let (sine, height) = (PI * f64::from(ring) / f64::from(RINGS + 1)).sin_cos();
        points.extend((0..AROUND).map(|k| {
            let (y, x) = (TAU * f64::from(k) / f64::from(AROUND)).sin_cos();
            Vector3::new(sine * x, sine * y, height)
        }));
    }

    let corner = |ring: u32, k: u32| 2 + ring * AROUND + k % AROUND;
    let mut triangles = Vec::new();
    for k in 0..AROUND {
        triangles.push([0, corner(0, k), corner(0, k + 1)]);
        for ring in 1..RINGS {
            let [a, d] = [corner(ring - 1, k), corner(ring - 1, k + 1)];
            let [b, c] = [corner(ring, k), corner(ring, k + 1)];
            triangles.extend([[a, b, c], [a, c, d]]);
        }
        triangles.push([1, corner(RINGS - 1, k + 1), corner(RINGS - 1, k)]);
    }
    (points, triangles)
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::body::{Motion, PartId};
    use crate::skin::check_watertight;

    fn person() -> (BodyModel, Shape) {
        let model = crate::io::model::load("human-ellipsoids", Path::new("")).unwrap();
        let shape = Shape(model.statistics.mean.clone());
        (model, shape)
    }

    #[test]
    fn the_meshes_are_closed_and_hold_what_their_ellipsoids_hold() {
        let (model, shape) = person();
        let motion = Motion::rest(&model);
        let body = Posed::new(&model, &shape, &motion);
        let mesh = ellipsoids(&body);
        check_watertight(&mesh).unwrap();
        let volume = |p: &Primitive| 4.0 / 3.0 * PI * body.primitive_radii(p).product();
        let whole: f64 = model.ellipsoids.iter().map(volume).sum();
        // corners stand on the ellipsoids, so triangles cut off a little: 2 % with these rings
        approx::assert_relative_eq!(mesh.volume(), whole, max_relative = 0.03);
        assert!(mesh.volume() < whole);
    }

    #[test]
    fn normals_are_those_of_the_ellipsoids() {
        let (model, shape) = person();
        let motion = Motion::rest(&model);
        let mesh = ellipsoids(&Posed::new(&model, &shape, &motion));
        let by_triangles = Mesh::new(mesh.vertices.clone(), mesh.triangles.clone());
        for (normal, about) in mesh.normals.iter().zip(&by_triangles.normals) {
            assert!(normal.dot(about) > 0.95);
            approx::assert_relative_eq!(normal.norm(), 1.0, epsilon = 1e-12);
        }
    }

    #[test]
    fn bones_carry_the_ellipsoids_to_where_they_are_in_another_pose() {
        let (model, shape) = person();
        let skin = skinned_ellipsoids(&model, &shape);
        let mut motion = Motion::rest(&model);
        for (i, angle) in motion.angles.iter_mut().enumerate() {
            *angle += 0.2 * (i as f64).sin();
        }
        let bound = Posed::new(&model, &shape, &skin.bind);
        let posed = Posed::new(&model, &shape, &motion);
        let there = ellipsoids(&posed);
        assert_eq!(skin.parts.len(), there.vertices.len());
        for (i, place) in there.vertices.iter().enumerate() {
            let part = PartId(usize::from(skin.parts[i][0]));
            let in_part = bound.in_part(part, &skin.mesh.vertices[i].into());
            let carried = posed.origin_of_part(part).coords + posed.world_from_part(part) * in_part;
            approx::assert_relative_eq!(carried, *place, epsilon = 1e-12);
        }
    }
}
