//! TRC: what is written is read again, and what other programs write is read too.

use std::path::Path;

use maquette::io::points::trc::{Trajectories, TrcError, read_trc, write_trc};
use nalgebra::Point3;

fn read(text: &str) -> Result<Trajectories, TrcError> {
    read_trc(text, Path::new("walk.trc"))
}

fn two_points() -> Trajectories {
    Trajectories {
        rate_hz: 59.94,
        first_frame: 0,
        names: vec!["RHip".into(), "Big toe".into()],
        frames: vec![
            vec![Some(Point3::new(1.25, -0.5, 0.875)), None],
            vec![Some(Point3::new(1.5, -0.5, 1e-6)), Some(Point3::new(0.0, 2.0, 3.0))],
        ],
    }
}

#[test]
fn what_is_written_is_read_again() {
    assert_eq!(read(&write_trc(&two_points(), "walk.trc")).unwrap(), two_points());
}

#[test]
fn the_layout_is_that_of_pose2sim() {
    let text = write_trc(&two_points(), "walk.trc");
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines[0], "PathFileType\t4\t(X/Y/Z)\twalk.trc");
    assert_eq!(lines[2], "59.94\t59.94\t2\t2\tm\t59.94\t0\t2");
    assert_eq!(lines[3], "Frame#\tTime\tRHip\t\t\tBig toe\t\t\t");
    assert_eq!(lines[4], "\t\tX1\tY1\tZ1\tX2\tY2\tZ2\t");
    assert_eq!(lines[5], "1\t0.000000\t-0.500000\t0.875000\t1.250000\t\t\t");
}

#[test]
fn a_recording_that_begins_later_keeps_its_frame_numbers_and_times() {
    let late = Trajectories { rate_hz: 50.0, first_frame: 100, ..two_points() };
    let text = write_trc(&late, "walk.trc");
    assert!(text.contains("\n101\t2.000000\t") && text.contains("\n102\t2.020000\t"));
    assert_eq!(read(&text).unwrap(), late);
}

#[test]
fn opensims_millimetres_padding_and_blank_line_are_read() {
    let text = "PathFileType  4\t(X/Y/Z) C:\\trials\\walk.trc\r\n\
        DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\tOrigDataStartFrame\tOrigNumFrames\r\n\
        60.00\t\t 60.00\t       2\t1\t mm\t60.00\t1\t       2\r\n\
        Frame#\tTime\tR.ASIS\t\t\r\n\t\tX1\tY1\tZ1\r\n\r\n\
        0\t0.000\t 617.25\t 1000\t -20\t\r\n1\t0.017\tNaN\tNaN\tNaN\r\n";
    let read = read(text).unwrap();
    assert_eq!(read.names, ["R.ASIS"]);
    assert_eq!(read.frames.len(), 2);
    let point = read.frames[0][0].unwrap();
    approx::assert_relative_eq!(point, Point3::new(-0.02, 0.61725, 1.0), epsilon = 1e-12);
    assert_eq!(read.frames[1][0], None);
}

#[test]
fn a_row_that_ends_early_lacks_its_last_points() {
    let text = write_trc(&two_points(), "walk.trc").replace("1.250000\t\t\t", "1.250000");
    assert_eq!(read(&text).unwrap(), two_points());
}

#[test]
fn every_fault_is_named_with_its_line() {
    let good = write_trc(&two_points(), "walk.trc");
    let message = |text: &str| read(text).unwrap_err().to_string();
    let cases = [
        (message("hello"), "walk.trc: expected a line that starts with Frame#"),
        (
            message(&good.replace("\tm\t", "\tinch\t")),
            "walk.trc:3: expected the unit m or mm, found \"inch\"",
        ),
        (
            message(&good.replace("59.94\t59.94\t2", "0\t0\t2")),
            "walk.trc:3: expected a frame rate from 0.1 to 100000 Hz, found \"0\"",
        ),
        (
            message(&good.replace("0.875000", "x")),
            "walk.trc:6: point RHip: expected a number or nothing, found \"x\"",
        ),
        (message("a\tb\nFrame#\tTime\n"), "walk.trc:1: expected the values of DataRate"),
    ];
    for (found, expected) in cases {
        assert!(found.starts_with(expected), "{found}");
    }
}

#[test]
#[allow(clippy::print_stderr, reason = "a skipped test says so")]
fn real_files_of_other_programs_are_read() {
    let default = concat!(env!("CARGO_MANIFEST_DIR"), "/../shared");
    let shared = std::env::var("MAQUETTE_SHARED").unwrap_or(default.into());
    for (file, points, frames) in
        [("data/gait/motion_capture_walk.trc", 41, 2), ("data/balance/reference_raw.trc", 15, 90)]
    {
        let path = Path::new(&shared).join(file);
        let Ok(text) = std::fs::read_to_string(&path) else {
            eprintln!("skipped: {} is not here", path.display());
            continue;
        };
        let read = read_trc(&text, &path).unwrap();
        assert!(read.names.len() >= points && read.frames.len() >= frames);
        let height = |p: &Point3<f64>| p.z;
        let heights: Vec<f64> = read.frames.iter().flatten().flatten().map(height).collect();
        assert!(heights.iter().all(|z| (-0.3..2.5).contains(z)), "{file}");
    }
}
