//! Fits the sample recording and goes on to angles, a gait analysis and files for other programs.
//!
//! `cargo run --release --example fit_folder -- data/sequences/walker out/example`

#![allow(clippy::print_stdout, clippy::print_stderr, reason = "an example prints what it found")]

use std::error::Error;
use std::path::PathBuf;
use std::process::ExitCode;

use maquette::workflow::ExportFormat;
use maquette::{FitOptions, Recording, Side};

fn main() -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args_os().skip(1).map(PathBuf::from);
    let folder = arguments.next().unwrap_or("data/sequences/walker".into());
    let out = arguments.next().unwrap_or("out/example".into());

    // fit: nothing is written
    let recording = Recording::open(&folder)?;
    let fit = recording.fit(&FitOptions::default())?;

    // a length and an angle, each with its standard deviation
    let thigh = fit.length("thigh")?;
    let sd_mm = 1e3 * thigh.sd.unwrap_or(f64::NAN);
    println!("thigh {:.1} ± {sd_mm:.1} mm", 1e3 * thigh.metres);
    let knee = fit.angle("knee_flexion", Side::Left)?;
    for (i, angle) in knee.radians.iter().enumerate().step_by(10) {
        let sd = knee.sd.as_ref().map_or(f64::NAN, |sd| sd[i]);
        let (degrees, sd) = (angle.to_degrees(), sd.to_degrees());
        println!("frame {}: {degrees:.1} ± {sd:.1}°", knee.first_frame + i);
    }

    // gait analysis, and files
    let gait = fit.gait()?;
    println!("{} strides", gait.analysis.cycles.len());
    fit.save(&out)?;
    gait.export(ExportFormat::C3d, &out)?;
    Ok(())
}
