//! Several trials of one person, and two sessions compared.

use std::collections::BTreeMap;
use std::fs;
#[cfg(unix)]
use std::os::unix::fs::PermissionsExt;
use std::path::Path;
#[cfg(unix)]
use std::process::Command;

use maquette::gait::trials::{Change, Quantity};
use maquette::gait::{NeutralPose, Parameter};
use maquette::io::session::{Person, SessionFile, TrialPart};
use maquette::workflow::{Comparison, NormChoice, SessionStudy};
use serde_json::Value;

use crate::arm::{Arm, Ran, run};
#[cfg(unix)]
use crate::arm::{program, ran};
use crate::schema::check;
use crate::walker::Walker;

fn copied(from: &Path, to: &Path) {
    fs::create_dir_all(to).expect("a folder");
    for entry in fs::read_dir(from).expect("a folder").flatten() {
        let (path, place) = (entry.path(), to.join(entry.file_name()));
        match path.is_dir() {
            true => copied(&path, &place),
            false => drop(fs::copy(&path, &place).expect("a file")),
        }
    }
}

/// A folder with the trials `wave2` and `wave10`.
fn two_trials() -> Arm {
    let arm = Arm::new();
    for name in ["wave10", "wave2"] {
        copied(&arm.recording(), &arm.out("trials").join(name));
    }
    arm
}

fn session(arm: &Arm, trials: &str, more: &[&str]) -> Ran {
    let (trials, out) =
        (arm.out(trials).display().to_string(), arm.out("out").display().to_string());
    let options = ["--out", &out, "--fps", "10", "--body", "arm-2d", "--json", "--quiet"];
    run(&[&["session", &trials][..], &options, more].concat())
}

#[test]
fn a_folder_of_trials_gets_one_body_and_is_taken_up_again() {
    let arm = two_trials();
    let said = check("session", &session(&arm, "trials", &[]).succeeded().out);
    let trials = said["session"]["trials"].as_array().expect("trials");
    let names: Vec<&Value> = trials.iter().map(|trial| &trial["name"]).collect();
    assert_eq!(names, ["wave2", "wave10"]);
    assert_eq!(said["session"]["disagreements"].as_array().map(Vec::len), Some(0));

    // one body; a trial that is the other one again tells nothing new of it
    let of = |folder: &str| arm.result(&format!("out/{folder}"))["shape"].clone();
    assert_eq!(of("trials/wave2")["coefficients"], of("trials/wave10")["coefficients"]);
    let sd =
        |folder: &str| of(folder)["lengths"][0]["sd_m"].as_f64().expect("a standard deviation");
    let (together, alone) = (sd("trials/wave2"), sd("alone/wave2"));
    assert!((0.8..1.2).contains(&(together / alone)), "{together} {alone}");

    let written = arm.bytes("out", "session.json");
    session(&arm, "trials", &[]).refused(&["not empty", "--resume"]);
    let again = session(&arm, "trials", &["--resume"]).succeeded();
    assert!(again.err.contains("trial wave2: taken up"), "{}", again.err);
    assert_eq!(arm.bytes("out", "session.json"), written);

    let fewer = session(&arm, "trials", &["--resume", "--without", "wave2"]).succeeded();
    let fewer: Value = serde_json::from_str(&fewer.out).expect("JSON");
    assert_eq!(fewer["session"]["without"][0], "wave2");
    assert_eq!(fewer["session"]["trials"].as_array().map(Vec::len), Some(1));

    // who walked stands in session.toml
    let out = arm.out("out").display().to_string();
    run(&["report", &out, "--neutral", &out]).refused(&["--neutral: ", "session.toml"]);
    run(&["report", &out, "--events", "none"]).refused(&["--events: ", "events.json"]);
}

#[test]
fn a_session_that_is_none_is_refused_in_one_line() {
    let arm = Arm::new();
    fs::create_dir_all(arm.out("empty")).expect("a folder");
    session(&arm, "empty", &[]).refused(&["empty: no recordings there", "session.toml"]);
    session(&arm, "recording", &["--without", "walk"]).refused(&["--without walk", "recording"]);
    session(&arm, "recording", &["--without", "recording"]).refused(&["leaves no walk"]);
    for (text, expected) in [
        ("[person]\nbirthdate = \"1953-04-12\"\n", "session.toml:2: unknown field `birthdate`"),
        ("[person]\nbirth_date = \"53-4-12\"\n", "expected a day as 1953-04-12"),
        ("[[trial]]\nrecording = \"nowhere\"\n", "trial nowhere: "),
    ] {
        fs::write(arm.out("empty").join("session.toml"), text).expect("a file");
        session(&arm, "empty", &[]).refused(&[expected]);
    }
    let out = arm.out("compared").display().to_string();
    let empty = arm.out("empty").display().to_string();
    run(&["compare", &empty, &empty, "--out", &out]).refused(&["result.json: cannot be read"]);
}

#[test]
fn two_walks_are_compared_and_one_trial_each_says_nothing_of_chance() {
    let arm = Arm::new();
    let walks = [("one.trc", 0.3), ("another.trc", 0.4)].map(|(name, heading)| {
        fs::write(arm.out(name), Walker::new(heading).trc()).expect("a file");
        arm.out(name).display().to_string()
    });
    let out = arm.out("compared").display().to_string();
    let said = run(&["compare", &walks[0], &walks[1], "--out", &out, "--json"]).succeeded();
    assert!(said.err.contains("one trial each"), "{}", said.err);
    let said = check("compare", &said.out);
    assert_eq!(said["one_body"], "unknown");
    let changes = said["changes"].clone();
    let length = |change: &&Value| change["number"] == "step_length" && change["side"] == "left";
    let step = changes.as_array().expect("changes").iter().find(length).expect("step length");
    // the same walk in another direction
    assert!(step["change"].as_f64().is_some_and(|change| change.abs() < 0.02), "{step}");
    assert_eq!((&step["mdc"], &step["beyond_mdc"]), (&Value::Null, &Value::Bool(false)));
    let table = String::from_utf8(arm.bytes("compared", "changes.csv")).expect("UTF-8");
    assert!(
        table.starts_with("number,side,unit,before,") && table.contains("\nstep_length,left,m,")
    );
    let page = String::from_utf8(arm.bytes("compared", "compare.html")).expect("UTF-8");
    assert!(page.contains("one.trc") && page.contains("Nothing is known of chance"));
    let german =
        ["compare", &walks[0], &walks[1], "--out", &out, "--overwrite", "--language", "de"];
    run(&german).succeeded();
    let page = String::from_utf8(arm.bytes("compared", "compare.html")).expect("UTF-8");
    assert!(page.contains("lang=\"de\"") && page.contains("Über den Zufall ist nichts bekannt"));
}

/// Two barefoot walks and two in shoes, and one of no condition.
fn of_conditions(arm: &Arm) -> SessionStudy {
    let names = ["walk_1", "walk_2", "walk_3", "walk_4", "walk_5"];
    let conditions = ["barefoot", "barefoot", "shoes", "shoes"].map(|name| Some(name.to_owned()));
    let mut file = SessionFile::new(Person::default(), "human-ellipsoids".into());
    let mut trials = Vec::new();
    for ((k, name), condition) in
        names.into_iter().enumerate().zip(conditions.into_iter().chain([None]))
    {
        let path = arm.out(name).with_extension("trc");
        fs::write(&path, Walker::new(0.3 + 0.1 * k as f64).trc()).expect("a file");
        let alone = SessionStudy::open(&path, None, NormChoice::Shipped).expect("a walk");
        let (_, mut study) = alone.trials.into_iter().next().expect("one trial");
        // far more than the walks differ by
        let parameters = study.analysis.parameters.values_mut();
        parameters.for_each(|statistic| statistic.uncertainty = Some(0.1 * statistic.mean.abs()));
        trials.push((name.to_owned(), study));
        let (folder, alone) = (path.clone(), path);
        let (frames, fps, verdict) = (0, 100.0, None);
        let name = name.into();
        let standing = false;
        let part = TrialPart { name, condition, standing, folder, alone, frames, fps, verdict };
        file.trials.push(part);
    }
    SessionStudy { name: "both".into(), path: arm.out("both"), file: Some(file), trials }
}

#[test]
fn conditions_of_a_session_have_one_body_and_its_uncertainty_cancels() {
    let arm = Arm::new();
    let session = of_conditions(&arm);
    let comparison = Comparison::of_conditions(&session, None).expect("two conditions");
    let names = |study: &SessionStudy| -> Vec<String> {
        study.trials.iter().map(|(name, _)| name.clone()).collect()
    };
    assert_eq!(names(&comparison.before), ["walk_1", "walk_2"]);
    assert_eq!(names(&comparison.after), ["walk_3", "walk_4"]);
    assert!(comparison.notes.iter().any(|note| note.contains("have one body")));

    let step = |comparison: &Comparison| {
        let is_step = |change: &&Change| {
            change.measure.quantity == Quantity::Parameter(Parameter::StepLength)
        };
        let (low, high) =
            comparison.changes.iter().find(is_step).and_then(|c| c.interval).expect("an interval");
        high - low
    };
    let mut alone = [comparison.before.clone(), comparison.after.clone()];
    alone.iter_mut().for_each(|study| study.file = None);
    let [before, after] = alone;
    let apart = Comparison::new(before, after).expect("two sessions");
    assert!(step(&comparison) < 0.2 * step(&apart), "{} {}", step(&comparison), step(&apart));

    let turned = Comparison::of_conditions(&session, Some(["shoes", "barefoot"])).expect("both");
    assert_eq!(names(&turned.before), ["walk_3", "walk_4"]);
    let refused = |named| Comparison::of_conditions(&session, named).unwrap_err().to_string();
    assert!(refused(Some(["shoes", "sandals"])).contains("sandals: no trial has that condition"));
    assert!(refused(Some(["shoes", "shoes"])).contains("expected two that differ"));
}

#[test]
fn the_right_side_is_compared_with_the_left_of_the_same_trials() {
    let arm = Arm::new();
    let session = of_conditions(&arm);
    let comparison = Comparison::of_sides(&session).expect("two sides");
    let is_step =
        |change: &&Change| change.measure.quantity == Quantity::Parameter(Parameter::StepLength);
    let steps: Vec<&Change> = comparison.changes.iter().filter(is_step).collect();
    let [step] = steps.as_slice() else { panic!("{steps:?}") };
    // the walker's sides are alike, and of each the fit is said not to know a tenth
    let (low, high) = step.interval.expect("an interval of five trials");
    let known = (high - low) / step.before.mean;
    assert!((2.0 * 1.96 * 0.1..0.8).contains(&known), "{low} to {high}");
    assert!(comparison.curves.is_empty() && comparison.notes.len() == 2);
    approx::assert_abs_diff_eq!(step.difference, 0.0, epsilon = 0.02);
    let table = String::from_utf8(comparison.csv().expect("a table")).expect("UTF-8");
    assert!(table.contains("\nstep_length,both,m,") && !table.contains(",left,"), "{table}");

    let walk = arm.out("walk_1.trc").display().to_string();
    let out = arm.out("sides").display().to_string();
    let words = ["compare", &walk, "--sides", "--out", &out, "--json"];
    let said = run(&words).succeeded();
    assert!(said.err.contains("one trial: how far trials differ"), "{}", said.err);
    let said = check("compare", &said.out);
    let sides: Vec<&Value> =
        said["changes"].as_array().expect("changes").iter().map(|change| &change["side"]).collect();
    assert!(!sides.is_empty() && sides.iter().all(|side| **side == "both"), "{sides:?}");
    run(&[&words[..], &["--overwrite", "--language", "de"]].concat()).succeeded();
    let page = String::from_utf8(arm.bytes("sides", "compare.html")).expect("UTF-8");
    assert!(
        page.contains("Rechte Seite minus linke Seite") && page.contains("ein Versuch"),
        "page"
    );
    run(&["compare", &walk, &walk, "--sides", "--out", &out]).refused(&["--sides"]);
}

#[test]
fn a_session_of_other_than_two_conditions_is_not_compared_with_itself() {
    let arm = Arm::new();
    let walk = arm.out("walk.trc").display().to_string();
    fs::write(&walk, Walker::new(0.3).trc()).expect("a file");
    let out = arm.out("compared").display().to_string();
    run(&["compare", &walk, "--out", &out]).refused(&["expected two, found none", "session.toml"]);
    let named = ["--conditions", "a", "b"];
    run(&[&["compare", &walk, "--out", &out][..], &named].concat())
        .refused(&["a: no trial has that condition"]);

    let mut session = of_conditions(&arm);
    if let Some(file) = &mut session.file {
        file.trials[4].condition = Some("sandals".into());
    }
    let refused = Comparison::of_conditions(&session, None).unwrap_err().to_string();
    assert!(refused.contains("found barefoot, shoes, sandals"), "{refused}");
}

#[test]
fn sessions_of_which_one_has_a_standing_trial_are_not_compared() {
    let arm = Arm::new();
    let of = |name: &str, heading: f64| {
        let path = arm.out(name);
        fs::write(&path, Walker::new(heading).trc()).expect("a file");
        SessionStudy::open(&path, None, NormChoice::Shipped).expect("a walk")
    };
    let (plain, mut standing) = (of("plain.trc", 0.3), of("standing.trc", 0.4));
    for (_, study) in &mut standing.trials {
        let pose = NeutralPose { source: "still".into(), angles: BTreeMap::new() };
        study.analysis = study.analysis.clone().counted_from(&pose);
    }
    for [before, after] in [[&plain, &standing], [&standing, &plain]] {
        let refused = Comparison::new(before.clone(), after.clone()).unwrap_err().to_string();
        assert!(
            refused.contains("standing.trc has a standing trial, plain.trc has none"),
            "{refused}"
        );
    }
    assert!(Comparison::new(standing.clone(), standing).is_ok());
}

#[cfg(unix)]
#[test]
fn a_comparison_is_printed_beside_its_page_or_says_why_not() {
    let arm = Arm::new();
    let walk = arm.out("walk.trc").display().to_string();
    fs::write(&walk, Walker::new(0.3).trc()).expect("a file");
    let out = arm.out("compared").display().to_string();
    let browser = arm.out("browser");
    let compare = |script: &str| {
        fs::write(&browser, format!("#!/bin/sh\n{script}\n")).expect("a file");
        fs::set_permissions(&browser, fs::Permissions::from_mode(0o755)).expect("a program");
        let mut program = Command::new(program());
        let words = ["compare", &walk, &walk, "--out", &out, "--overwrite", "--pdf", "--json"];
        program.args(words).env("CHROME", &browser);
        ran(&program.output().expect("the program starts"))
    };
    let pdf = arm.out("compared/compare.pdf");

    let prints = "for word; do case $word in --print-to-pdf=*) echo %PDF > ${word#*=};; esac; done";
    let said = compare(prints).succeeded();
    assert_eq!(check("compare", &said.out)["pdf"], pdf.display().to_string());
    assert_eq!(fs::read(&pdf).expect("a PDF"), b"%PDF\n");

    let said = compare("exit 9");
    assert!(said.err.contains("compare.html: no PDF of it: "), "{}", said.err);
    assert!(arm.out("compared/compare.html").exists() && !pdf.exists());
}

#[test]
fn a_norm_of_three_people_is_read_by_gait_and_one_of_fewer_is_refused() {
    let arm = Arm::new();
    let people = [0.2, 0.3, 0.4].map(|heading| {
        let name = format!("{heading}.trc");
        fs::write(arm.out(&name), Walker::new(heading).trc()).expect("a file");
        arm.out(&name).display().to_string()
    });
    let [a, b, c] = people.each_ref().map(String::as_str);
    let norm = arm.out("norm.toml").display().to_string();
    let end = ["--out", &norm, "--footwear", "shoes", "--json"];

    run(&[&["norm", a, b][..], &end].concat()).refused(&["three people or more", "2 given"]);
    run(&[&["norm", a, b, a][..], &end].concat()).refused(&["of the same recording"]);
    let said = run(&[&["norm", a, b, c][..], &end].concat()).succeeded();
    assert_eq!(check("norm", &said.out)["people"], 3);
    run(&[&["norm", a, b, c][..], &end].concat()).refused(&["norm.toml"]);

    // the same person lies on their own norm
    let out = arm.out("compared").display().to_string();
    let said =
        run(&["gait", a, "--norm", &norm, "--footwear", "barefoot", "--out", &out]).succeeded();
    assert!(said.out.contains("walked in shoes, this person barefoot"), "{}", said.out);
    let score = said.out.lines().find(|line| line.contains("GVS knee_flexion")).expect("a score");
    let score: f64 =
        score.split_whitespace().nth(2).and_then(|v| v.parse().ok()).expect("a number");
    assert!(score < 0.5, "{score}");
}
