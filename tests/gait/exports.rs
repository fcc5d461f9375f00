//! Exports of a known walk, read back by the letter of each format. (Other programs read them in `tests/oracles`.)

use crate::walker::{RATE_HZ, Walker};
use maquette::gait::{GaitAnalysis, GaitOptions, Movement, analyse};
use maquette::io::export::{C3dError, C3dInput, TableKind, c3d, coordinates, motion_text};
use maquette::pipeline::FittedPoint;
use nalgebra::Vector3;

fn walk() -> (Walker, Movement, GaitAnalysis) {
    let walker = Walker::new(0.8);
    let (movement, _) = walker.fitted();
    let gait = analyse(&movement, &GaitOptions::default()).expect("a pelvis");
    (walker, movement, gait)
}

fn point(name: &str, places: &[Vector3<f64>], sd_m: f64) -> FittedPoint {
    FittedPoint {
        name: name.to_owned(),
        track: places.to_vec(),
        sd_m: vec![Vector3::repeat(sd_m); places.len()],
    }
}

#[test]
fn a_c3d_holds_points_residuals_cameras_and_where_nobody_was() {
    let (_, _, gait) = walk();
    let missing = Vector3::repeat(f64::NAN);
    let places = [Vector3::new(1.0, 2.0, 3.0), missing];
    let points = [point("RHip", &places, 0.0042), point("LHip", &places, 1.0)];
    let angles = gait.angles.iter().map(|(k, v)| (*k, v[..2].to_vec())).collect();
    let bytes = c3d(&C3dInput {
        rate_hz: RATE_HZ,
        first_frame: 4,
        points: &points,
        cameras: &[0b101, 0],
        angles: &angles,
        events: &gait.events,
    })
    .expect("small enough");
    let word = |n: usize| u16::from_le_bytes([bytes[2 * n - 2], bytes[2 * n - 1]]);
    assert_eq!((bytes[0], bytes[1], bytes.len() % 512), (2, 0x50, 0));
    assert_eq!((word(4), word(5)), (5, 6));
    let count = usize::from(word(2));
    assert_eq!(count, 2 + 16);
    let data = (usize::from(word(9)) - 1) * 512;
    let float = |i: usize| {
        f32::from_le_bytes(bytes[data + 4 * i..data + 4 * i + 4].try_into().expect("four"))
    };
    let number =
        |frame: usize, point: usize, axis: usize| float(4 * (frame * count + point) + axis);
    // Y up, millimetres; 4.2 mm in steps of 0.1; cameras 1 and 3 in the high byte; 1 m is more than fits
    let first: Vec<f32> = (0..4).map(|axis| number(0, 0, axis)).collect();
    let expected = [2000.0, 3000.0, 1000.0, 256.0 * 5.0 + 42.0];
    assert!(
        first.iter().zip(expected).all(|(f, e): (&f32, f32)| (f - e).abs() < 1e-3),
        "{first:?}"
    );
    assert_eq!(number(0, 1, 3) as u32 & 0xff, 255);
    assert!(number(1, 0, 0).abs() < 1e-6 && (number(1, 0, 3) + 1.0).abs() < 1e-6);
}

#[test]
fn more_frames_than_the_format_counts_are_refused() {
    let places = vec![Vector3::zeros(); 10];
    let input = C3dInput {
        rate_hz: RATE_HZ,
        first_frame: 65_530,
        points: &[point("RHip", &places, 0.0)],
        cameras: &[],
        angles: &Default::default(),
        events: &[],
    };
    assert_eq!(c3d(&input), Err(C3dError::TooLarge { frames: 65_540, points: 1 }));
}

#[test]
fn a_motion_file_has_the_angles_of_the_body_under_opensims_names() {
    let (walker, movement, gait) = walk();
    let table = coordinates(&movement, &gait).expect("a pelvis");
    let column = |name: &str| &table.columns.iter().find(|c| c.0 == name).expect("a coordinate").1;
    for (name, joint) in
        [("knee_angle_r", "knee_flexion_r"), ("ankle_angle_l", "ankle_dorsiflexion_l")]
    {
        for (found, expected) in column(name).iter().zip(walker.angle(joint)) {
            assert!((found - expected).abs() < 0.01, "{name}");
        }
    }
    // the pelvis stands a hip's height above the floor, and turns by less than a right angle from one frame to the next
    assert!(column("pelvis_ty").iter().all(|y| (0.8..1.2).contains(y)));
    assert!(column("pelvis_rotation").windows(2).all(|w| (w[1] - w[0]).abs() < 0.1));
    let mot = motion_text(&table, TableKind::Mot, "walk");
    let sto = motion_text(&table, TableKind::Sto, "walk");
    let (rows, columns) = (table.frames.len(), table.columns.len());
    assert!(mot.starts_with(&format!(
        "Coordinates\nversion=1\nnRows={rows}\nnColumns={columns}\ninDegrees=yes\n"
    )));
    assert!(sto.starts_with("walk\n") && sto.contains("inDegrees=no"));
    let last = |text: &str| -> Vec<f64> {
        let line = text.lines().last().expect("rows").split('\t');
        line.map(|n| n.trim().parse().expect("a number")).collect()
    };
    let (degrees, radians) = (last(&mot), last(&sto));
    assert_eq!(degrees.len(), columns);
    let knee = table.columns.iter().position(|c| c.0 == "knee_angle_r").expect("a knee");
    assert!((degrees[knee].to_radians() - radians[knee]).abs() < 1e-7);
    let height = table.columns.iter().position(|c| c.0 == "pelvis_ty").expect("a height");
    assert!((degrees[height] - radians[height]).abs() < 1e-9);
}
