//! PFD99 § 2: least-squares matching and surface tracking against the truth.
//!
//! Middlebury's cloth (views 1, 3, 5 of `cloth3_7view`) for the matches, and a rendered man before three cameras
//! (`trinocular`) for the points and the tracks. Both lie in `../shared/data`; skipped where they are absent.
//!
//! Starts: seeds are found by the program; the paper's user picks about ten. Tracks begin at matched points. No body has a part in it.

mod cloth;
mod mesh;
mod person;

use std::error::Error;
use std::path::Path;
use std::process::ExitCode;
use std::time::Instant;

use experiments::run::{Run, shared_data};
use maquette::math::stats::median;
use maquette::stereo::matching::{MatchOptions, match_surface};

/// Anything that ends the experiment.
type Fault = Box<dyn Error>;

fn main() -> Result<ExitCode, Fault> {
    let mut run = Run::start("pfd99_matching");
    let data = shared_data();
    if !data.is_dir() {
        run.say(&format!("skipped: {} is not here", data.display()));
        return Ok(ExitCode::SUCCESS);
    }
    cloth(&mut run, &data.join("stereo/cloth3_7view"))?;
    person::measure(&mut run, &data.join("trinocular"))?;
    Ok(run.finish()?)
}

/// Views 1, 3 and 5, every pixel of view 3.
fn cloth(run: &mut Run, folder: &Path) -> Result<(), Fault> {
    let [left, template, right] =
        [cloth::view(folder, 1)?, cloth::view(folder, 3)?, cloth::view(folder, 5)?];
    let truth = cloth::truth(folder)?;
    let known = truth.values().iter().filter(|shift| shift.is_finite()).count();
    for (name, least_images) in [("triplets", 2), ("pairs_too", 1)] {
        let options = MatchOptions { spacing_px: 1, least_images, ..MatchOptions::default() };
        let start = Instant::now();
        let found = match_surface(&template, &[&left, &right], None, &[], &options)?;
        let seconds = start.elapsed().as_secs_f64();
        let off = found.points.iter().filter_map(|point| {
            let shift = cloth::shift_px(point.point.position_world.z);
            let truth = truth.get(point.pixel.0, point.pixel.1)?;
            Some((shift - truth).abs()).filter(|off| off.is_finite())
        });
        let mut off: Vec<f64> = off.collect();
        let share = off.len() as f64 / known as f64;
        let wrong = off.iter().filter(|off| **off > 1.0).count() as f64 / off.len() as f64;
        let middle = median(&mut off).unwrap_or(f64::NAN);
        run.number(format!("cloth_{name}_median_px"), middle);
        run.number(format!("cloth_{name}_share"), share);
        run.number(format!("cloth_{name}_off_by_1_px"), wrong);
        run.say(&format!(
            "cloth, {name}: median {middle:.3} px, {:.1} % of the pixels with truth, {:.2} % off by more than 1 px, {} seeds, {seconds:.1} s",
            100.0 * share, 100.0 * wrong, found.seeds
        ));
    }
    Ok(())
}
