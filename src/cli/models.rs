//! `maquette models`.

use std::path::Path;

use super::error::CliError;
use super::print;
use super::table::Table;
use crate::io::model::{SHIPPED, parse};

/// Lists the shipped models with what each is made of.
pub(super) fn run() -> Result<(), CliError> {
    let mut table = Table::new(&[
        "model",
        "parts",
        "angles",
        "shape coefficients",
        "ellipsoids",
        "metaballs",
    ]);
    let mut remarks = String::new();
    for (name, text) in SHIPPED {
        let model = parse(text, Path::new(name))?;
        let counts = [
            model.parts.len(),
            model.joints.len(),
            model.coefficients.len(),
            model.ellipsoids.len(),
            model.metaballs.len(),
        ];
        let counts = counts.map(|count| count.to_string());
        table.row(std::iter::once(name.to_owned()).chain(counts).collect());
        let first = text.lines().next().unwrap_or_default();
        remarks += &format!("  {name}: {}\n", first.trim_start_matches(['#', ' ']));
    }
    print(&format!(
        "{}\n{remarks}\nUse one with --body NAME, or your own with --body FILE.toml; docs/formats.md says how to write one.\n",
        table.text()
    ));
    Ok(())
}
