//! Files of 2-D detections by other programs: OpenPose's JSON, as OpenPose, Pose2Sim, RTMPose and AlphaPose write it, tables that hold
//! all pictures of a camera ([`read_table`]), and arrays that hold those of all cameras ([`read_array`]).
//!
//! One file of OpenPose's holds the people of one picture, in any order; a person is a list of x, y and confidence, three numbers for each
//! point of a [`KeypointSet`]. A point that was not seen is 0, 0, 0.

mod arrays;
mod sets;
mod tables;

use std::path::Path;

use serde::Deserialize;

use super::input;
pub use arrays::{is_array, read_array};
pub use sets::KeypointSet;
pub use tables::{NamedPerson, Table, is_table, read_table};

/// One person in one picture: x and y, pixels of the recorded picture, and confidence, of each point of the set.
pub type Person = Vec<[f64; 3]>;

/// The most bytes of one picture's detections: hundreds of people with faces and hands.
const MOST_BYTES: u64 = 16 << 20;

#[derive(Deserialize)]
struct Pictured {
    people: Vec<Listed>,
}

#[derive(Deserialize)]
struct Listed {
    pose_keypoints_2d: Vec<f64>,
}

/// The people of one picture. Those without any point are left out.
///
/// # Errors
/// One line that says what is wrong with the file.
pub fn read(path: &Path) -> Result<Vec<Person>, String> {
    let bytes = input::read(path, MOST_BYTES).map_err(|fault| fault.to_string())?;
    parse(&bytes)
}

fn parse(bytes: &[u8]) -> Result<Vec<Person>, String> {
    let pictured: Pictured = serde_json::from_slice(bytes)
        .map_err(|fault| format!("expected OpenPose's JSON with `people`: {fault}"))?;
    let person = |(index, listed): (usize, &Listed)| {
        let (triples, rest) = listed.pose_keypoints_2d.as_chunks::<3>();
        match rest {
            [] => Ok(triples.to_vec()),
            _ => Err(format!(
                "person {index}: expected three numbers for each point, found {}",
                listed.pose_keypoints_2d.len()
            )),
        }
    };
    let people: Result<Vec<Person>, String> =
        pictured.people.iter().enumerate().map(person).collect();
    let is_seen = |person: &Person| person.iter().any(|[_, _, confidence]| *confidence > 0.0);
    Ok(people?.into_iter().filter(is_seen).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn people_are_read_in_any_number_and_faults_are_said_in_one_line() {
        let two = br#"{"version": 1.3, "people": [
            {"person_id": [-1], "pose_keypoints_2d": [1, 2.5, 0.9, 0, 0, 0]},
            {"pose_keypoints_2d": [0, 0, 0, 0, 0, 0]},
            {"pose_keypoints_2d": [3, 4, 0.1, 5, 6, 1.0], "face_keypoints_2d": []}]}"#;
        let people = parse(two).unwrap();
        assert_eq!(
            people,
            [vec![[1.0, 2.5, 0.9], [0.0; 3]], vec![[3.0, 4.0, 0.1], [5.0, 6.0, 1.0]]]
        );
        assert_eq!(parse(br#"{"people": []}"#).unwrap(), Vec::<Person>::new());

        for (text, part) in [
            (&br#"{"people": [{"pose_keypoints_2d": [1, 2"#[..], "EOF"),
            (br#"{"people": [{"pose_keypoints_2d": [1, 2]}]}"#, "found 2"),
            (br#"{"persons": []}"#, "people"),
            (b"", "people"),
        ] {
            let fault = parse(text).unwrap_err();
            assert!(fault.contains(part) && !fault.contains('\n'), "{fault}");
        }
    }
}
