//! Cameras that were touched and clocks that disagree: what the joint optimum finds of them, against the truth.
//!
//! Each recording: another person of `walker-metaballs`, another walk, another ring of six cameras, ragged masks. Every calibration is
//! off by what a good one is, 0.03° and 1 mm about each axis and .1 % of the focal length; three cameras were touched after it, by 0.7° and
//! 15 mm about each axis; the focal length of one, drawn anew, is 3 % longer or shorter; the clocks of three, drawn anew, are off by up to three frames, in
//! eighths of a frame. The default body is fitted with cameras and clocks as unknowns, with both trusted, and with the true ones.
//!
//! Starts: the body is found from nothing, as `maquette fit` does it.

use std::error::Error;
use std::path::Path;
use std::process::ExitCode;

use experiments::metrics::{INTERVALS, rms, within_pct};
use experiments::run::Run;
use experiments::table::Table;
use maquette::body::BodyModel;
use maquette::camera::Rig;
use maquette::inference::Sequence;
use maquette::inference::camera_offset::CameraOffset;
use maquette::inference::search::NoJournal;
use maquette::io::model;
use maquette::math::stats::mean;
use maquette::pipeline::{Cameras, Clocks, EstimateOptions, Fit, fit};
use maquette::silhouette::{FrameIndex, FrameObservations, SilhouetteOptions, extract};
use maquette::synth::{Make, Recipe, Ring, SegmentationErrors, Synthetic};
use maquette::workflow::DEFAULT_BODY;
use nalgebra::{UnitQuaternion, Vector3};
use rand::seq::SliceRandom;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use rayon::prelude::*;

const CAMERAS: usize = 6;
const FRAMES: usize = 40;
const FPS: f64 = 30.0;
/// Moments in a frame.
const MOMENTS: usize = 8;
/// How far a clock may be off, frames.
const MOST_LATE: usize = 3;
/// Cameras that were touched, and clocks that are off.
const OFF: usize = 3;
/// About each axis: degrees, metres.
const GOOD: (f64, f64) = (0.03, 0.001);
const TOUCHED: (f64, f64) = (0.7, 0.015);
/// Of the logarithm of a focal length.
const GOOD_LENS: f64 = 0.001;
const ZOOMED: f64 = 0.03;
/// Random stream of the rig's faults; the recipe's own are others.
const OWN: u64 = 5;
/// The limbs' joints, by which a body is measured.
const JOINTS: [&str; 6] = ["RHip", "LKnee", "RAnkle", "LShoulder", "RElbow", "LWrist"];

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let mut run = Run::start("rigs");
    let recordings = if run.is_quick() { 4 } else { 30 };
    run.setting("recordings", recordings);
    let body = model::load(DEFAULT_BODY, Path::new(""))?;
    let walker = model::load("walker-metaballs", Path::new(""))?;
    let first = run.seed() * recordings;
    let tried: Vec<Option<Tried>> = (first..first + recordings)
        .into_par_iter()
        .map(|seed| Recorded::new(&walker, seed)?.tried(&body))
        .collect();
    let lost = tried.iter().filter(|tried| tried.is_none()).count();
    let tried: Vec<Tried> = tried.into_iter().flatten().collect();

    let header = ["", "numbers", "RMS error", "RMS SD", "RMS z", "50 %", "80 %", "95 %"];
    let mut table = Table::new("cameras", &header);
    for (kind, unit) in
        [(Kind::Turn, "°"), (Kind::Place, "mm"), (Kind::Lens, "%"), (Kind::Clock, "frames")]
    {
        let all = tried.iter().flat_map(|tried| &tried.deviations);
        let all: Vec<&Deviation> = all.filter(|d| d.kind == kind).collect();
        let z = || all.iter().map(|d| d.error / d.sd);
        let shares = INTERVALS.map(|(_, limit)| format!("{:.1}", within_pct(z(), limit)));
        let error = rms(all.iter().map(|d| d.error));
        let numbers = [
            all.len().to_string(),
            format!("{error:.3} {unit}"),
            format!("{:.3} {unit}", rms(all.iter().map(|d| d.sd))),
            format!("{:.2}", rms(z())),
        ];
        table.row([kind.name().to_owned()].into_iter().chain(numbers).chain(shares));
        let key = kind.name().replace(' ', "_");
        run.number(format!("{key}_error"), error);
        run.number(format!("{key}_z"), rms(z()));
    }
    run.table("cameras and clocks: estimates against the truth", &table)?;

    let error = |of: fn(&Tried) -> f64| mean(tried.iter().map(of)).unwrap_or(f64::NAN);
    run.number("joints_found_mm", error(|tried| tried.found_mm));
    run.number("joints_true_mm", error(|tried| tried.true_mm));
    run.number("joints_trusted_mm", error(|tried| tried.trusted_mm));
    let sum = |of: fn(&Tried) -> usize| tried.iter().map(of).sum::<usize>() as f64;
    run.number("touched_and_not_named", sum(|tried| tried.missed));
    run.number("named_and_not_touched", sum(|tried| tried.accused));
    run.number("zoomed_and_not_named", sum(|tried| tried.lenses_missed));
    run.number("named_and_not_zoomed", sum(|tried| tried.lenses_accused));
    run.number("recordings_without_result", lost as f64);
    Ok(run.finish()?)
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Turn,
    Place,
    Lens,
    Clock,
}

impl Kind {
    fn name(self) -> &'static str {
        match self {
            Self::Turn => "turn",
            Self::Place => "displacement",
            Self::Lens => "focal length",
            Self::Clock => "clock",
        }
    }
}

/// How far one component is from its truth, and its standard deviation: degrees, millimetres, percent, frames.
struct Deviation {
    kind: Kind,
    error: f64,
    sd: f64,
}

/// What became of a recording.
struct Tried {
    deviations: Vec<Deviation>,
    /// Touched cameras that are not named, and named ones that were not touched.
    missed: usize,
    accused: usize,
    /// The same of zoomed ones.
    lenses_missed: usize,
    lenses_accused: usize,
    /// Mean distance of joints from the truth, mm: with what was found, with the truth, with the calibration.
    found_mm: f64,
    true_mm: f64,
    trusted_mm: f64,
}

/// A recording and its truth.
struct Recorded {
    walk: Synthetic,
    calibrated: Rig,
    offsets: Vec<CameraOffset>,
    is_touched: Vec<bool>,
    is_zoomed: Vec<bool>,
    /// As the cameras show it, and as it would be by right clocks.
    frames: Vec<FrameObservations>,
    right_frames: Vec<FrameObservations>,
}

impl Recorded {
    fn new(walker: &BodyModel, seed: u64) -> Option<Self> {
        let recipe = Recipe {
            seed,
            make: Make::Metaballs,
            frames: Some(MOMENTS * (FRAMES + 2 * MOST_LATE)),
            fps: FPS * MOMENTS as f64,
            ring: Ring { cameras: CAMERAS, ..Ring::default() },
            errors: Some(SegmentationErrors::MILD),
            stereo: None,
            ..Recipe::default()
        };
        let walk = recipe.walker(walker).ok()?;

        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        rng.set_stream(OWN);
        let (is_touched, is_off) = (some(OFF, &mut rng), some(OFF, &mut rng));
        let most = i32::try_from(MOST_LATE * MOMENTS).ok()?;
        let moments = is_off.map(|off| if off { rng.random_range(-most..=most) } else { 0 });
        let is_zoomed = some(1, &mut rng);
        let mut draw = |sd: f64| {
            Vector3::from_fn(|_, _| sd * Distribution::<f64>::sample(&StandardNormal, &mut rng))
        };
        let offset = |((touched, zoomed), moments): ((&bool, &bool), &i32)| {
            let (turn_deg, place_m) = if *touched { TOUCHED } else { GOOD };
            CameraOffset {
                turn: UnitQuaternion::from_scaled_axis(draw(turn_deg.to_radians())),
                displacement_m: draw(place_m),
                log_zoom: if *zoomed { ZOOMED.copysign(draw(1.0).x) } else { draw(GOOD_LENS).x },
                ahead_s: f64::from(*moments) / (FPS * MOMENTS as f64),
            }
        };
        let offsets: Vec<CameraOffset> =
            is_touched.iter().zip(&is_zoomed).zip(&moments).map(offset).collect();

        // the calibration has each camera where it was before
        let before = offsets.iter().map(|offset| CameraOffset {
            turn: offset.turn.inverse(),
            displacement_m: -offset.displacement_m,
            log_zoom: -offset.log_zoom,
            ahead_s: 0.0,
        });
        let calibrated = CameraOffset::applied(&walk.rig, before);
        Some(Self {
            frames: observed(&walk, &moments),
            right_frames: observed(&walk, &[0; CAMERAS]),
            calibrated,
            offsets,
            is_touched: is_touched.to_vec(),
            is_zoomed: is_zoomed.to_vec(),
            walk,
        })
    }

    fn fit(
        &self,
        body: &BodyModel,
        (rig, frames): (&Rig, &[FrameObservations]),
        cameras: Cameras,
        clocks: Clocks,
    ) -> Option<Fit> {
        let options = EstimateOptions { cameras, clocks, ..EstimateOptions::default() };
        fit(body, rig, Sequence { frames, fps: FPS }, &options, &NoJournal).ok()
    }

    fn tried(&self, body: &BodyModel) -> Option<Tried> {
        let seen = (&self.calibrated, self.frames.as_slice());
        let right = (&self.walk.rig, self.right_frames.as_slice());
        let found = self.fit(body, seen, Cameras::Refine, Clocks::Estimate)?;
        let trusted = self.fit(body, seen, Cameras::Trust, Clocks::Trust)?;
        let truly = self.fit(body, right, Cameras::Trust, Clocks::Trust)?;

        let mut deviations = Vec::new();
        let (mut missed, mut accused, mut lenses_missed, mut lenses_accused) = (0, 0, 0, 0);
        for (camera, truth) in self.offsets.iter().enumerate() {
            let of_camera = found.cameras[camera].found;
            let (pose, clock) = (of_camera.pose?, of_camera.clock?);
            missed += usize::from(self.is_touched[camera] && !pose.was_touched());
            accused += usize::from(!self.is_touched[camera] && pose.was_touched());
            lenses_missed += usize::from(self.is_zoomed[camera] && !pose.is_zoomed());
            lenses_accused += usize::from(!self.is_zoomed[camera] && pose.is_zoomed());
            let turn = truth.turn.scaled_axis().map(f64::to_degrees);
            let (turn_sd, place_sd) = (pose.turn_sd_deg?, pose.displacement_sd_m?);
            for k in 0..3 {
                let error = pose.turn_deg[k] - turn[k];
                deviations.push(Deviation { kind: Kind::Turn, error, sd: turn_sd[k] });
                let error = 1e3 * (pose.displacement_m[k] - truth.displacement_m[k]);
                deviations.push(Deviation { kind: Kind::Place, error, sd: 1e3 * place_sd[k] });
            }
            let error = 1e2 * (pose.zoom.ln() - truth.log_zoom);
            deviations.push(Deviation { kind: Kind::Lens, error, sd: 1e2 * pose.zoom_sd? });
            let error = FPS * (clock.ahead_s - truth.ahead_s);
            deviations.push(Deviation { kind: Kind::Clock, error, sd: FPS * clock.sd_s? });
        }
        Some(Tried {
            deviations,
            missed,
            accused,
            lenses_missed,
            lenses_accused,
            found_mm: self.error_mm(&found)?,
            true_mm: self.error_mm(&truly)?,
            trusted_mm: self.error_mm(&trusted)?,
        })
    }

    fn error_mm(&self, fit: &Fit) -> Option<f64> {
        let mut errors = Vec::new();
        for frame in &fit.frames {
            let truth = self.walk.points(moment(frame.frame.0, 0))?;
            for name in JOINTS {
                let (i, j) = (fit.model.point(name)?, self.walk.model.point(name)?);
                errors.push(1e3 * (frame.points_world[i] - truth[j]).norm());
            }
        }
        mean(errors)
    }
}

/// So many of the cameras.
fn some(count: usize, rng: &mut ChaCha8Rng) -> [bool; CAMERAS] {
    let mut all = std::array::from_fn(|camera| camera < count);
    all.shuffle(rng);
    all
}

/// The moment that a camera shows in a frame.
fn moment(frame: usize, ahead: i32) -> FrameIndex {
    FrameIndex(((frame + MOST_LATE) * MOMENTS).saturating_add_signed(ahead as isize))
}

/// What the cameras show, each ahead by so many moments.
fn observed(walk: &Synthetic, ahead: &[i32; CAMERAS]) -> Vec<FrameObservations> {
    let frame = |i: usize| {
        let mut seen = FrameObservations::nothing(FrameIndex(i));
        for (id, camera) in walk.rig.iter() {
            let mask = walk.mask(moment(i, ahead[id.0]), id);
            let silhouette =
                mask.and_then(|mask| extract(&mask, camera, &SilhouetteOptions::default()).ok());
            seen.views.extend(silhouette.map(|silhouette| (id, silhouette)));
        }
        seen
    };
    (0..FRAMES).map(frame).collect()
}
