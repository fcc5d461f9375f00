//! The parts of a model file, parents first.

use std::path::Path;

use super::ModelFileError;
use super::side::Side;
use super::spec::{ModelSpec, PartSpec};

/// Every part on each of its sides, after its parent; the file's order where that leaves a choice.
pub(super) fn parents_first<'s>(
    spec: &'s ModelSpec,
    path: &Path,
) -> Result<Vec<(&'s PartSpec, Side)>, ModelFileError> {
    let roots = spec.parts.iter().filter(|p| p.parent.is_none()).count();
    if roots != 1 {
        return Err(ModelFileError::Roots { path: path.to_owned(), found: roots });
    }

    let mut placed: Vec<&str> = Vec::new();
    let mut waiting: Vec<&PartSpec> = spec.parts.iter().collect();
    let mut order = Vec::new();

    while !waiting.is_empty() {
        let is_ready =
            |p: &&PartSpec| p.parent.as_deref().is_none_or(|name| placed.contains(&name));
        let (ready, rest): (Vec<&PartSpec>, Vec<&PartSpec>) =
            waiting.into_iter().partition(is_ready);

        if ready.is_empty() {
            return Err(never_placed(&rest, spec, path));
        }

        for part in ready {
            placed.push(&part.name);
            order.extend(part.sides.each().iter().map(|side| (part, *side)));
        }
        waiting = rest;
    }

    Ok(order)
}

/// Why these parts cannot be placed: a parent is missing, or they carry each other.
fn never_placed(parts: &[&PartSpec], spec: &ModelSpec, path: &Path) -> ModelFileError {
    let is_there = |name: &str| spec.parts.iter().any(|part| part.name == name);
    let lost = parts.iter().find_map(|part| {
        let parent = part.parent.as_deref().filter(|name| !is_there(name))?;
        Some((&part.name, parent))
    });
    match lost {
        Some((part, parent)) => ModelFileError::Missing {
            path: path.to_owned(),
            place: format!("part {part}"),
            kind: "part",
            name: parent.to_owned(),
        },
        None => ModelFileError::Cycle { path: path.to_owned(), part: parts[0].name.clone() },
    }
}
