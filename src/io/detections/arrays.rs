//! Arrays that hold all pictures of all cameras: FreeMoCap's `…2dData_numCams_numFrames_numTrackedPoints_pixelXY.npy`.
//!
//! The array is cameras × frames × points × 2, in pixels; NaN: not seen. Cameras are in the order of their names, and the first 33 points are
//! MediaPipe's; those of hands and face are not read. It holds no confidence: what was seen counts as sure as labels are.
//!
//! NumPy's file begins with the bytes `\x93NUMPY`, two of the version, and the length of a header (two bytes of version 1, else four). The header is a Python
//! dictionary with `descr` (here `<f8` or `<f4`), `fortran_order` (here `False`) and `shape`. Then come the numbers. (The crates that read all of
//! NumPy's types parse any Python literal for it, and build assembly.)
//!
//! # Source
//! NumPy Enhancement Proposal 1, *A simple file format for NumPy arrays*; freemocap.org, `output_data/raw_data`.

use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::Path;

use super::tables::MOST_BYTES;
use super::{KeypointSet, NamedPerson, Table};
use crate::io::input;

const MAGIC: &[u8] = b"\x93NUMPY";

/// Whether a file is such an array by its name.
pub fn is_array(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension == "npy") && path.is_file()
}

/// The one person of all pictures of one of so many `cameras`, the one at this `place` in their order.
///
/// # Errors
/// One line that says what is wrong with the file.
pub fn read_array(path: &Path, place: usize, cameras: usize) -> Result<Table, String> {
    let to_line = |fault: std::io::Error| fault.to_string();
    input::check_kind(path).map_err(to_line)?;
    let mut file = File::open(path).map_err(to_line)?;
    let head = Head::read(&mut file)?;
    let [of_cameras, frames, points, coordinates] = head.shape;
    if of_cameras != cameras {
        return Err(format!("an array of {of_cameras} cameras, {cameras} are calibrated"));
    }

    let of_camera = [frames, points, coordinates, head.bytes_each];
    let bytes = of_camera.iter().try_fold(1_usize, |all, n| all.checked_mul(*n));
    let bytes = bytes.filter(|bytes| *bytes as u64 <= MOST_BYTES);
    let bytes = bytes.ok_or("an array of more than 512 MiB for each camera")?;
    let whole = head.begins + (bytes * cameras) as u64;
    let found = file.metadata().map_err(to_line)?.len();
    if found != whole {
        return Err(format!("expected {whole} bytes for its shape, found {found}"));
    }

    let mut own = vec![0; bytes];
    file.seek(SeekFrom::Start(head.begins + (place * bytes) as u64)).map_err(to_line)?;
    file.read_exact(&mut own).map_err(to_line)?;
    let numbers: Vec<f64> = match head.bytes_each {
        8 => own.as_chunks::<8>().0.iter().map(|number| f64::from_le_bytes(*number)).collect(),
        _ => own.as_chunks::<4>().0.iter().map(|n| f64::from(f32::from_le_bytes(*n))).collect(),
    };
    let names: Vec<&str> = mediapipe().points().collect();
    let person = |frame: &[f64]| -> NamedPerson {
        let seen = |(name, at): (&&'static str, &[f64])| {
            let is_seen = !name.is_empty() && at[0].is_finite() && at[1].is_finite();
            is_seen.then_some((*name, [at[0], at[1], 1.0]))
        };
        names.iter().zip(frame.chunks(coordinates)).filter_map(seen).collect()
    };
    let frames = numbers.chunks(points * coordinates).map(person);
    let people = frames.map(|person| if person.is_empty() { Vec::new() } else { vec![person] });
    Ok((0..).zip(people).collect())
}

fn mediapipe() -> KeypointSet {
    KeypointSet::by_name("mediapipe33").expect("a set of this name is in the list")
}

/// What the head of the file says.
struct Head {
    /// Cameras, frames, points, coordinates.
    shape: [usize; 4],
    /// Of a number: 4 or 8.
    bytes_each: usize,
    /// Where the numbers begin.
    begins: u64,
}

impl Head {
    fn read(file: &mut File) -> Result<Self, String> {
        let short = |_| "expected the head of NumPy's file, found its end".to_owned();
        let mut start = [0; 8];
        file.read_exact(&mut start).map_err(short)?;
        if !start.starts_with(MAGIC) {
            return Err("expected NumPy's file, which begins with \\x93NUMPY".into());
        }
        let mut length = [0; 4];
        let wide = if start[6] == 1 { 2 } else { 4 };
        file.read_exact(&mut length[..wide]).map_err(short)?;
        let length = u32::from_le_bytes(length);
        let mut header = Vec::new();
        file.take(u64::from(length)).read_to_end(&mut header).map_err(short)?;
        let header = String::from_utf8_lossy(&header);

        let bytes_each = match value(&header, "descr").trim_matches(['\'', '"']) {
            "<f8" => 8,
            "<f4" => 4,
            other => return Err(format!("numbers of type {other:?}, expected <f8 or <f4")),
        };
        if value(&header, "fortran_order") != "False" {
            return Err("numbers in Fortran's order, expected C's".into());
        }
        let begins = start.len() as u64 + wide as u64 + u64::from(length);
        Ok(Self { shape: shape(&header)?, bytes_each, begins })
    }
}

/// The text of a word of the dictionary, up to a comma or its end.
fn value<'h>(header: &'h str, word: &str) -> &'h str {
    let after = header.split_once(&format!("'{word}'")).map_or("", |(_, after)| after);
    let value = after.trim_start_matches([' ', ':']);
    value.split([',', '}']).next().unwrap_or("").trim()
}

fn shape(header: &str) -> Result<[usize; 4], String> {
    let listed = header.split_once("'shape'").and_then(|(_, after)| after.split_once('('));
    let listed = listed.and_then(|(_, after)| after.split_once(')')).map_or("", |(list, _)| list);
    let numbers: Result<Vec<usize>, _> =
        listed.split(',').map(str::trim).filter(|n| !n.is_empty()).map(str::parse).collect();
    let least = mediapipe().count;
    match numbers.as_deref() {
        Ok(&[cameras, frames, points, coordinates]) if points >= least && coordinates >= 2 => {
            Ok([cameras, frames, points, coordinates])
        }
        _ => Err(format!(
            "an array of shape ({listed}), expected cameras, frames, {least} points or more, 2"
        )),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// As `numpy.save` writes it: `frames` of 34 points for each of two cameras, of which the last coordinate says where it lies.
    fn saved(descr: &str, shape: &str, numbers: &[f64]) -> tempfile::NamedTempFile {
        let text = format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': {shape}, }}");
        let padded = format!("{text:<117}\n");
        let mut bytes = MAGIC.to_vec();
        bytes.extend([1, 0]);
        bytes.extend((padded.len() as u16).to_le_bytes());
        bytes.extend(padded.as_bytes());
        for number in numbers {
            match descr {
                "<f8" => bytes.extend(number.to_le_bytes()),
                _ => bytes.extend((*number as f32).to_le_bytes()),
            }
        }
        let file = tempfile::Builder::new().suffix(".npy").tempfile().expect("a file");
        std::fs::write(file.path(), bytes).expect("a file");
        file
    }

    /// Camera c has point p of frame f at (100 c + p, f); nobody is in the last frame.
    fn numbers() -> Vec<f64> {
        let mut all = Vec::new();
        for (camera, frame, point) in
            (0..2).flat_map(|c| (0..3).flat_map(move |f| (0..34).map(move |p| (c, f, p))))
        {
            let at = [f64::from(100 * camera + point), f64::from(frame)];
            all.extend(if frame == 2 { [f64::NAN; 2] } else { at });
        }
        all
    }

    #[test]
    fn each_camera_has_its_part_of_an_array() {
        for descr in ["<f8", "<f4"] {
            let file = saved(descr, "(2, 3, 34, 2)", &numbers());
            assert!(is_array(file.path()));
            let table = read_array(file.path(), 1, 2).expect("a table");
            assert_eq!(table.len(), 3);
            let person = &table[&1][0];
            // MediaPipe's 25th point is the left knee
            let knee = person.iter().find(|(name, _)| *name == "LKnee").expect("a knee");
            assert_eq!(format!("{:?}", knee.1), "[125.0, 1.0, 1.0]");
            assert!(table[&2].is_empty());
        }
    }

    #[test]
    fn arrays_of_another_kind_are_told_in_one_line() {
        let all = numbers();
        for (file, part) in [
            (saved("<f8", "(2, 3, 34, 2)", &all[1..]), "bytes for its shape"),
            (saved("<i8", "(2, 3, 34, 2)", &all), "\"<i8\""),
            (saved("<f8", "(3, 34, 2)", &all), "shape (3, 34, 2)"),
            (saved("<f8", "(2, 6, 17, 2)", &all), "33 points or more"),
            (saved("<f8", "(3, 2, 34, 2)", &all), "an array of 3 cameras, 2 are calibrated"),
            (saved("<f8", "(2, 9999999999, 9999999999, 2)", &all), "512 MiB"),
        ] {
            let fault = read_array(file.path(), 0, 2).expect_err(part);
            assert!(fault.contains(part) && !fault.contains('\n'), "{part}: {fault}");
        }
        let text = tempfile::Builder::new().suffix(".npy").tempfile().expect("a file");
        std::fs::write(text.path(), "no array, but a text").expect("a file");
        assert!(read_array(text.path(), 0, 2).expect_err("a text").contains("NUMPY"));
    }
}
