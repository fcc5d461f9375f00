//! Recordings that have masks, detections and the truth: errors by either and by both, and starts from single frames.

use std::error::Error;
use std::path::Path;

use experiments::metrics::{frame_error_mm, length_error_pct, mpjpe_mm, offset_mm, only};
use experiments::recorded::read_trajectories;
use experiments::run::Run;
use experiments::table::Table;
use maquette::FitOptions;
use maquette::io::points::trc::Trajectories;
use maquette::io::recording::Recording;
use maquette::io::result::trajectories;
use maquette::math::stats::mean;
use maquette::pipeline::{FitTo, FrameRange};

/// Recordings of one person.
pub(crate) const WITH_TRUTH: [&str; 3] = ["moved", "dressed", "clocks"];
/// Recordings of which single frames are fitted.
pub(crate) const STARTED: [&str; 4] = ["dressed", "moved", "clocks", "two"];
const FPS: f64 = 50.0;
/// A start is right if the limb joints are nearer to the truth on average.
const NEAR_MM: f64 = 50.0;

/// Joints off by masks, by masks and detections, and by detections; `--quick`: of the first recording.
pub(crate) fn gains(run: &mut Run, folder: &Path) -> Result<(), Box<dyn Error>> {
    let mut table = Table::new(
        "gains",
        &["recording", "fitted to", "joints, mm", "without offsets, mm", "lengths, %"],
    );
    let mut ratios = Vec::new();
    let recordings = if run.is_quick() { 1 } else { WITH_TRUTH.len() };
    for name in &WITH_TRUTH[..recordings] {
        let truth = read_trajectories(&folder.join(name).join("truth.trc"))?;
        let mut row = |words: &str, fit_to: FitTo| -> Result<f64, Box<dyn Error>> {
            let fit = fitted(&folder.join(name), fit_to, FrameRange::default())?;
            let number = |value: Option<f64>| value.unwrap_or(f64::INFINITY);
            let joints = number(mpjpe_mm(&truth, &fit));
            table.row([
                (*name).to_owned(),
                words.to_owned(),
                format!("{joints:.1}"),
                format!("{:.1}", number(offset_mm(&truth, &fit))),
                format!("{:.1}", number(length_error_pct(&truth, &fit))),
            ]);
            Ok(joints)
        };
        let masks = row("masks", FitTo::Silhouettes)?;
        let both = row("both", FitTo::All)?;
        let detections = row("detections", FitTo::Detections)?;
        ratios.push(both / masks);
        run.number(format!("{name}_by_detections_mm"), detections);
    }
    run.table("Joint centres by what is fitted to", &table)?;
    let worst = ratios.iter().copied().fold(0.0, f64::max);
    run.number("both_over_masks_worst", worst);
    run.number("both_over_masks_mean", mean(ratios).unwrap_or(f64::INFINITY));
    Ok(())
}

/// Ten single frames of each recording, by masks and detections and by detections; `--quick`: two.
pub(crate) fn starts(run: &mut Run, folder: &Path) -> Result<(), Box<dyn Error>> {
    let each = if run.is_quick() { 2 } else { 10 };
    for (number, fit_to) in [("starts", FitTo::All), ("starts_by_detections", FitTo::Detections)] {
        let mut near = 0;
        for name in STARTED {
            let truth = read_trajectories(&folder.join(name).join("truth.trc"))?;
            for i in 0..each {
                let frame = (2 * i + 1) * truth.frames.len() / (2 * each);
                let range = FrameRange { first: frame, last: frame };
                let fit = fitted(&folder.join(name), fit_to, range)?;
                let error = only(&truth, frame).and_then(|truth| frame_error_mm(&truth, &fit, 0));
                near += usize::from(error.is_some_and(|error| error < NEAR_MM));
            }
        }
        run.say(&format!("{number}: {near} of {}", STARTED.len() * each));
        run.number(number, near as f64);
    }
    Ok(())
}

/// The points of a fit.
fn fitted(
    folder: &Path,
    fit_to: FitTo,
    frames: FrameRange,
) -> Result<Trajectories, Box<dyn Error>> {
    let mut options = FitOptions { frames, ..FitOptions::default() };
    options.observations.fit_to = fit_to;
    let fit = Recording::open(folder)?.with_fps(FPS).fit(&options)?;
    Ok(trajectories(&fit.result))
}
