//! What the repository promises about its own texts.

use std::fs;
use std::path::{Path, PathBuf};

/// Folders with texts that people read; nothing that a run leaves behind.
const FOLDERS: &[&str] = &[
    ".ci",
    "benches",
    "cli/src",
    "cli/tests",
    "data/models",
    "docs",
    "examples",
    "experiments/expected",
    "experiments/src",
    "python/clusters",
    "python/experiments",
    "python/maquette",
    "python/notebooks",
    "python/src",
    "python/tests",
    "src",
    "tests",
];

/// The same for single files.
const FILES: &[&str] = &[
    ".gitignore",
    "ARCHITECTURE.md",
    "CHANGELOG.md",
    "CITATION.cff",
    "CONTRIBUTING.md",
    "Cargo.toml",
    "README.md",
    "cli/Cargo.toml",
    "clippy.toml",
    "data/README.md",
    "deny.toml",
    "experiments/Cargo.toml",
    "experiments/README.md",
    "justfile",
    "python/Cargo.toml",
    "python/README.md",
    "python/pyproject.toml",
    "rustfmt.toml",
];

#[test]
fn no_text_names_a_folder_of_one_machine() {
    let found: Vec<String> =
        texts().iter().flat_map(|(path, text)| machine_paths(path, text)).collect();
    assert!(found.is_empty(), "{}", found.join("\n"));
}

#[test]
fn every_dependency_has_its_line_of_reason() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let read = |file: &str| fs::read_to_string(root.join(file)).expect("part of the repository");
    let missing = without_reason(&read("Cargo.toml"), &read("docs/decisions/0004-dependencies.md"));
    assert_eq!(missing, [""; 0], "add them to docs/decisions/0004-dependencies.md");
}

/// The workspace's dependencies that begin no row of the table in `decisions`.
fn without_reason(manifest: &str, decisions: &str) -> Vec<String> {
    let manifest: toml::Table = manifest.parse().expect("Cargo.toml is TOML");
    let dependencies = manifest["workspace"]["dependencies"].as_table();
    dependencies
        .expect("a table")
        .keys()
        .filter(|name| !["maquette", "maquette-cli"].contains(&name.as_str()))
        .filter(|name| !decisions.contains(&format!("| {name} |")))
        .cloned()
        .collect()
}

/// The lines with an absolute path that only one person's machine has.
fn machine_paths(path: &Path, text: &str) -> Vec<String> {
    let folders = ["work", "tmp", "root", "home"].map(|name| format!("/{name}/"));
    let begins_a_path = |line: &str, at: usize| {
        !line[..at].ends_with(|c: char| c.is_alphanumeric() || "._/-*}>~".contains(c))
    };
    text.lines()
        .enumerate()
        .filter(|(_, line)| {
            let mut found = folders.iter().flat_map(|folder| line.match_indices(folder));
            found.any(|(at, _)| begins_a_path(line, at))
        })
        .map(|(n, line)| format!("{}:{}: {}", path.display(), n + 1, line.trim()))
        .collect()
}

fn texts() -> Vec<(PathBuf, String)> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    FOLDERS
        .iter()
        .flat_map(|folder| files_below(&root.join(folder)))
        .chain(FILES.iter().map(|file| root.join(file)))
        .filter_map(|path| Some((path.clone(), fs::read_to_string(&path).ok()?)))
        .collect()
}

fn files_below(folder: &Path) -> Vec<PathBuf> {
    let Ok(entries) = fs::read_dir(folder) else {
        return Vec::new();
    };
    entries
        .filter_map(|entry| Some(entry.ok()?.path()))
        .flat_map(|path| match path.is_dir() {
            true => files_below(&path),
            false => vec![path],
        })
        .collect()
}

#[test]
fn an_absolute_path_is_found_and_an_address_or_a_relative_path_is_not() {
    let find = |text: &str| machine_paths(Path::new("a.md"), text).len();
    assert_eq!(find(&format!("see `/{}/x`", "tmp")), 1);
    assert_eq!(find(&format!("a\nfrom /{}/me/data", "home")), 1);
    assert_eq!(find("target/tmp/x ../work/x https://example.org/home/x"), 0);
}

#[test]
fn a_dependency_without_a_row_is_found() {
    let manifest = "[workspace.dependencies]\nrand = \"1\"\nrand_distr = \"1\"";
    let decisions = "| crate | reason |\n| rand_distr | normal numbers |";
    assert_eq!(without_reason(manifest, decisions), ["rand"]);
}
