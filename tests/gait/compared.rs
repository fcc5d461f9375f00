//! Two sessions compared: whether they are told to be of two people.

use maquette::pipeline::{Disagreement, OneBody};
use maquette::report::Language;
use maquette::workflow::{Comparison, NormChoice, SessionStudy};

use crate::walker::Walker;

/// Two walks of points, of which nobody knows whose they are.
fn compared() -> Comparison {
    let folder = tempfile::tempdir().expect("a folder");
    let walk = |name: &str, heading: f64| {
        let path = folder.path().join(name);
        std::fs::write(&path, Walker::new(heading).trc()).expect("a file");
        SessionStudy::open(&path, None, NormChoice::None).expect("a walk")
    };
    Comparison::new(walk("before.trc", 0.3), walk("after.trc", 0.4)).expect("numbers of both")
}

/// What the column says in all rows of the table.
fn column(comparison: &Comparison) -> Vec<String> {
    let table = String::from_utf8(comparison.csv().expect("a table")).expect("UTF-8");
    let last = |row: &str| row.rsplit(',').next().map(str::to_owned);
    assert_eq!(table.lines().next().and_then(last).as_deref(), Some("one_body"));
    table.lines().skip(1).filter_map(last).collect()
}

#[test]
fn points_do_not_say_whether_two_walks_are_of_one_person() {
    let comparison = compared();
    assert_eq!((&comparison.one_body, comparison.two_bodies()), (&OneBody::Unknown, None));
    assert!(column(&comparison).iter().all(|said| said == "unknown"));
    assert!(!comparison.report(Language::English).contains("The bodies differ"));
}

#[test]
fn two_bodies_are_told_in_a_line_in_the_table_and_on_the_page_in_each_language() {
    let mut comparison = compared();
    comparison.one_body = OneBody::No(Disagreement {
        trial: 1,
        f: 20.3,
        degrees: [8, 9],
        probability: 1e-30,
        length: "shank".into(),
        own_m: 0.433,
        others_m: 0.518,
    });

    let first = comparison.lines().swap_remove(0);
    let said = "shank 0.518 m in before.trc, 0.433 m in after.trc (all lengths: F(8, 9) = 20)";
    assert!(first.contains(said), "{first}");
    assert!(column(&comparison).iter().all(|said| said == "no"));
    let page = comparison.report(Language::English);
    assert!(page.contains("The bodies differ: shank 0.518 m in before.trc, 0.433 m in after.trc"));
    let page = comparison.report(Language::German);
    assert!(page.contains("Unterschenkel 0,518 m in before.trc, 0,433 m in after.trc"));
}
