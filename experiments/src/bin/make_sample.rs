//! Makes the sample recording: `make_sample OUT [SEED]`, OUT a folder that is empty or does not exist.
//!
//! What lies in `data/sequences/walker` is `make_sample data/sequences/walker 1`.

use std::error::Error;
use std::path::Path;

use maquette::io::model;
use maquette::io::recording::synthetic;
use maquette::synth::sample_walker;

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let out = arguments.next().ok_or("usage: make_sample OUT [SEED]")?;
    let seed = arguments.next().map_or(Ok(1), |seed| seed.parse())?;
    let walker = model::load("walker-metaballs", Path::new(""))?;
    synthetic::write(&sample_walker(&walker, seed)?, Path::new(&out))?;
    Ok(())
}
