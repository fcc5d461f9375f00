//! `maquette gait` from outside.

use assert_cmd::Command;
use tempfile::TempDir;

use crate::walker::Walker;

/// What the program prints on a text: standard output, or the one line on standard error.
fn said(trc: &str, arguments: &[&str]) -> Result<(String, TempDir), String> {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("walk.trc");
    std::fs::write(&path, trc).expect("a file");
    let mut program = Command::cargo_bin("maquette").expect("the program");
    let output = program.arg("gait").arg(&path).args(arguments).output().expect("it runs");
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    match output.status.code() {
        Some(0) => Ok((text(&output.stdout), folder)),
        Some(2) => {
            let line = text(&output.stderr);
            assert_eq!(line.lines().count(), 1, "{line}");
            Err(line)
        }
        other => panic!("exit {other:?}: {}", text(&output.stderr)),
    }
}

#[test]
fn a_walk_gives_tables_and_four_files() {
    let (text, folder) = said(&Walker::new(0.4).trc(), &[]).expect("a walk");
    for part in [
        "over ground",
        "step_length",
        "foot strike",
        "knee_flexion",
        "GVS",
        "hip_rotation: the turn",
    ] {
        assert!(text.contains(part), "{part} not in {text}");
    }
    let out = folder.path().join("walk_gait");
    let json = std::fs::read_to_string(out.join("gait.json")).expect("gait.json");
    let json: serde_json::Value = serde_json::from_str(&json).expect("JSON");
    assert_eq!(json["format"], "maquette-gait");
    assert_eq!(json["curves"][0]["mean_deg"].as_array().map(Vec::len), Some(101));
    for (name, columns) in [("curves.csv", 9), ("parameters.csv", 6), ("angles.csv", 20)] {
        let mut reader = csv::Reader::from_path(out.join(name)).expect("a table");
        assert!(reader.headers().expect("a heading").len() >= columns, "{name}");
        assert!(reader.records().all(|r| r.is_ok()), "{name}");
    }
}

/// What the program says of a walk with angles from a standing pose.
fn said_from(standing: &Walker, more: &[&str]) -> Result<(String, TempDir), String> {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("standing.trc");
    std::fs::write(&path, standing.trc()).expect("a file");
    let path = path.display().to_string();
    said(&Walker::new(0.4).trc(), &[&["--neutral", &path], more].concat())
}

/// `gait.json`, and the mean curve of the left knee's flexion in it.
fn of_the_knee(folder: &TempDir) -> (serde_json::Value, Vec<f64>) {
    let json = std::fs::read_to_string(folder.path().join("walk_gait/gait.json"));
    let json: serde_json::Value = serde_json::from_str(&json.expect("gait.json")).expect("JSON");
    let curves = json["curves"].as_array().expect("curves");
    let knee = curves.iter().find(|c| c["angle"] == "knee_flexion" && c["side"] == "left");
    let mean = knee.expect("a knee")["mean_deg"].as_array().expect("a curve").clone();
    (json, mean.iter().filter_map(serde_json::Value::as_f64).collect())
}

#[test]
fn angles_are_counted_from_a_standing_pose() {
    let (_, whole) = said(&Walker::new(0.4).trc(), &[]).expect("a walk");
    let bent = 0.2_f64;
    let (text, folder) = said_from(&Walker::standing(bent), &[]).expect("a walk");
    let ((_, before), (json, after)) = (of_the_knee(&whole), of_the_knee(&folder));
    for (before, after) in before.iter().zip(&after) {
        approx::assert_relative_eq!(before - after, bent.to_degrees(), epsilon = 0.3);
    }
    assert_eq!(json["neutral"]["angles"].as_array().map(Vec::is_empty), Some(false));
    assert!(text.contains("angles are counted from the standing pose in "), "{text}");
    // a norm of anatomical axes compares by form alone
    let score = text.lines().find(|line| line.contains("GVS knee_flexion")).expect("a score");
    assert_eq!(score.split_whitespace().nth(2), Some("–"), "{score}");
    assert!(json["indices"]["variables"][3]["without_offset"].is_number());
}

#[test]
fn a_trial_that_is_no_standing_pose_of_the_person_is_refused() {
    let line = said_from(&Walker::squat(), &[]).expect_err("somebody who moves");
    assert!(line.contains("flexion varies by ± "), "{line}");
    let child = Walker::standing(0.1).scaled(0.7);
    let line = said_from(&child, &[]).expect_err("another person");
    assert!(line.contains("another person, or another scale"), "{line}");
    let line = said(&Walker::new(0.4).trc(), &["--neutral", "."]).expect_err("a folder");
    assert!(line.contains("both fits of one body, or both points"), "{line}");
}

#[test]
fn spaces_for_tabs_are_read_as_tabs_are() {
    let trc = Walker::new(0.4).trc();
    let spaced = trc.replace('\t', " ").replace("  ", " ");
    let head = |text: &str| text.lines().skip(1).take(12).map(str::to_owned).collect::<Vec<_>>();
    let (a, b) = (said(&trc, &[]).expect("tabs").0, said(&spaced, &[]).expect("spaces").0);
    assert_eq!(head(&a), head(&b));
    let torn = spaced.replacen(" 0.010000", "", 1);
    let line = said(&torn, &[]).expect_err("a cell is missing");
    assert!(
        line.contains("walk.trc:7: expected 53 cells (17 points) between spaces, found 52"),
        "{line}"
    );
}

/// The text with other cells for one point, row by row: its x, y, z or what stands there.
fn with_point(trc: &str, name: &str, act: impl Fn(usize, f64) -> String) -> String {
    let names = trc.lines().nth(3).expect("names");
    let first = names.split('\t').position(|n| n == name).expect(name);
    let row = |(i, line): (usize, &str)| {
        let cell = |(k, cell): (usize, &str)| match (
            i >= 5 && (first..first + 3).contains(&k),
            cell.parse(),
        ) {
            (true, Ok(value)) => act(i - 5, value),
            _ => cell.to_owned(),
        };
        line.split('\t').enumerate().map(cell).collect::<Vec<_>>().join("\t")
    };
    trc.lines().enumerate().map(row).collect::<Vec<_>>().join("\n")
}

#[test]
fn what_a_file_lacks_is_said_beside_what_it_gives() {
    let trc = Walker::new(0.0).trc();
    let gap = |row: usize, value: f64| match (30..60).contains(&row) {
        true => String::new(),
        false => value.to_string(),
    };
    let (text, _) = said(&with_point(&trc, "LKnee", gap), &[]).expect("a walk with a gap");
    assert!(text.contains("and neither is what depends on them: left knee 30"), "{text}");
    let (text, _) = said(&trc, &[]).expect("a walk");
    assert!(!text.contains("not known in some") && !text.contains("Y axis"), "{text}");
    // what was up lies to the side
    let lying = trc.lines().enumerate().map(|(i, line)| {
        let mut cells: Vec<&str> = line.split('\t').collect();
        if i >= 5 {
            cells[2..].chunks_mut(3).filter(|c| c.len() == 3).for_each(|c| c.swap(1, 2));
        }
        cells.join("\t")
    });
    let (text, _) = said(&lying.collect::<Vec<_>>().join("\n"), &[]).expect("angles");
    assert!(text.contains("is the file's Y axis up"), "{text}");
}

#[test]
fn each_pass_of_somebody_who_comes_back_is_analysed_alone() {
    let trc = Walker::new(0.0).who_returns(60, nalgebra::Vector3::new(0.0, 2.0, 0.0)).trc();
    let (text, _) = said(&trc, &[]).expect("a walk");
    assert!(text.contains("all numbers are of pass 1; --pass chooses another"), "{text}");
    let (text, _) = said(&trc, &["--pass", "2"]).expect("a walk");
    assert!(text.contains("all numbers are of pass 2"), "{text}");
    let line = said(&trc, &["--pass", "3"]).expect_err("two passes");
    assert!(line.contains("pass 3: the recording holds 2"), "{line}");
}

#[test]
fn an_age_and_a_sex_choose_the_norm_of_steps() {
    let trc = Walker::new(0.0).trc();
    let (text, _) = said(&trc, &["--age", "72", "--sex", "female"]).expect("a walk");
    assert!(text.contains("1.160 ± 0.200"), "{text}");
    let (text, _) = said(&trc, &["--age", "34"]).expect("a walk");
    assert!(text.contains("1.245 ± 0.153"), "{text}");
    let (text, _) = said(&trc, &["--age", "44", "--sex", "female"]).expect("a walk");
    assert!(!text.contains(" ± 0."), "{text}");
}

#[test]
fn an_age_chooses_the_norm_of_angles_or_says_that_there_is_none() {
    let trc = Walker::new(0.0).trc();
    let of = |age: &str| said(&trc, &["--age", age, "--footwear", "shoes"]).expect("a walk").0;
    let adult = of("34");
    assert!(
        adult.contains("against fukuchi-2018-young: Fukuchi, Fukuchi & Duarte 2018"),
        "{adult}"
    );
    assert!(adult.contains("walked barefoot, this person in shoes"), "{adult}");
    assert!(of("9").contains("against schwartz-2008-free"));
    let nobody = of("19");
    assert!(!nobody.contains("GVS") && nobody.contains("! no norm that comes with"), "{nobody}");
    let (unknown, _) = said(&trc, &[]).expect("a walk");
    assert!(
        unknown.contains("no age is stated, so angles are compared with children"),
        "{unknown}"
    );
}

#[test]
fn each_bad_file_has_its_line() {
    let trc = Walker::new(0.0).trc();
    let cases = [
        (
            "one point in another unit",
            with_point(&trc, "LKnee", |_, value| (1e3 * value).to_string()),
            "the left knee (LKnee) lies",
        ),
        (
            "another unit than it states",
            trc.replacen("\tm\t", "\tmm\t", 1),
            "does the file state the right unit?",
        ),
        (
            "another rate than its times",
            trc.replacen("100\t100\t", "25\t100\t", 1),
            "the header states 25 Hz, the Time column 100",
        ),
        (
            "no ankle",
            trc.replace("LAnkle", "X"),
            "no point is named as the left ankle: expected names such as RAnkle",
        ),
        ("no walk", "hello\n".to_owned(), "this is no TRC file"),
    ];
    for (what, text, expected) in cases {
        let line = said(&text, &[]).expect_err(what);
        assert!(line.contains(expected), "{what}: {line}");
    }
    let told = said(&trc.replacen("100\t100\t", "25\t100\t", 1), &["--fps", "100"]);
    assert!(told.is_ok());
}

#[test]
fn backwards_and_squats_are_said_in_one_line_and_give_angles() {
    for (walker, expected) in
        [(Walker::new(0.0).reversed(), "! walks backwards"), (Walker::squat(), "! no steps")]
    {
        let (text, folder) = said(&walker.trc(), &[]).expect("angles");
        assert!(text.contains(expected), "{text}");
        let angles =
            std::fs::read_to_string(folder.path().join("walk_gait/angles.csv")).expect("angles");
        assert!(angles.starts_with("frame,time_s,pelvis_obliquity_l_deg"), "{angles:.80}");
    }
}

#[test]
fn a_norm_can_be_left_out_or_be_ones_own() {
    let trc = Walker::new(0.0).trc();
    let (text, folder) = said(&trc, &["--norm", "none"]).expect("a walk");
    assert!(!text.contains("GVS"));
    let own = folder.path().join("own.toml");
    std::fs::write(
        &own,
        "name = \"own\"\nsource = \"us\"\n[parameter.speed]\nmean = 1.3\nsd = 0.1\n",
    )
    .expect("a file");
    let (text, _) = said(&trc, &["--norm", own.to_str().expect("a name")]).expect("a walk");
    assert!(text.contains("1.300 ± 0.100"), "{text}");
    let (text, _) = said(&trc, &["--normalised"]).expect("a walk");
    assert!(text.contains("step_length     "), "{text}");
}

#[test]
fn an_export_of_points_is_refused_in_one_line() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("walk.trc");
    std::fs::write(&path, Walker::new(0.4).trc()).expect("a file");
    let mut program = Command::cargo_bin("maquette").expect("the program");
    let output = program.arg("export").arg(&path).output().expect("it runs");
    let line = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{line}");
    assert_eq!(line.lines().count(), 1, "{line}");
    assert!(line.contains("walk.trc: expected the folder of a finished fit"), "{line}");
}
