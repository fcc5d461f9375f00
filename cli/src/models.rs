//! `maquette models`.

use std::path::{Path, PathBuf};

use clap::{ArgGroup, Args};
use serde_json::json;

use super::error::CliError;
use super::switches::Output;
use super::table::Table;
use maquette::io::model::{self, SHIPPED, parse};
use maquette::workflow::RestingBody;

pub(super) const ABOUT: &str = "\
List the body models that come with the program.

With a NAME and --skin or --picture: the skin of that model's mean body at rest. It must have metaballs.";

/// Arguments of `maquette models`.
#[derive(Debug, Args)]
#[command(group = ArgGroup::new("shown").args(["skin", "picture"]).multiple(true))]
pub(super) struct ModelsArguments {
    /// A body model to draw with --skin or --picture: shipped, or a .toml file
    #[arg(value_name = "NAME|FILE", requires = "shown")]
    name: Option<String>,
    /// Write its skin: a .ply or .obj file; metres, Z up
    #[arg(long, value_name = "FILE", requires = "name")]
    skin: Option<PathBuf>,
    /// Write a shaded picture of it: a .png file
    #[arg(long, value_name = "FILE", requires = "name")]
    picture: Option<PathBuf>,
    #[command(flatten)]
    output: Output,
}

/// Lists the shipped models, or shows one.
pub(super) fn run(arguments: &ModelsArguments) -> Result<(), CliError> {
    match &arguments.name {
        None => list(arguments.output),
        Some(name) => show(name, arguments),
    }
}

/// Writes the skin of a model's mean body at rest, and a picture of it.
fn show(name: &str, arguments: &ModelsArguments) -> Result<(), CliError> {
    let body = RestingBody::new(&model::load(name, Path::new(""))?)?;
    let mut text = String::new();
    if let Some(path) = &arguments.skin {
        body.write_mesh(path)?;
        let (vertices, triangles) = (body.skin.vertices.len(), body.skin.triangles.len());
        text += &format!("{}: {vertices} vertices, {triangles} triangles\n", path.display());
    }
    if let Some(path) = &arguments.picture {
        body.write_picture(path)?;
        text += &format!("{}\n", path.display());
    }
    let files = arguments.skin.iter().chain(&arguments.picture);
    let files: Vec<String> = files.map(|path| path.display().to_string()).collect();
    arguments.output.summarise(|| text, || json!({ "files": files }));
    Ok(())
}

/// Lists the shipped models with what each is made of.
fn list(output: Output) -> Result<(), CliError> {
    let mut table =
        Table::new(&["model", "parts", "angles", "shape coefficients", "ellipsoids", "metaballs"]);

    let (mut remarks, mut models) = (String::new(), Vec::new());
    for (name, text) in SHIPPED {
        let model = parse(text, Path::new(name))?;
        let counts = [
            model.parts.len(),
            model.joints.len(),
            model.coefficients.len(),
            model.ellipsoids.len(),
            model.metaballs.len(),
        ];
        let [parts, angles, coefficients, ellipsoids, metaballs] = counts;
        models.push(json!({
            "name": name, "parts": parts, "angles": angles, "coefficients": coefficients,
            "ellipsoids": ellipsoids, "metaballs": metaballs,
        }));
        let counts = counts.map(|count| count.to_string());
        table.row(std::iter::once(name.to_owned()).chain(counts).collect());
        let first = text.lines().next().unwrap_or_default();
        remarks += &format!("  {name}: {}\n", first.trim_start_matches(['#', ' ']));
    }

    let text = format!(
        "{}\n{remarks}\nUse one with --body NAME, or your own with --body FILE.toml; docs/formats.md says how to write one.\n",
        table.text()
    );
    output.summarise(|| text, || json!({ "models": models }));
    Ok(())
}
