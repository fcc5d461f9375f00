//! Point clouds in every format, and each way for them to be bad.

use std::path::Path;

use maquette::io::points::{CloudError, parse, write_ply};
use maquette::stereo::{Cloud, CloudPoint, Spread};
use nalgebra::{Matrix3, Point3, Vector3};

fn read(name: &str, bytes: impl AsRef<[u8]>) -> Result<Cloud, CloudError> {
    parse(bytes.as_ref(), Path::new(name))
}

fn message(name: &str, bytes: impl AsRef<[u8]>) -> String {
    let text = read(name, bytes).expect_err("a fault").to_string();
    assert!(!text.contains('\n'), "{text}");
    text
}

fn places(cloud: &Cloud) -> Vec<[f64; 3]> {
    let places = cloud.points.iter().map(|p| p.position_world);
    places.map(|p| [p.x, p.y, p.z]).collect()
}

const ASCII: &str = "ply\nformat ascii 1.0\ncomment made by hand\nobj_info none\n\
    element patch 2\nproperty list uchar int corners\n\
    element vertex 3\nproperty float x\nproperty double y\nproperty float z\n\
    property float nx\nproperty uchar red\nproperty double sigma\n\
    element face 1\nproperty list uchar int vertex_indices\nend_header\n\
    3 0 1 2\n0\n\
    1 2 3 0.5 255 0.01\n-1.5 2e-1 0 0.5 0 0.02\n0 nan 1 0 0 0.01\n\
    3 0 1 2\n";

#[test]
fn an_ascii_ply_is_read_past_what_is_not_needed() {
    let cloud = read("a.ply", ASCII).expect("a cloud");
    assert_eq!(places(&cloud), [[1.0, 2.0, 3.0], [-1.5, 0.2, 0.0]]);
    assert_eq!(cloud.points[1].spread, Spread::Isotropic(0.02));
    assert_eq!(cloud.left_out.unusable, 1);
    assert_eq!(read("a.PLY", ASCII.replace('\n', "\r\n")).expect("a cloud"), cloud);
}

/// A binary PLY of an unused list element, then floats x y z and a list and a byte after them.
fn binary(order: &str) -> Vec<u8> {
    let mut bytes = format!(
        "ply\nformat binary_{order}_endian 1.0\nelement patch 1\nproperty list ushort int corners\n\
         element vertex 2\nproperty float x\nproperty float y\nproperty double z\n\
         property list uchar short seen_by\nproperty uchar red\nend_header\n"
    )
    .into_bytes();
    let mut put = |big: &[u8]| {
        let mut one = big.to_vec();
        if order == "little" {
            one.reverse();
        }
        bytes.extend(one);
    };
    put(&2u16.to_be_bytes());
    put(&7i32.to_be_bytes());
    put(&8i32.to_be_bytes());
    for k in [1.0_f32, -2.0] {
        put(&k.to_be_bytes());
        put(&(k * 0.5).to_be_bytes());
        put(&f64::from(k * 4.0).to_be_bytes());
        put(&[1]);
        put(&300i16.to_be_bytes());
        put(&[255]);
    }
    bytes
}

#[test]
fn a_binary_ply_is_read_in_both_byte_orders() {
    for order in ["little", "big"] {
        let cloud = read("b.ply", binary(order)).expect("a cloud");
        assert_eq!(places(&cloud), [[1.0, 0.5, 4.0], [-2.0, -1.0, -8.0]]);
        assert_eq!(cloud.points[0].spread, Spread::Unknown);
    }
}

#[test]
fn what_is_written_is_read_again_to_the_bit() {
    let covariance = Matrix3::new(4e-4, 1e-5, 0.0, 1e-5, 1e-4, 2e-5, 0.0, 2e-5, 2.25e-4);
    for spread in [Spread::Unknown, Spread::Isotropic(0.1 / 3.0), Spread::Full(covariance)] {
        let point = |k: f64| CloudPoint {
            position_world: Point3::new(k / 3.0, -k / 7.0, 1e3 + k / 11.0),
            spread,
        };
        let points: Vec<_> = (0..50).map(|k| point(f64::from(k))).collect();
        assert_eq!(read("c.ply", write_ply(&points)).expect("a cloud").points, points);
    }
    assert_eq!(read("c.ply", write_ply(&[])).expect("a cloud"), Cloud::default());
}

#[test]
fn xyz_has_three_or_four_columns() {
    let cloud = read("d.xyz", "# x y z\n\n1 2 3\n\t-1e-3   0 4.5\nNaN 0 0\n").expect("a cloud");
    assert_eq!(places(&cloud), [[1.0, 2.0, 3.0], [-1e-3, 0.0, 4.5]]);
    assert_eq!(cloud.left_out.unusable, 1);
    let cloud = read("d.txt", "\u{feff}1 2 3 0.01\r\n4 5 6 0.02\r\n").expect("a cloud");
    assert_eq!(cloud.points[1].spread, Spread::Isotropic(0.02));
    for (text, part) in [
        ("1 2 3\n1 2\n", "d.xyz:2: expected three or four numbers: x y z [sigma], found \"1 2\""),
        ("1 2 3\n1 2 3 4\n", "d.xyz:2: expected as many numbers as in the lines before"),
        ("1,2,3\n", "d.xyz:1: expected three or four numbers"),
        ("1 2 3 4 5\n", "d.xyz:1: "),
    ] {
        assert!(message("d.xyz", text).starts_with(part), "{}", message("d.xyz", text));
    }
}

#[test]
fn csv_goes_by_its_header() {
    let cloud = read("e.csv", "id, Z, x, y\n a, 3, 1, 2\n\"b\", inf, 0, 0\n").expect("a cloud");
    assert_eq!((places(&cloud), cloud.left_out.unusable), (vec![[1.0, 2.0, 3.0]], 1));
    let cloud = read("e.csv", "x,y,z,sigma\n1,2,3,0.5\n").expect("a cloud");
    assert_eq!(cloud.points[0].spread, Spread::Isotropic(0.5));
    let text = "x,y,z,cov_xx,cov_xy,cov_xz,cov_yy,cov_yz,cov_zz\n1,2,3,4,0,0,9,0,16\n";
    let spread = read("e.csv", text).expect("a cloud").points[0].spread;
    assert_eq!(spread.along(&Vector3::y()), Some(3.0));
    for (text, part) in [
        ("1,2,3\n4,5,6\n", "e.csv: expected x, y and z, and for the spread"),
        ("x,y,z,cov_xx\n1,2,3,4\n", "found x, y, z, cov_xx"),
        ("x,y,z\n1,2,3\n1,two,3\n", "e.csv:3: expected a number, found \"two\""),
        ("x,y,z\n1,2\n", "e.csv: CSV error: record 1 (line: 2"),
    ] {
        assert!(message("e.csv", text).contains(part), "{}", message("e.csv", text));
    }
}

#[test]
fn no_bytes_are_no_points_and_a_strange_name_is_refused() {
    for name in ["f.ply", "f.xyz", "f.csv"] {
        assert_eq!(read(name, "").expect("no points"), Cloud::default());
    }
    assert_eq!(
        message("f.obj", "v 1 2 3"),
        "f.obj: expected a point cloud: .ply, .xyz, .txt or .csv"
    );
}

#[test]
fn a_header_that_promises_more_than_the_file_holds_is_refused_before_anything_is_allocated() {
    let many = |text: &str| text.replace("vertex 3", "vertex 1000000000000");
    assert!(message("g.ply", many(ASCII)).starts_with(
        "g.ply: the header promises 1000000000000 of \"vertex\", but the file has room for "
    ));
    let header = "ply\nformat binary_little_endian 1.0\nelement nothing 1000000000000\nelement vertex 1\n\
        property float x\nproperty float y\nproperty float z\nend_header\n............";
    assert!(message("g.ply", header).contains("1000000000000 of \"nothing\""));
}

#[test]
fn a_fault_in_a_ply_is_named_with_its_place() {
    for (from, to, part) in [
        ("ply\n", "plu\n", "h.ply:1: the header is no PLY header"),
        ("property float z\n", "", "h.ply: expected x, y and z"),
        ("float z", "list uchar float z", "h.ply: expected x, y and z"),
        (
            "element vertex",
            "element point",
            "expected an element \"vertex\", found patch, point, face",
        ),
        (
            "-1.5 2e-1",
            "-1.5 two",
            "h.ply:20: expected a number for each property of the element, found",
        ),
        ("float z", "complex z", "h.ply:10: "),
    ] {
        let text = ASCII.replacen(from, to, 1);
        assert!(message("h.ply", &text).contains(part), "{}", message("h.ply", &text));
    }
}

#[test]
fn no_cut_and_no_flipped_byte_is_a_panic() {
    for whole in [ASCII.as_bytes().to_vec(), binary("little"), binary("big")] {
        for at in 0..whole.len() {
            let _ = read("i.ply", &whole[..at]);
            for flip in [0x01, 0x80, 0xff] {
                let mut bytes = whole.clone();
                bytes[at] ^= flip;
                let _ = read("i.ply", bytes);
            }
        }
    }
}
