//! Every language says all that the pages say: the files of `src/report/language` against the code that says it.
//!
//! A text stands in English in the code, as `words.of("…")` and `words.fill("…", …)` in `src/report` and as `say('…')` in `web/src`.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use serde::Deserialize;

/// A file of a language: the English text, and what is said in its place.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
struct Translation {
    page: BTreeMap<String, String>,
    program: BTreeMap<String, String>,
    elsewhere: BTreeMap<String, String>,
}

fn folder(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(name)
}

/// The files below a folder that end like this, without their tests.
fn sources(name: &str, end: &str) -> Vec<(PathBuf, String)> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder(name)).expect("a folder of the repository").flatten() {
        let path = entry.path();
        if path.is_dir() {
            found.extend(sources(&path.display().to_string(), end));
        } else if path.extension().is_some_and(|extension| extension == end) {
            let text = fs::read_to_string(&path).expect("UTF-8");
            found.push((path, code(&text)));
        }
    }
    found
}

/// A file's lines without indentation, comments and tests; a call that goes on in another line is one line.
fn code(text: &str) -> String {
    let own = text.split("#[cfg(test)]").next().unwrap_or_default();
    let lines = own.lines().map(str::trim_start).filter(|line| !line.starts_with("//"));
    let joined =
        lines.map(|line| if line.starts_with('.') { line.into() } else { format!("\n{line}") });
    joined.collect()
}

fn german() -> Translation {
    let text = fs::read_to_string(folder("src/report/language/de.toml")).expect("a file");
    toml::from_str(&text).expect("TOML")
}

/// The text of a literal that begins after its quote; a backslash at the end of a line joins it with the next one.
fn literal(after: &str, quote: char) -> Option<String> {
    let mut text = String::new();
    let mut characters = after.chars().peekable();
    loop {
        match characters.next()? {
            c if c == quote => return Some(text),
            '\\' => match characters.next()? {
                '\n' => while characters.next_if(|c| c.is_whitespace()).is_some() {},
                escaped => text.push(escaped),
            },
            c => text.push(c),
        }
    }
}

/// What is said by these calls, and calls that do not say it where they stand.
fn said(text: &str, calls: &[&str], quote: char) -> (BTreeSet<String>, Vec<String>) {
    let (mut all, mut faults) = (BTreeSet::new(), Vec::new());
    for call in calls {
        for (at, _) in text.match_indices(call) {
            let after = text[at + call.len()..].trim_start();
            match after.strip_prefix(quote).and_then(|after| literal(after, quote)) {
                Some(english) => drop(all.insert(english)),
                None => faults.push(after.chars().take(40).collect()),
            }
        }
    }
    (all, faults)
}

fn placeholders(text: &str) -> BTreeSet<&str> {
    text.split('{').skip(1).filter_map(|part| part.split_once('}')).map(|(name, _)| name).collect()
}

/// What is wrong with a part of a language's file.
fn faults(said: &BTreeSet<String>, part: &BTreeMap<String, String>) -> Vec<String> {
    let missing = said.iter().filter(|english| !part.contains_key(*english));
    let unsaid = part.keys().filter(|english| !said.contains(*english));
    let other = part.iter().filter(|(english, own)| placeholders(english) != placeholders(own));
    let empty = part.iter().filter(|(_, own)| own.trim().is_empty());
    missing
        .map(|english| format!("missing: {english}"))
        .chain(unsaid.map(|english| format!("said nowhere: {english}")))
        .chain(other.map(|(english, own)| format!("other placeholders: {english}: {own}")))
        .chain(empty.map(|(english, _)| format!("empty: {english}")))
        .collect()
}

fn said_by_pages() -> BTreeSet<String> {
    let mut all = BTreeSet::new();
    for (path, text) in sources("src/report", "rs") {
        let (own, faults) = said(&text, &["words.of(", "words.fill("], '"');
        assert!(faults.is_empty(), "{}: no text stands at {faults:?}", path.display());
        all.extend(own);
    }
    all
}

fn said_by_the_program() -> BTreeSet<String> {
    let files = sources("web/src", "ts");
    let own = files.iter().filter(|(path, _)| !path.ends_with("words.ts"));
    own.flat_map(|(path, text)| {
        let (own, faults) = said(text, &["say("], '\'');
        assert!(faults.is_empty(), "{}: no text stands at {faults:?}", path.display());
        own
    })
    .collect()
}

#[test]
fn german_says_all_that_the_pages_and_their_program_say_and_nothing_else() {
    let file = german();
    assert_eq!(faults(&said_by_pages(), &file.page), [""; 0]);
    assert_eq!(faults(&said_by_the_program(), &file.program), [""; 0]);
}

#[test]
fn a_missing_text_another_placeholder_and_a_text_that_nobody_says_are_found() {
    let (said, whole) = (said_by_pages(), german().page);
    let spoilt = |spoil: &dyn Fn(&mut BTreeMap<String, String>)| {
        let mut part = whole.clone();
        spoil(&mut part);
        faults(&said, &part)
    };
    let missing = spoilt(&|part| drop(part.remove("Steps and strides")));
    assert_eq!(missing, ["missing: Steps and strides"]);
    let other = spoilt(&|part| drop(part.insert("{years} years".into(), "{jahre} Jahre".into())));
    assert_eq!(other, ["other placeholders: {years} years: {jahre} Jahre"]);
    let unsaid = spoilt(&|part| drop(part.insert("Nobody says it".into(), "Niemand".into())));
    assert_eq!(unsaid, ["said nowhere: Nobody says it"]);
}

#[test]
fn a_text_is_read_across_lines_and_a_call_without_one_is_found() {
    let text = code(
        "// words.of(\"no\")\nwords.of(\"one \\\n    two \\\"three\\\"\") words\n    .fill(\n  \"{n} of it\", &[]) words.of(name)",
    );
    let (all, faults) = said(&text, &["words.of(", "words.fill("], '"');
    let expected = ["one two \"three\"", "{n} of it"].map(str::to_owned);
    assert_eq!((all, faults), (expected.into(), vec!["name)".to_owned()]));
}

#[test]
fn what_german_knows_from_elsewhere_is_said_there() {
    let said: String = ["src/gait", "src/io", "src/workflow"]
        .into_iter()
        .flat_map(|room| sources(room, "rs"))
        .map(|(_, text)| text.replace("\\\n", ""))
        .collect();
    let models: String = sources("data/models", "toml").into_iter().map(|(_, text)| text).collect();
    for english in german().elsewhere.keys() {
        let as_name = format!("\"{}\"", english.replace(' ', "_"));
        assert!(
            said.contains(&format!("\"{english}\"")) || models.contains(&as_name),
            "said nowhere: {english}"
        );
    }
}
