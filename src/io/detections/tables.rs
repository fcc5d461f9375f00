//! Files that hold all pictures of a camera: tables by DeepLabCut and SLEAP, and COCO's JSON.
//!
//! | program    | file    | one row or entry is                                                                                   |
//! |------------|---------|-------------------------------------------------------------------------------------------------------|
//! | DeepLabCut | `.csv`  | a picture: its number, then x, y, likelihood of each point; above it rows `scorer`, `individuals` (of several people), `bodyparts`, `coords` |
//! | SLEAP      | `.csv`  | a person in a picture: `frame_idx`, and `<point>.x`, `<point>.y`, `<point>.score`                     |
//! | COCO       | `.json` | `annotations[]` of a person: `image_id`, `keypoints` x, y and confidence or visibility; `images[]` with `id` and `file_name`, whose last digits are the picture's number; `categories[].keypoints` names the points |
//!
//! Points are known by their names: a side (`left`, `l`, `right`, `r`, before or after) and a joint, as in `left_knee`, `KneeL`, `RHip`. Others are
//! not read.

use std::collections::BTreeMap;
use std::path::Path;

use csv::StringRecord;
use serde::Deserialize;

use crate::io::input;

/// One person in one picture: x, y and confidence of each point that has a known name.
pub type NamedPerson = Vec<(&'static str, [f64; 3])>;
/// The people of each picture, by its number.
pub type Table = BTreeMap<u64, Vec<NamedPerson>>;

/// The most bytes of a camera's detections: hours of one person.
pub(super) const MOST_BYTES: u64 = 512 << 20;
/// Joints of both sides, and points of neither, by Pose2Sim's names.
const SIDED: [[&str; 2]; 11] = [
    ["RHip", "LHip"],
    ["RKnee", "LKnee"],
    ["RAnkle", "LAnkle"],
    ["RBigToe", "LBigToe"],
    ["RSmallToe", "LSmallToe"],
    ["RHeel", "LHeel"],
    ["RShoulder", "LShoulder"],
    ["RElbow", "LElbow"],
    ["RWrist", "LWrist"],
    ["REye", "LEye"],
    ["REar", "LEar"],
];
const MIDDLE: [(&str, &str); 5] =
    [("nose", "Nose"), ("neck", "Neck"), ("head", "Head"), ("hip", "Hip"), ("midhip", "Hip")];

/// Pose2Sim's name of a point.
fn known(name: &str) -> Option<&'static str> {
    let letters = name.chars().filter(|c| c.is_alphabetic());
    let plain: String = letters.flat_map(char::to_lowercase).collect();
    let of_side = |name: &&'static str| {
        let joint = name[1..].to_lowercase();
        let sides = if name.starts_with('R') { ["right", "r"] } else { ["left", "l"] };
        sides
            .iter()
            .any(|side| plain == format!("{side}{joint}") || plain == format!("{joint}{side}"))
    };
    let middle = || MIDDLE.iter().find(|(word, _)| *word == plain).map(|(_, name)| *name);
    SIDED.as_flattened().iter().find(|name| of_side(name)).copied().or_else(middle)
}

/// Whether a file holds all pictures of a camera.
pub fn is_table(path: &Path) -> bool {
    let is = |ending: &str| path.extension().is_some_and(|extension| extension == ending);
    let bytes = || input::read(path, MOST_BYTES).unwrap_or_default();
    let is_coco = || {
        let wanted = b"\"annotations\"";
        bytes().windows(wanted.len()).any(|part| part == wanted)
    };
    path.is_file() && (is("csv") || is("json") && is_coco())
}

/// The people of all pictures of a camera.
///
/// # Errors
/// One line that says what is wrong with the file.
pub fn read_table(path: &Path) -> Result<Table, String> {
    let bytes = input::read(path, MOST_BYTES).map_err(|fault| fault.to_string())?;
    let is_json = path.extension().is_some_and(|extension| extension == "json");
    let table = if is_json { coco(&bytes)? } else { rows(&bytes)? };
    let is_named = table.values().flatten().any(|person| !person.is_empty());
    match table.is_empty() || is_named {
        true => Ok(table),
        false => Err("no point has the name of a joint, as left_knee".into()),
    }
}

#[derive(Deserialize)]
struct Coco {
    images: Vec<Pictured>,
    annotations: Vec<Annotated>,
    categories: Vec<Category>,
}

#[derive(Deserialize)]
struct Pictured {
    id: u64,
    file_name: String,
}

#[derive(Deserialize)]
struct Annotated {
    image_id: u64,
    #[serde(default)]
    keypoints: Vec<f64>,
}

#[derive(Deserialize)]
struct Category {
    #[serde(default)]
    keypoints: Vec<String>,
}

fn coco(bytes: &[u8]) -> Result<Table, String> {
    let all: Coco = serde_json::from_slice(bytes).map_err(|fault| {
        format!("expected COCO's JSON with images, annotations and categories: {fault}")
    })?;
    let names = all.categories.iter().find(|category| !category.keypoints.is_empty());
    let names = names.ok_or("expected categories[].keypoints, the names of the points")?;
    let names: Vec<Option<&'static str>> = names.keypoints.iter().map(|n| known(n)).collect();

    let mut number_of: BTreeMap<u64, u64> = BTreeMap::new();
    let mut table = Table::new();
    for picture in &all.images {
        let number = last_number(&picture.file_name)
            .ok_or_else(|| format!("image {:?} has no number", picture.file_name))?;
        number_of.insert(picture.id, number);
        table.entry(number).or_default();
    }
    for annotated in &all.annotations {
        let (points, rest) = annotated.keypoints.as_chunks::<3>();
        if !rest.is_empty() || points.len() > names.len() {
            return Err(format!(
                "an annotation has {} numbers: expected three for each of {} points",
                annotated.keypoints.len(),
                names.len()
            ));
        }
        let number = number_of.get(&annotated.image_id);
        let number = number.ok_or_else(|| format!("no image has the id {}", annotated.image_id))?;
        let named = names.iter().zip(points);
        let person = named.filter_map(|(name, point)| Some(((*name)?, *point)));
        table.entry(*number).or_default().push(person.collect());
    }
    Ok(table)
}

/// A table by DeepLabCut or SLEAP.
fn rows(bytes: &[u8]) -> Result<Table, String> {
    let mut reader = csv::ReaderBuilder::new().has_headers(false).flexible(true).from_reader(bytes);
    let rows: Result<Vec<StringRecord>, _> = reader.records().collect();
    let rows = rows.map_err(|fault| format!("expected a table: {fault}"))?;
    let first = rows.first().ok_or("expected a table, found nothing")?;
    if first.iter().any(|cell| cell == "frame_idx") {
        return sleap(&rows);
    }
    let header = |word: &str| rows.iter().take(4).find(|row| row.get(0) == Some(word));
    match (header("bodyparts"), header("coords")) {
        (Some(points), Some(kinds)) => deep_lab_cut(&rows, points, kinds, header("individuals")),
        _ => {
            Err("expected the rows bodyparts and coords of DeepLabCut, or frame_idx of SLEAP"
                .into())
        }
    }
}

/// The number in a cell, or 0 where nothing was seen.
fn value(row: &StringRecord, column: usize, line: usize) -> Result<f64, String> {
    match row.get(column).map(str::trim) {
        None | Some("" | "nan" | "NaN") => Ok(0.0),
        Some(cell) => {
            cell.parse().map_err(|_| format!("line {line}: expected a number, found {cell:?}"))
        }
    }
}

/// The columns of one point: its name, x, y and confidence.
type Columns = (&'static str, [usize; 3]);

fn person(row: &StringRecord, columns: &[Columns], line: usize) -> Result<NamedPerson, String> {
    let point = |(name, [x, y, confidence]): &Columns| {
        let value = |column: &usize| value(row, *column, line);
        Ok((*name, [value(x)?, value(y)?, value(confidence)?]))
    };
    columns.iter().map(point).collect()
}

fn deep_lab_cut(
    rows: &[StringRecord],
    points: &StringRecord,
    kinds: &StringRecord,
    people: Option<&StringRecord>,
) -> Result<Table, String> {
    // the columns of each person
    let mut of_person: BTreeMap<&str, Vec<Columns>> = BTreeMap::new();
    for x in (1..points.len()).filter(|column| kinds.get(*column) == Some("x")) {
        if kinds.get(x + 1) != Some("y") || kinds.get(x + 2) != Some("likelihood") {
            return Err(format!("column {}: expected x, y, likelihood one after the other", x + 1));
        }
        let own = people.and_then(|people| people.get(x)).unwrap_or_default();
        let name = points.get(x).and_then(known);
        of_person.entry(own).or_default().extend(name.map(|name| (name, [x, x + 1, x + 2])));
    }

    let mut table = Table::new();
    for (line, row) in rows.iter().enumerate() {
        let Some(number) = row.get(0).and_then(last_number) else { continue };
        let people = of_person.values().map(|columns| person(row, columns, line + 1));
        table.insert(number, people.collect::<Result<_, _>>()?);
    }
    Ok(table)
}

fn sleap(rows: &[StringRecord]) -> Result<Table, String> {
    let column = |name: &str| rows[0].iter().position(|cell| cell == name);
    let mut columns: Vec<Columns> = Vec::new();
    for (x, cell) in rows[0].iter().enumerate() {
        let Some(point) = cell.strip_suffix(".x") else { continue };
        let others = [column(&format!("{point}.y")), column(&format!("{point}.score"))];
        let [Some(y), Some(score)] = others else {
            return Err(format!("{point}: expected the columns {point}.y and {point}.score"));
        };
        columns.extend(known(point).map(|name| (name, [x, y, score])));
    }

    let number = column("frame_idx").unwrap_or(0);
    let mut table = Table::new();
    for (line, row) in rows.iter().enumerate().skip(1) {
        let cell = row.get(number).unwrap_or_default();
        let number = last_number(cell)
            .ok_or_else(|| format!("line {}: expected frame_idx, found {cell:?}", line + 1))?;
        table.entry(number).or_default().push(person(row, &columns, line + 1)?);
    }
    Ok(table)
}

/// The last digits of a name before its extension.
fn last_number(name: &str) -> Option<u64> {
    let stem = Path::new(name).file_stem()?.to_str()?;
    let end = stem.rfind(|c: char| c.is_ascii_digit())? + 1;
    let digits = stem[..end].rfind(|c: char| !c.is_ascii_digit()).map_or(0, |i| i + 1);
    stem[digits..end].parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    const DEEP_LAB_CUT: &str = "scorer,net,net,net,net,net,net\nbodyparts,left_knee,left_knee,left_knee,tail,tail,tail\n\
        coords,x,y,likelihood,x,y,likelihood\n0,10.5,20,0.9,1,1,0.9\n1,,,,1,1,0.5\n";
    const SLEAP: &str = "track,frame_idx,instance.score,KneeL.x,KneeL.y,KneeL.score,RHip.x,RHip.y,RHip.score\n\
        track_0,3,0.9,10.5,20,0.9,1,2,0.8\ntrack_1,3,0.9,30,40,0.7,,,\n";
    const COCO: &str = r#"{"images": [{"id": 7, "file_name": "cam/img_000012.png"}],
        "categories": [{"id": 1, "name": "person", "keypoints": ["nose", "left_knee", "tail"]}],
        "annotations": [{"id": 1, "image_id": 7, "keypoints": [1, 2, 0, 10.5, 20, 2, 0, 0, 0]}]}"#;

    fn table(text: &str, read: fn(&[u8]) -> Result<Table, String>) -> Table {
        read(text.as_bytes()).unwrap()
    }

    #[test]
    fn tables_by_deep_lab_cut_sleap_and_coco_hold_the_people_of_each_picture() {
        let cut = table(DEEP_LAB_CUT, rows);
        assert_eq!(cut[&0], [vec![("LKnee", [10.5, 20.0, 0.9])]]);
        assert_eq!(cut[&1], [vec![("LKnee", [0.0; 3])]]);

        let sleap = table(SLEAP, rows);
        assert_eq!(sleap[&3].len(), 2);
        assert_eq!(sleap[&3][0], [("LKnee", [10.5, 20.0, 0.9]), ("RHip", [1.0, 2.0, 0.8])]);

        let coco = table(COCO, coco);
        assert_eq!(coco[&12], [vec![("Nose", [1.0, 2.0, 0.0]), ("LKnee", [10.5, 20.0, 2.0])]]);
    }

    #[test]
    fn a_point_is_known_by_side_and_joint_in_any_order() {
        for name in ["LKnee", "left_knee", "knee_left", "Knee L", "l.knee"] {
            assert_eq!(known(name), Some("LKnee"), "{name}");
        }
        assert_eq!([known("neck"), known("tail"), known("knee")], [Some("Neck"), None, None]);
    }

    #[test]
    fn what_is_wrong_with_a_table_is_said_in_one_line() {
        for (text, part) in [
            ("", "found nothing"),
            ("a,b\n1,2\n", "bodyparts"),
            (&DEEP_LAB_CUT.replace("10.5", "ten"), "line 4: expected a number, found \"ten\""),
            (&DEEP_LAB_CUT.replace("x,y,likelihood", "x,y,z"), "x, y, likelihood"),
            (&SLEAP.replace("KneeL.score", "KneeL.s"), "KneeL.score"),
        ] {
            let fault = rows(text.as_bytes()).unwrap_err();
            assert!(fault.contains(part) && !fault.contains('\n'), "{fault}");
        }
        for (from, to, part) in [
            ("\"image_id\": 7", "\"image_id\": 8", "no image has the id 8"),
            ("10.5, 20, 2, 0, 0, 0", "10.5, 20, 2", "\0"),
            ("2, 0, 0, 0]", "2, 0, 0]", "has 8 numbers"),
            ("img_000012", "img", "no number"),
            ("\"images\"", "\"pictures\"", "images"),
        ] {
            match coco(COCO.replace(from, to).as_bytes()) {
                Ok(_) => assert_eq!(part, "\0", "{to}"),
                Err(fault) => assert!(fault.contains(part) && !fault.contains('\n'), "{fault}"),
            }
        }
    }
}
