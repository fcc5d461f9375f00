//! Reads a finished fit and draws the flexion of both knees, with a band of two standard deviations, as SVG.
//!
//! `cargo run --release --example plot_result -- out/walker knee.svg`

#![allow(clippy::print_stdout, clippy::print_stderr, reason = "an example prints what it found")]

use std::error::Error;
use std::process::ExitCode;

use maquette::workflow::AngleTrack;
use maquette::{FittedRecording, Side};

/// Width and height of the picture, and degrees from top to bottom.
const SIZE: [f64; 2] = [640.0, 320.0];
const DEGREES: [f64; 2] = [90.0, -10.0];

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
    let mut arguments = std::env::args().skip(1);
    let folder = arguments.next().unwrap_or("out/walker".into());
    let picture = arguments.next().unwrap_or("knee.svg".into());
    let fit = FittedRecording::read(folder, None)?;

    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {} {}\">\n",
        SIZE[0], SIZE[1]
    );
    for (side, colour) in [(Side::Left, "#c0392b"), (Side::Right, "#2067b0")] {
        svg += &curve(&fit.angle("knee_flexion", side)?, colour);
    }
    svg.push_str("</svg>\n");
    std::fs::write(&picture, svg)?;
    println!("{picture}");
    Ok(())
}

/// The line of an angle and its band.
fn curve(angle: &AngleTrack, colour: &str) -> String {
    let frames = angle.radians.len();
    let place = |i: usize, radians: f64| {
        let [top, bottom] = DEGREES;
        let x = SIZE[0] * i as f64 / (frames - 1).max(1) as f64;
        let y = SIZE[1] * (top - radians.to_degrees()) / (top - bottom);
        format!("{x:.1},{y:.1}")
    };

    // the band: up along its upper edge, back along the lower one
    let sd = angle.sd.clone().unwrap_or(vec![0.0; frames]);
    let upper = (0..frames).map(|i| place(i, angle.radians[i] + 2.0 * sd[i]));
    let lower = (0..frames).rev().map(|i| place(i, angle.radians[i] - 2.0 * sd[i]));
    let band: Vec<String> = upper.chain(lower).filter(|p| !p.contains("NaN")).collect();

    let line = (0..frames).map(|i| place(i, angle.radians[i]));
    let line: Vec<String> = line.filter(|p| !p.contains("NaN")).collect();
    format!(
        "<polygon points=\"{}\" fill=\"{colour}\" opacity=\"0.2\"/>\n\
         <polyline points=\"{}\" fill=\"none\" stroke=\"{colour}\"/>\n",
        band.join(" "),
        line.join(" ")
    )
}
