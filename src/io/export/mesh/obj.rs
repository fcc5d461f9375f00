//! Wavefront OBJ.

use std::fmt::Write;

use super::rows;
use crate::camera::UpAxis;
use crate::skin::Mesh;

pub(super) fn text(mesh: &Mesh, up: UpAxis) -> String {
    let mut text = format!("# metres, {up} up\n");
    // writing to a String cannot fail
    for [x, y, z, ..] in rows(mesh, up) {
        let _ = writeln!(text, "v {x} {y} {z}");
    }
    for [.., a, b, c] in rows(mesh, up) {
        let _ = writeln!(text, "vn {a} {b} {c}");
    }
    for triangle in &mesh.triangles {
        let [a, b, c] = triangle.map(|corner| corner + 1);
        let _ = writeln!(text, "f {a}//{a} {b}//{b} {c}//{c}");
    }
    text
}
