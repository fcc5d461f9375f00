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

/// A minute at 50 Hz, one point, row by row: number, time, and the point's height.
fn rows() -> Vec<String> {
    let row = |i: usize| format!("{}\t{:.3}\t0.1\t{i}.0\t0.2\n", i + 1, i as f64 / 50.0);
    (0..200).map(row).collect()
}

fn text_of(rows: &[String]) -> String {
    let head = "PathFileType\t4\t(X/Y/Z)\ta.trc\nDataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\tOrigDataStartFrame\tOrigNumFrames\n\
        50\t50\t200\t1\tm\t50\t0\t200\nFrame#\tTime\tRHip\t\t\n\t\tX1\tY1\tZ1\n";
    format!("{head}{}", rows.concat())
}

#[test]
fn rows_that_are_missing_with_their_numbers_are_frames_without_points() {
    let mut rows = rows();
    rows.drain(50..80);
    let found = read(&text_of(&rows)).unwrap();
    assert_eq!(found.frames.len(), 200);
    for (i, frame) in found.frames.iter().enumerate() {
        let height = frame[0].map(|p| p.z);
        assert_eq!(height, (!(50..80).contains(&i)).then_some(i as f64), "{i}");
    }
    // two rows and nothing between them
    let far = ["1\t0\t0.1\t1\t0.2\n", "60001\t1200\t0.1\t1\t0.2\n"].map(str::to_owned);
    assert_eq!(read(&text_of(&far)).unwrap().frames.len(), 60_001);
}

#[test]
fn frames_and_times_that_do_not_grow_together_are_refused_at_the_first_such_row() {
    let refused = |rows: &[String]| read(&text_of(rows)).unwrap_err().to_string();
    let number = |row: &String, number: usize| {
        let (_, rest) = row.split_once('\t').unwrap();
        format!("{number}\t{rest}")
    };

    // thirty rows cut out and the rest numbered anew: the times tell
    let mut cut = rows();
    cut.drain(50..80);
    let cut: Vec<String> = cut.iter().enumerate().map(|(i, row)| number(row, i + 1)).collect();
    let expected = "walk.trc:56: 0.620000 s from frame 50 to frame 51, expected 0.020000 s";
    assert!(refused(&cut).starts_with(expected), "{}", refused(&cut));

    // every row twice, with its number or with a new one
    let twice: Vec<String> = rows().iter().flat_map(|row| [row.clone(), row.clone()]).collect();
    let expected = "walk.trc:7: frame 1 follows frame 1: expected ascending numbers";
    assert!(refused(&twice).starts_with(expected), "{}", refused(&twice));
    let anew: Vec<String> = twice.iter().enumerate().map(|(i, row)| number(row, i + 1)).collect();
    assert!(
        refused(&anew).starts_with("walk.trc:7: 0.000000 s from frame 1"),
        "{}",
        refused(&anew)
    );

    // a clock that jumps
    let mut jump = rows();
    jump[70] = jump[70].replace("\t1.400\t", "\t1000000000\t");
    assert!(refused(&jump).starts_with("walk.trc:76: 999999998.620000 s"), "{}", refused(&jump));

    // every second row
    let half: Vec<String> = rows().into_iter().step_by(2).collect();
    assert!(refused(&half).contains("100 rows, and 99 frame numbers"), "{}", refused(&half));
    for (from, to, column) in [("7\t0.120", "x\t0.120", "Frame#"), ("7\t0.120", "7\tnow", "Time")] {
        let text = text_of(&rows()).replacen(from, to, 1);
        let message = read(&text).unwrap_err().to_string();
        assert!(
            message.starts_with(&format!("walk.trc:12: {column}: expected a number")),
            "{message}"
        );
    }
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
