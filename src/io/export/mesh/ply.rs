//! PLY (Turk 1994).

use std::fmt::Write;

use super::rows;
use crate::camera::UpAxis;
use crate::skin::Mesh;

fn header(mesh: &Mesh, format: &str, up: UpAxis) -> String {
    let mut header = format!("ply\nformat {format} 1.0\ncomment metres, {up} up\n");
    header += &format!("element vertex {}\n", mesh.vertices.len());
    for name in ["x", "y", "z", "nx", "ny", "nz"] {
        header += &format!("property float {name}\n");
    }
    header += &format!("element face {}\n", mesh.triangles.len());
    header + "property list uchar int vertex_indices\nend_header\n"
}

pub(super) fn binary(mesh: &Mesh, up: UpAxis) -> Vec<u8> {
    let mut bytes = header(mesh, "binary_little_endian", up).into_bytes();
    for number in rows(mesh, up).flatten() {
        bytes.extend(number.to_le_bytes());
    }
    for triangle in &mesh.triangles {
        bytes.push(3);
        bytes.extend(triangle.iter().flat_map(|corner| corner.to_le_bytes()));
    }
    bytes
}

pub(super) fn text(mesh: &Mesh, up: UpAxis) -> String {
    let mut text = header(mesh, "ascii", up);
    // writing to a String cannot fail
    for [x, y, z, a, b, c] in rows(mesh, up) {
        let _ = writeln!(text, "{x} {y} {z} {a} {b} {c}");
    }
    for [a, b, c] in &mesh.triangles {
        let _ = writeln!(text, "3 {a} {b} {c}");
    }
    text
}
