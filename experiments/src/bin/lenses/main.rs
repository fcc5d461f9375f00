//! Cameras of which the lenses alone are known, placed by the detections of a person who walks around in a room for 20 s, against the truth.
//!
//! Each recording: another person of `walker-metaballs`, another walk along a circle of 1.2 m, another ring of six cameras. Detectors err as `detector.rs` says. The
//! cameras are placed by the detections alone, and then refined by the default body, whose height is given. Rigs are compared after the similarity that
//! brings the cameras' centres nearest to each other; the scale that it needs is told apart.

mod compare;
mod detector;

use std::error::Error;
use std::path::Path;
use std::process::ExitCode;

use compare::Apart;
use detector::Recorded;
use experiments::metrics::rms;
use experiments::run::Run;
use experiments::table::Table;
use maquette::body::{BodyModel, Motion, Posed};
use maquette::inference::Sequence;
use maquette::inference::search::NoJournal;
use maquette::io::model;
use maquette::math::stats::mean;
use maquette::pipeline::{EstimateOptions, Walker, fit, placed_rig};
use maquette::silhouette::FrameObservations;
use maquette::workflow::DEFAULT_BODY;
use rayon::prelude::*;

const FPS: f64 = 25.0;
const SECONDS: f64 = 20.0;

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let mut run = Run::start("lenses");
    let recordings = if run.is_quick() { 2 } else { 10 };
    run.setting("recordings", recordings);
    let body = model::load(DEFAULT_BODY, Path::new(""))?;
    let walker = model::load("walker-metaballs", Path::new(""))?;
    let first = run.seed() * recordings;
    let tried: Vec<Option<Tried>> = (first..first + recordings)
        .into_par_iter()
        .map(|seed| Recorded::new(&walker, seed, (SECONDS * FPS) as usize, FPS)?.tried(&body))
        .collect();
    let lost = tried.iter().filter(|tried| tried.is_none()).count();
    let tried: Vec<Tried> = tried.into_iter().flatten().collect();

    let header = ["", "turn, °", "place, mm", "scale off, %", "RMS z of turns", "of places"];
    let mut table = Table::new("cameras", &header);
    for (name, of) in [
        ("detections", (|tried| &tried.placed) as fn(&Tried) -> &Apart),
        ("body", |tried| &tried.refined),
    ] {
        let each = || tried.iter().map(of);
        let turn = rms(each().flat_map(|apart| apart.turns_deg.clone()));
        let place = 1e3 * rms(each().flat_map(|apart| apart.places_m.clone()));
        let scale = 100.0 * mean(each().map(|apart| (apart.scale - 1.0).abs())).unwrap_or(0.0);
        // a length over three axes is √3 of each
        let z = [rms(each().flat_map(Apart::turns_z)), rms(each().flat_map(Apart::places_z))];
        let cells = [format!("{turn:.3}"), format!("{place:.1}"), format!("{scale:.2}")];
        let z = z.map(|z| format!("{z:.2}"));
        table.row([name.to_owned()].into_iter().chain(cells).chain(z));
        run.number(format!("{name}_turn_deg"), turn);
        run.number(format!("{name}_place_mm"), place);
        run.number(format!("{name}_scale_pct"), scale);
    }
    run.table("cameras of which the lenses alone were known, against the truth", &table)?;
    run.number("recordings_without_result", lost as f64);
    Ok(run.finish()?)
}

/// What became of a recording.
struct Tried {
    /// By the detections alone.
    placed: Apart,
    /// By the body.
    refined: Apart,
}

impl Recorded {
    fn tried(&self, body: &BodyModel) -> Option<Tried> {
        let height_m = Some(stature_m(&self.walk.model, &self.walk.shape));
        let walker = Walker { model: body, height_m, fps: FPS };
        let placed = placed_rig(&self.lenses(), &self.people, walker).ok()?;
        let options =
            EstimateOptions { calibration_errors: placed.errors(), ..EstimateOptions::default() };
        let frames: Vec<FrameObservations> = self.observed();
        let sequence = Sequence { frames: &frames, fps: FPS };
        let fitted = fit(body, &placed.rig, sequence, &options, &NoJournal).ok()?;
        let covariance = fitted.camera_covariances.poses.as_ref()?;
        let sds = maquette::pipeline::relative_sds(&fitted.rig, covariance)?;

        // as large as the person's height says
        let shape = fitted.shape.first(body.coefficients.len());
        let factor = height_m? / stature_m(body, &shape);
        let mut refined = Apart::new(&fitted.rig, &self.walk.rig, &sds)?;
        refined.scale *= factor;
        Some(Tried { placed: Apart::new(&placed.rig, &self.walk.rig, &placed.sds)?, refined })
    }
}

/// The height of a standing body, metres.
fn stature_m(model: &BodyModel, shape: &maquette::body::Shape) -> f64 {
    let posed = Posed::new(model, shape, &Motion::rest(model));
    posed.bounds().map_or(0.0, |(low, high)| (high - low).z)
}
