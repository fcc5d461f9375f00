//! Disparity of the Middlebury cones pair, beside OpenCV in the same run.
//!
//! `cargo bench --bench disparity` (`PYTHON` names a Python with opencv-python-headless; without one ours is measured
//! alone). Rows: milliseconds, fastest and median of 100; of the visible pixels the share matched, and of these the
//! share off by more than 2 px, per cent.

#![allow(clippy::print_stdout, reason = "a benchmark reports to the terminal")]

use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

use maquette::image::Plane;
use maquette::stereo::correlation::{CorrelationOptions, correlate};

const RUNS: usize = 100;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let shared = std::env::var_os("MAQUETTE_SHARED")
        .map_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared"), PathBuf::from);
    let folder = shared.join("data/stereo/cones");
    if !folder.exists() {
        println!("skipped: {} is not here", folder.display());
        return Ok(());
    }
    let (left, right) = (grey(&folder, "Cones_LEFT.tif")?, grey(&folder, "Cones_RIGHT.tif")?);
    let threads = rayon::ThreadPoolBuilder::new().num_threads(2).build()?;
    let options = CorrelationOptions::default();
    let mut times = Vec::new();
    let mut found = Plane::filled(0, 0, 0.0);
    for _ in 0..RUNS {
        let start = Instant::now();
        found = threads.install(|| correlate(&left, &right, &options))?;
        times.push(1e3 * start.elapsed().as_secs_f64());
    }
    times.sort_by(f64::total_cmp);
    let (off, density) = against_truth(&folder, &found)?;
    println!("name fastest_ms median_ms off_percent density");
    println!("maquette {:.2} {:.2} {off:.2} {density:.3}", times[0], times[RUNS / 2]);
    let python = std::env::var("PYTHON").unwrap_or_else(|_| "python3".into());
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("benches/disparity.py");
    let opencv = Command::new(python).arg(script).arg(&folder).output()?;
    print!("{}", String::from_utf8_lossy(&opencv.stdout));
    Ok(())
}

fn grey(folder: &Path, name: &str) -> Result<Plane<u8>, Box<dyn std::error::Error>> {
    let image = image::open(folder.join(name))?.to_luma8();
    let (width, height) = (image.width() as usize, image.height() as usize);
    Ok(Plane::from_values(width, height, image.into_raw()).ok_or("an image of no size")?)
}

/// Per cent off by more than 2 px, and the share of visible pixels that is matched.
fn against_truth(
    folder: &Path,
    found: &Plane<f32>,
) -> Result<(f64, f64), Box<dyn std::error::Error>> {
    let file = std::fs::File::open(folder.join("Cones_LEFT_GT.tif"))?;
    let truth = tiff::decoder::Decoder::new(std::io::BufReader::new(file))?.read_image()?;
    let tiff::decoder::DecodingResult::F32(truth) = truth else {
        return Err("the truth is not of floats".into());
    };
    let visible = image::open(folder.join("Occlusion_LEFT.png"))?.to_luma8();
    let (mut seen, mut matched, mut off) = (0.0, 0.0, 0.0);
    for ((truth, visible), found) in truth.iter().zip(visible.iter()).zip(found.values()) {
        if *truth <= 0.0 || *visible == 0 {
            continue;
        }
        seen += 1.0;
        matched += f64::from(u8::from(found.is_finite()));
        off += f64::from(u8::from((found - truth).abs() > 2.0));
    }
    Ok((100.0 * off / matched, matched / seen))
}
