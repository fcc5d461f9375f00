//! The layer rule of ARCHITECTURE.md, kept by reading the imports in `src/`.
//!
//! A room is a folder or file directly under `src/`. It may use itself and rooms of strictly lower layers, and only
//! the rooms at the edge may touch the world. `lib.rs` is outside the rule; comments, texts and
//! `#[cfg(test)]` items are not looked at.

use std::fs;
use std::path::{Path, PathBuf};

/// Lowest first; a room may use rooms of earlier lines only.
const LAYERS: &[&[&str]] = &[
    &["math"],
    &["camera", "image", "solver"],
    &["body", "stereo"],
    &["silhouette", "render", "skin"],
    &["likelihood"],
    &["inference", "synth", "gait"],
    &["pipeline"],
    &["io"],
    &["report"],
    &["workflow"],
];

/// Lower, and still not allowed: these must stay independent of each other.
const FORBIDDEN: &[(&str, &str)] = &[("silhouette", "body"), ("synth", "likelihood")];

/// The only rooms that may use what [`WORLD`] names.
const EDGE: &[&str] = &["io", "workflow"];

/// Modules of `std` that read files, clock, environment or network.
const WORLD: &[&str] = &["env", "fs", "io", "net", "process", "time"];

/// What the program and the Python package may name of the library: the front door, what it takes and hands back, and formats.
const FRONT: &[&str] = &[
    "Error",
    "FitOptions",
    "FittedRecording",
    "GaitStudy",
    "Recording",
    "gait",
    "io",
    "pipeline",
    "report",
    "synth",
    "workflow",
];

/// Of the rooms that compute, the program names these options and figures, and nothing else.
const HANDED_OVER: &[&str] = &[
    "body::BodyModel",
    "inference::confidence::Confidence",
    "inference::search::Pruning",
    "likelihood::{EllipseOptions, Measure}",
    "math::stats::mean",
    "skin::SkinOptions",
];

#[test]
fn the_program_names_no_room_that_computes() {
    for folder in ["cli/src", "python/src"] {
        let sources = sources_in(folder);
        assert!(!sources.is_empty(), "{folder}: no sources found");
        let found: Vec<String> =
            sources.iter().flat_map(|(path, text)| computing(path, text)).collect();
        assert!(found.is_empty(), "{folder}:\n{}", found.join("\n"));
    }
}

#[test]
fn a_program_that_computes_is_blamed() {
    let text = "use maquette::Recording;\nuse maquette::math::stats::mean;\nuse maquette::inference::search::{Pruning, search};\n\
                fn f() { maquette::solver::levenberg_marquardt() }";
    let found = computing(Path::new("fit.rs"), text);
    assert_eq!(found.len(), 2, "{found:?}");
    assert!(
        found[0].contains("inference::search::{Pruning, search}") && found[1].contains("solver::")
    );
}

/// The paths of the library that the program must not name, one line for each.
fn computing(path: &Path, text: &str) -> Vec<String> {
    let code = without_tests(code_only(text));
    let named = code.match_indices("maquette::").map(|(at, start)| &code[at + start.len()..]);
    let is_allowed = |rest: &&str| {
        let first = leading_name(rest);
        let is_front = FRONT.contains(&first.as_str()) || first.is_empty();
        let end = |allowed: &str| rest[allowed.len()..].starts_with(|c| !is_name(c) && c != ':');
        is_front || HANDED_OVER.iter().any(|allowed| rest.starts_with(allowed) && end(allowed))
    };
    let line = |rest: &str| rest.split([';', '(', '\n']).next().unwrap_or_default().to_owned();
    named
        .filter(|rest| !is_allowed(rest))
        .map(|rest| format!("{}: {}", path.display(), line(rest)))
        .collect()
}

#[test]
fn every_room_uses_only_lower_layers() {
    assert!(!sources().is_empty(), "no sources found");
    let found: Vec<String> =
        sources().iter().flat_map(|(path, text)| violations(path, text)).collect();
    assert!(found.is_empty(), "{}", found.join("\n"));
}

#[test]
fn every_room_under_src_stands_in_the_list_of_layers() {
    let missing: Vec<String> = sources()
        .iter()
        .filter_map(|(path, _)| room(path))
        .filter(|room| layer(room).is_none())
        .collect();
    assert!(missing.is_empty(), "not in LAYERS: {missing:?}");
}

// --- the rule ----------------------------------------------------------------------------------

/// What is wrong with one file, one line for each breach. `path` is relative to `src/`.
fn violations(path: &Path, text: &str) -> Vec<String> {
    let Some(room) = room(path) else {
        return Vec::new();
    };
    let code = without_tests(code_only(text));
    let root = vec!["super"; module_depth(path)].join("::");
    let rooms = [first_names(&code, "crate"), first_names(&code, &root)].concat();
    let rooms = rooms.into_iter().filter(|used| !allowed(&room, used));
    let world = first_names(&code, "std")
        .into_iter()
        .filter(|used| WORLD.contains(&used.as_str()) && !EDGE.contains(&room.as_str()))
        .map(|used| format!("std::{used}"));
    rooms.chain(world).map(|used| format!("{room} uses {used} (src/{})", path.display())).collect()
}

/// Whether `room` may use `used`. A name that is no room (a re-export at the crate's root) hides
/// the layer it comes from, so it is refused.
fn allowed(room: &str, used: &str) -> bool {
    let lower = matches!((layer(used), layer(room)), (Some(low), Some(high)) if low < high);
    room == used || (lower && !FORBIDDEN.contains(&(room, used)))
}

fn layer(room: &str) -> Option<usize> {
    LAYERS.iter().position(|layer| layer.contains(&room))
}

/// `body` for `body/dh.rs`, `body/mod.rs` and `body.rs`; `None` for the two crate roots.
fn room(path: &Path) -> Option<String> {
    let first = path.iter().next()?.to_str()?;
    let name = first.strip_suffix(".rs").unwrap_or(first);
    (!["lib", "main"].contains(&name)).then(|| name.to_owned())
}

/// How many `super` lead from the module of this file to the crate's root.
fn module_depth(path: &Path) -> usize {
    path.iter().count() - usize::from(path.ends_with("mod.rs"))
}

/// The names that follow `root::` where it begins a path: `b` and `c` for `root::{b::d, c}`.
fn first_names(code: &str, root: &str) -> Vec<String> {
    let start = format!("{root}::");
    let begins_a_path =
        |at: usize| !code[..at].ends_with(is_name) && !code[..at].ends_with("super::");
    code.match_indices(&start)
        .filter(|(at, _)| begins_a_path(*at))
        .flat_map(|(at, _)| branches(&code[at + start.len()..]))
        .filter(|name| !["", "self", "super"].contains(&name.as_str()))
        .collect()
}

/// The first name of each branch of a `use` tree that begins here; one name if it does not fork.
fn branches(tree: &str) -> Vec<String> {
    let Some(group) = tree.strip_prefix('{') else {
        return vec![leading_name(tree)];
    };
    let mut names = vec![leading_name(group)];
    let mut depth = 0;
    for (at, c) in group.char_indices() {
        match c {
            '{' => depth += 1,
            '}' if depth == 0 => break,
            '}' => depth -= 1,
            ',' if depth == 0 => names.push(leading_name(&group[at + 1..])),
            _ => {}
        }
    }
    names
}

fn leading_name(text: &str) -> String {
    let name = text.trim_start().chars();
    name.take_while(|&c| is_name(c) || c == '*').collect()
}

fn is_name(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}

// --- reading Rust ------------------------------------------------------------------------------

/// The source with every comment, text and character replaced by one space.
fn code_only(source: &str) -> String {
    let mut code = String::with_capacity(source.len());
    let mut rest = source;
    while let Some(c) = rest.chars().next() {
        let skipped = comment_length(rest)
            .or_else(|| raw_text_length(rest, &code))
            .or_else(|| text_length(rest))
            .or_else(|| character_length(rest));
        code.push(if skipped.is_some() { ' ' } else { c });
        rest = &rest[skipped.unwrap_or(c.len_utf8())..];
    }
    code
}

fn comment_length(rest: &str) -> Option<usize> {
    if rest.starts_with("//") {
        return Some(rest.find('\n').unwrap_or(rest.len()));
    }
    if !rest.starts_with("/*") {
        return None;
    }
    // block comments nest
    let mut depth = 1;
    let mut at = 2;
    while depth > 0 && at < rest.len() {
        let (step, length) = match rest.get(at..at + 2) {
            Some("/*") => (1, 2),
            Some("*/") => (-1, 2),
            _ => (0, 1),
        };
        depth += step;
        at += length;
    }
    Some(at)
}

fn raw_text_length(rest: &str, before: &str) -> Option<usize> {
    let hashes = rest.strip_prefix('r')?.split('"').next()?;
    let inside_a_name = before.ends_with(|c| is_name(c) && c != 'b');
    if inside_a_name || !hashes.chars().all(|c| c == '#') {
        return None;
    }
    let opening = 2 + hashes.len();
    let closing = format!("\"{hashes}");
    let inside = rest.get(opening..)?.find(&closing);
    Some(inside.map_or(rest.len(), |at| opening + at + closing.len()))
}

fn text_length(rest: &str) -> Option<usize> {
    quoted_length(rest.strip_prefix('"')?, '"')
}

/// A character, as opposed to a lifetime: `'a'` and `'\n'`, but not `'a`.
fn character_length(rest: &str) -> Option<usize> {
    let inside = rest.strip_prefix('\'')?;
    let closes = inside.chars().nth(1) == Some('\'');
    (closes || inside.starts_with('\\')).then(|| quoted_length(inside, '\''))?
}

/// Length, with both quotes, of what begins just after an opening quote.
fn quoted_length(inside: &str, quote: char) -> Option<usize> {
    let mut escaped = false;
    for (at, c) in inside.char_indices() {
        if c == quote && !escaped {
            return Some(at + 2);
        }
        escaped = c == '\\' && !escaped;
    }
    Some(inside.len() + 1)
}

/// The code without the items marked `#[cfg(test)]`: tests may look at every room.
fn without_tests(mut code: String) -> String {
    while let Some(start) = code.find("#[cfg(test)]") {
        let after = start + "#[cfg(test)]".len();
        code.replace_range(start..after + item_length(&code[after..]), "");
    }
    code
}

/// Up to the `;` that ends an item, or the `}` that closes its body.
fn item_length(code: &str) -> usize {
    let mut depth = 0;
    for (at, c) in code.char_indices() {
        match c {
            '(' | '[' | '{' => depth += 1,
            ')' | ']' | '}' => depth -= 1,
            _ => {}
        }
        if depth <= 0 && [';', '}'].contains(&c) {
            return at + 1;
        }
    }
    code.len()
}

// --- reading the folder ------------------------------------------------------------------------

/// Every source file of the library, its path relative to `src/`.
fn sources() -> Vec<(PathBuf, String)> {
    sources_in("src")
}

/// Every source file in a folder of the repository, its path relative to that folder.
fn sources_in(folder: &str) -> Vec<(PathBuf, String)> {
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join(folder);
    files_below(&src)
        .into_iter()
        .filter(|path| path.extension().is_some_and(|extension| extension == "rs"))
        .filter_map(|path| {
            let text = fs::read_to_string(&path).ok()?;
            Some((path.strip_prefix(&src).ok()?.to_owned(), text))
        })
        .collect()
}

fn files_below(folder: &Path) -> Vec<PathBuf> {
    let Ok(entries) = fs::read_dir(folder) else {
        return Vec::new();
    };
    entries
        .filter_map(|entry| Some(entry.ok()?.path()))
        .flat_map(|path| if path.is_dir() { files_below(&path) } else { vec![path] })
        .collect()
}

// --- the rule seen to fail ---------------------------------------------------------------------

/// The rooms that the planted text is blamed for using.
fn blamed(path: &str, text: &str) -> Vec<String> {
    let blame = |line: String| line.split(' ').nth(2).map(str::to_owned);
    violations(Path::new(path), text).into_iter().filter_map(blame).collect()
}

#[test]
fn a_higher_layer_is_blamed_by_name() {
    let found = violations(Path::new("body/dh.rs"), "use crate::io::read;");
    assert_eq!(found, ["body uses io (src/body/dh.rs)"]);
}

#[test]
fn a_lower_layer_and_the_own_room_are_allowed() {
    let text = "use crate::math::Rigid3;\nuse crate::body::Shape;\nuse super::super::camera::Rig;";
    assert_eq!(blamed("body/dh.rs", text), [""; 0]);
}

#[test]
fn another_room_of_the_same_layer_is_blamed() {
    assert_eq!(blamed("camera/mod.rs", "use crate::solver::Problem;"), ["solver"]);
}

#[test]
fn a_forbidden_pair_is_blamed_although_the_layer_is_lower() {
    assert_eq!(blamed("silhouette/mod.rs", "use crate::body::Posed;"), ["body"]);
    assert_eq!(blamed("synth.rs", "use crate::likelihood::Term;"), ["likelihood"]);
}

#[test]
fn grouped_imports_are_read_branch_by_branch() {
    let text =
        "use crate::{\n    cli, io::{a, math::b},\n    math::{self, stats},\n    report,\n};";
    assert_eq!(blamed("likelihood/mod.rs", text), ["cli", "io", "report"]);
}

#[test]
fn paths_inside_code_count_as_imports() {
    let text = "fn f() -> crate::pipeline::Plan { let a = [crate::cli::run()]; }";
    assert_eq!(blamed("body/dh.rs", text), ["pipeline", "cli"]);
}

#[test]
fn a_path_by_super_that_leaves_the_room_is_blamed() {
    assert_eq!(blamed("body/dh.rs", "use super::{io, State};"), [""; 0]);
    assert_eq!(blamed("body/dh.rs", "use super::super::io::read;"), ["io"]);
    assert_eq!(blamed("body/mod.rs", "use super::{io, math};"), ["io"]);
}

#[test]
fn a_name_at_the_root_that_is_no_room_is_blamed() {
    assert_eq!(blamed("body/dh.rs", "use crate::Anything;"), ["Anything"]);
    assert_eq!(blamed("body/dh.rs", "use crate::*;"), ["*"]);
}

#[test]
fn the_world_is_for_the_edge_only() {
    let text =
        "use std::{collections::BTreeMap, fs, path::Path};\nlet t = std::time::Instant::now();";
    assert_eq!(blamed("inference/search.rs", text), ["std::fs", "std::time"]);
    assert_eq!(blamed("io/frames.rs", text), [""; 0]);
}

#[test]
fn comments_texts_and_characters_are_not_code() {
    let text = r##"//! See [`crate::io::read`].
        /* crate::cli /* crate::cli */ crate::cli */ const A: &str = "crate::cli \" crate::cli";
        const B: &str = r#"crate::cli " crate::cli"#; const C: [char; 3] = ['"', '\'', 'r'];
        fn f<'a>(x: &'a str, y: &'a str) -> &'a str { crate::io::pick(x, y) } // "#"##;
    assert_eq!(blamed("body/dh.rs", text), ["io"]);
}

#[test]
fn tests_in_a_file_may_use_every_room_and_the_code_after_them_may_not() {
    let text = "#[cfg(test)]\nuse crate::cli::{run, stop};\n\
        #[cfg(test)]\n#[allow(x)]\nmod tests {\n    fn f() { crate::io::read([0; 3]); }\n}\n\
        #[cfg(test)]\nfn g(a: [u8; 2]) { crate::pipeline::go(a) }\nuse crate::report::Page;";
    assert_eq!(blamed("body/dh.rs", text), ["report"]);
}

#[test]
fn the_crate_roots_are_exempt_and_a_new_room_has_no_layer() {
    assert_eq!(blamed("lib.rs", "pub use crate::cli::run;"), [""; 0]);
    assert_eq!(room(Path::new("gadgets/mod.rs")).and_then(|room| layer(&room)), None);
    assert_eq!(blamed("gadgets/mod.rs", "use crate::math::Rigid3;"), ["math"]);
}
