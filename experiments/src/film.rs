//! Films of a person before clutter, as recordings on disk.

use std::error::Error;
use std::fs;
use std::path::Path;

use maquette::io::model;
use maquette::io::recording::filmed;
use maquette::synth::{Film, FilmRecipe};

/// Photographs the walker of a recipe and writes the recording into a folder, over what was there.
///
/// # Errors
/// If the film cannot be made or written.
pub fn photographed(recipe: &FilmRecipe, recording: &Path) -> Result<Film, Box<dyn Error>> {
    let film = recipe.film(&model::load("walker-metaballs", Path::new(""))?)?;
    if recording.is_dir() {
        fs::remove_dir_all(recording)?;
    }
    filmed::write(&film, recording)?;
    Ok(film)
}
