//! `maquette gait --report` from outside; the page in a browser is tested by `web/test/report.mjs`.

use std::collections::BTreeSet;

use assert_cmd::Command;

use crate::walker::Walker;

fn report_of(trc: &str, arguments: &[&str]) -> String {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("walk.trc");
    std::fs::write(&path, trc).expect("a file");
    let mut program = Command::cargo_bin("maquette").expect("the program");
    let run = program.arg("gait").arg(&path).arg("--report");
    run.args(arguments).assert().success();
    std::fs::read_to_string(folder.path().join("walk_gait/report.html")).expect("the report")
}

/// The text of one page, without its tags.
fn page<'a>(report: &'a str, id: &str) -> &'a str {
    let start = report.find(&format!("<section id=\"{id}\"")).expect(id);
    let end = report[start..].find("</section>").expect("its end");
    &report[start..start + end]
}

#[test]
fn a_walk_fills_every_page_that_points_can_fill() {
    let arguments = ["--subject", "A & B", "--condition", "barefoot"];
    let report = report_of(&Walker::new(0.4).trc(), &arguments);
    assert!(page(&report, "identity").contains("A &amp; B"));
    assert!(page(&report, "quality").contains("another system"));
    assert!(page(&report, "spatiotemporal").contains("Walking speed"));
    assert!(page(&report, "scores").contains("Knee flexion"));
    let kinematics = page(&report, "kinematics");
    assert!(kinematics.matches("<svg").count() >= 8, "charts");
    assert!(kinematics.contains("the turn"), "why hip rotation is not there");
    for number in ["NaN", "inf"] {
        assert!(!kinematics.contains(number), "{number}");
    }
}

#[test]
fn a_squat_gets_angles_over_time_and_the_reason() {
    let report = report_of(&Walker::squat().trc(), &[]);
    assert!(page(&report, "spatiotemporal").contains("no steps"));
    assert!(page(&report, "consistency").contains("no steps"));
    let kinematics = page(&report, "kinematics");
    assert!(kinematics.contains("time, s") && kinematics.contains("<svg"));
    assert!(report.contains("<section id=\"consistency\" class=\"brief\""));
}

#[test]
fn the_column_norm_says_whose_it_is_or_why_it_is_empty() {
    let trc = Walker::new(0.4).trc();
    let said = |arguments: &[&str]| {
        let report = report_of(&trc, arguments);
        page(&report, "spatiotemporal").to_owned()
    };
    assert!(said(&["--age", "80", "--sex", "male"]).contains("men of 80 to 84 years"));
    assert!(said(&[]).contains("as the age was not stated"));
    assert!(said(&["--age", "34"]).contains("24 adults of 21 to 37 years"));
    assert!(said(&["--age", "44"]).contains("no table for: 44 years"));
}

#[test]
fn numbers_beyond_the_norm_are_marked_and_its_footwear_is_said() {
    let trc = Walker::new(0.4).trc();
    let person = ["--age", "9", "--footwear"];
    let said = |footwear: &str| {
        let report = report_of(&trc, &[&person[..], &[footwear]].concat());
        page(&report, "spatiotemporal").to_owned()
    };
    let barefoot = said("barefoot");
    // an adult's cadence is far below a child's
    assert!(barefoot.contains("▼") && barefoot.contains("below the norm"), "{barefoot}");
    assert!(barefoot.contains("walked in shoes, this person barefoot"), "{barefoot}");
    assert!(!said("shoes").contains("Before comparing"));
}

/// What a person reads on a page, piece by piece, but pieces that are marked as English.
fn pieces(report: &str) -> BTreeSet<&str> {
    let body = report.split("<main>").nth(1).expect("a main part");
    let body = body.split("<script").next().unwrap_or_default();
    let tags = body.split('<').filter_map(|part| part.split_once('>'));
    let own = tags.filter(|(tag, _)| !tag.contains("lang=\"en\"")).map(|(_, text)| text.trim());
    own.filter(|text| text.chars().filter(|c| c.is_alphabetic()).count() > 3).collect()
}

#[test]
fn in_german_no_english_is_left_but_names_and_what_is_marked() {
    let trc = Walker::new(0.4).trc();
    let person = ["--subject", "P 017", "--age", "30", "--sex", "female", "--date", "heute"];
    let english = report_of(&trc, &[&person[..], &["--language", "en"]].concat());
    assert_eq!(english, report_of(&trc, &person), "English unless asked otherwise");

    let german = report_of(&trc, &[&person[..], &["--language", "de"]].concat());
    assert!(german.contains("<html lang=\"de\">"));
    let steps = page(&german, "spatiotemporal");
    for text in ["Doppelschrittlänge", "Standphase", "Kadenz", "Schritte/min", "1,"] {
        assert!(steps.contains(text), "{text}: {steps}");
    }
    let both: Vec<&str> = pieces(&english).intersection(&pieces(&german)).copied().collect();
    let names = [
        "Abd", "Ext", "Person", "Norm", "Filter", "Gait", "Sagittal", "Frontal", "walk.trc",
        "P 017", "heute",
    ];
    let is_name = |text: &&&str| names.iter().any(|name| text.starts_with(name));
    // the norm's own name and source stand in its file
    let left = both.iter().filter(|text| !is_name(text) && !text.contains("20"));
    assert_eq!(left.collect::<Vec<_>>(), [&""; 0]);
}
