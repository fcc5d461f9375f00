//! Meshes as files: PLY, binary or as text, and OBJ. Field by field: docs/formats.md.

mod obj;
mod ply;

use crate::camera::UpAxis;
use crate::skin::Mesh;

/// A format that a mesh is written in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MeshFormat {
    /// PLY, binary, little endian.
    Ply,
    /// PLY as text.
    PlyText,
    /// Wavefront OBJ.
    Obj,
}

impl MeshFormat {
    /// Extension of a file's name.
    pub fn extension(self) -> &'static str {
        match self {
            Self::Ply | Self::PlyText => "ply",
            Self::Obj => "obj",
        }
    }

    /// The format that a file's extension asks for: binary PLY or OBJ.
    pub fn from_extension(path: &std::path::Path) -> Option<Self> {
        match path.extension()?.to_str()?.to_ascii_lowercase().as_str() {
            "ply" => Some(Self::Ply),
            "obj" => Some(Self::Obj),
            _ => None,
        }
    }
}

/// The bytes of a mesh's file, whose `up` points up: vertices with normals, rounded to `f32`, and triangles.
pub fn bytes_of(mesh: &Mesh, format: MeshFormat, up: UpAxis) -> Vec<u8> {
    match format {
        MeshFormat::Ply => ply::binary(mesh, up),
        MeshFormat::PlyText => ply::text(mesh, up).into_bytes(),
        MeshFormat::Obj => obj::text(mesh, up).into_bytes(),
    }
}

/// Place and normal of each vertex, as written.
fn rows(mesh: &Mesh, up: UpAxis) -> impl Iterator<Item = [f32; 6]> + '_ {
    mesh.vertices.iter().zip(&mesh.normals).map(move |(v, n)| {
        let [p, n] = [up.to_export(v), up.to_export(n)];
        [p.x, p.y, p.z, n.x, n.y, n.z].map(|number| number as f32)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;

    /// A tetrahedron whose corners no two axes share.
    fn mesh() -> Mesh {
        let corners = [
            Vector3::new(0.1, 0.2, 0.3),
            Vector3::new(1.5, 0.25, 0.125),
            Vector3::new(0.0, 2.5, -0.5),
            Vector3::new(0.3, 0.4, 3.5),
        ];
        let triangles = vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
        Mesh::new(corners.to_vec(), triangles)
    }

    /// What a PLY file says: its header's lines, six numbers a vertex, three corners a face.
    type Ply = (Vec<String>, Vec<[f32; 6]>, Vec<[i32; 3]>);

    fn header(bytes: &[u8]) -> (Vec<String>, &[u8]) {
        let end = b"end_header\n";
        let at = bytes.windows(end.len()).position(|w| w == end).unwrap() + end.len();
        let text = std::str::from_utf8(&bytes[..at]).unwrap();
        (text.lines().map(str::to_owned).collect(), &bytes[at..])
    }

    fn count(header: &[String], element: &str) -> usize {
        let start = format!("element {element} ");
        let line = header.iter().find_map(|line| line.strip_prefix(&start));
        line.unwrap().parse().unwrap()
    }

    fn read_binary(bytes: &[u8]) -> Ply {
        let (header, body) = header(bytes);
        assert_eq!(header[1], "format binary_little_endian 1.0");
        let (vertices, faces) = (count(&header, "vertex"), count(&header, "face"));
        let (vertices, faces) = (&body[..24 * vertices], &body[24 * vertices..][..13 * faces]);
        assert_eq!(vertices.len() + faces.len(), body.len());
        let number = |b: &[u8]| f32::from_le_bytes(b.try_into().unwrap());
        let corner = |b: &[u8]| i32::from_le_bytes(b.try_into().unwrap());
        let vertices =
            vertices.chunks(24).map(|row| std::array::from_fn(|k| number(&row[4 * k..][..4])));
        let faces = faces.chunks(13).map(|face| {
            assert_eq!(face[0], 3);
            std::array::from_fn(|k| corner(&face[1 + 4 * k..][..4]))
        });
        (header.clone(), vertices.collect(), faces.collect())
    }

    fn read_text(bytes: &[u8]) -> Ply {
        let (header, body) = header(bytes);
        assert_eq!(header[1], "format ascii 1.0");
        let mut lines = std::str::from_utf8(body).unwrap().lines();
        let vertices = count(&header, "vertex");
        let vertex = |line: &str| {
            let mut words = line.split(' ').map(|w| w.parse().unwrap());
            std::array::from_fn(|_| words.next().unwrap())
        };
        let vertices: Vec<_> = lines.by_ref().take(vertices).map(vertex).collect();
        let face = |line: &str| {
            let mut words = line.split(' ').map(|w| w.parse().unwrap());
            assert_eq!(words.next(), Some(3));
            std::array::from_fn(|_| words.next().unwrap())
        };
        let faces: Vec<_> = lines.map(face).collect();
        assert_eq!(faces.len(), count(&header, "face"));
        (header, vertices, faces)
    }

    #[test]
    fn binary_and_text_ply_say_the_same_and_both_are_the_mesh() {
        let mesh = mesh();
        let binary = read_binary(&bytes_of(&mesh, MeshFormat::Ply, UpAxis::Z));
        let text = read_text(&bytes_of(&mesh, MeshFormat::PlyText, UpAxis::Z));
        assert_eq!((&binary.1, &binary.2), (&text.1, &text.2));
        assert_eq!(binary.0[2], "comment metres, Z up");
        for (row, (v, n)) in binary.1.iter().zip(mesh.vertices.iter().zip(&mesh.normals)) {
            let expected = [v.x, v.y, v.z, n.x, n.y, n.z].map(|x| x as f32);
            assert_eq!(row.map(f32::to_bits), expected.map(f32::to_bits));
        }
        let corners = mesh.triangles.iter().map(|t| t.map(|c| c as i32));
        assert!(binary.2.iter().copied().eq(corners));
    }

    #[test]
    fn another_program_reads_the_obj() {
        let mesh = mesh();
        let bytes = bytes_of(&mesh, MeshFormat::Obj, UpAxis::Z);
        assert!(bytes.starts_with(b"# metres, Z up\n"));
        let options = tobj::LoadOptions::default();
        let no_material = |_: &std::path::Path| Err(tobj::LoadError::OpenFileFailed);
        let (models, _) = tobj::load_obj_buf(&mut &bytes[..], &options, no_material).unwrap();
        let read = &models[0].mesh;
        // it numbers vertices anew, in the order in which triangles name them
        let corners = mesh.triangles.concat();
        let check = |numbers: &[f32], indices: &[u32], expected: &[Vector3<f64>]| {
            assert_eq!(indices.len(), corners.len());
            for (index, corner) in indices.iter().zip(&corners) {
                let read = &numbers[3 * *index as usize..][..3];
                let expected = expected[*corner as usize].map(|x| x as f32);
                assert_eq!(read, expected.as_slice());
            }
        };
        check(&read.positions, &read.indices, &mesh.vertices);
        check(&read.normals, &read.normal_indices, &mesh.normals);
    }

    #[test]
    fn with_y_up_the_body_stands_upon_z_and_x_and_still_faces_outwards() {
        let mesh = mesh();
        let (header, rows, _) = read_binary(&bytes_of(&mesh, MeshFormat::Ply, UpAxis::Y));
        assert_eq!(header[2], "comment metres, Y up");
        let turned = rows.iter().map(|r| Vector3::new(r[0], r[1], r[2]).cast());
        let turned = Mesh::new(turned.collect(), mesh.triangles.clone());
        approx::assert_relative_eq!(turned.volume(), mesh.volume(), epsilon = 1e-6);
        approx::assert_relative_eq!(rows[3][1], 3.5);
    }

    #[test]
    fn the_extension_says_the_format() {
        let of = |name: &str| MeshFormat::from_extension(std::path::Path::new(name));
        assert_eq!(of("a.PLY"), Some(MeshFormat::Ply));
        assert_eq!(of("a.obj"), Some(MeshFormat::Obj));
        assert_eq!((of("a.stl"), of("a")), (None, None));
    }
}
