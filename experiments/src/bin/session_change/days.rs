//! One simulated person on two days.

use std::error::Error;
use std::fs;
use std::path::{Path, PathBuf};

use experiments::individual::individual;
use experiments::walker::wide_ring;
use maquette::body::{BodyModel, Posed};
use maquette::gait::trials::{Change, Measure, Quantity, measured};
use maquette::gait::{GaitOptions, Norm, Side, analyse};
use maquette::io::folder::Existing;
use maquette::io::recording::synthetic;
use maquette::pipeline::{FittedMotion, FramePose, NoProgress};
use maquette::silhouette::FrameIndex;
use maquette::synth::{
    Curve, Ground, Make, Recipe, SegmentationErrors, Synthetic, Walk, WalkingStyle,
};
use maquette::workflow::{
    Comparison, FitOptions, NormChoice, Session, SessionFolder, SessionStudy,
};
use nalgebra::Vector2;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use crate::Z_95;

/// Frames of a trial, which hold a whole stride of each side, and of the walk that tells the truth.
const FRAMES: usize = 70;
const TRUE_FRAMES: usize = 150;
const FPS: f64 = 30.0;
/// Random stream of the days; the recipe's own are others.
const DAYS: u64 = 6;
/// Standard deviations of what changes between the days, relative (E): the knees' bend, all movements and with them the steps, the cadence.
const KNEE_SD: f64 = 0.08;
const STEP_SD: f64 = 0.05;
const CADENCE_SD: f64 = 0.04;
/// Standard deviations of a trial's place, m, and direction, as `maquette synth --trial` has them.
const PLACE_SD_M: f64 = 0.1;
const HEADING_SD: f64 = 0.05;

/// How two days are compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Way {
    /// Each day has a session, with a body of its own.
    TwoSessions,
    /// The days are conditions of one session, with one body.
    OneSession,
}

impl Way {
    pub(crate) const ALL: [(Self, &str); 2] =
        [(Self::TwoSessions, "two_sessions"), (Self::OneSession, "one_session")];
}

/// A change and its interval.
pub(crate) struct Found {
    pub(crate) way: Way,
    pub(crate) name: &'static str,
    pub(crate) side: &'static str,
    pub(crate) truth: f64,
    pub(crate) found: f64,
    pub(crate) low: f64,
    pub(crate) high: f64,
}

impl Found {
    /// Whether the interval holds the truth.
    pub(crate) fn holds(&self) -> bool {
        (self.low..=self.high).contains(&self.truth)
    }

    /// Half the width of the interval.
    pub(crate) fn half(&self) -> f64 {
        0.5 * (self.high - self.low)
    }

    /// By how many standard errors the change is off, if the interval is 1.96 of them.
    pub(crate) fn off_se(&self) -> f64 {
        Z_95 * (self.found - self.truth) / self.half()
    }
}

/// Somebody, and how they walk on two days.
pub(crate) struct Person {
    seed: u64,
    filmed: Synthetic,
    days: [WalkingStyle; 2],
    rng: ChaCha8Rng,
}

impl Person {
    /// `None` if the make has no skin for this person.
    pub(crate) fn new(seed: u64, make: Make, body: &BodyModel, walker: &BodyModel) -> Option<Self> {
        let recipe = Recipe {
            seed,
            make,
            frames: Some(FRAMES),
            fps: FPS,
            ring: wide_ring(5),
            errors: Some(SegmentationErrors::MILD),
            stereo: None,
            ..Recipe::default()
        };
        let filmed = recipe.walker(&individual(&recipe, body, walker)?).ok()?;
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        rng.set_stream(DAYS);
        let first = WalkingStyle::personal(&mut rng);
        let second = changed(&first, &mut rng);
        Some(Self { seed, filmed, days: [first, second], rng })
    }

    /// Films both days, fits them and compares them in both ways.
    pub(crate) fn changes(
        mut self,
        trials: u64,
        folder: &Path,
        numbers: &[(&'static str, Quantity)],
    ) -> Result<Vec<Found>, Box<dyn Error>> {
        let mut places = Vec::new();
        for (day, style) in self.days.clone().iter().enumerate() {
            let place = folder.join(format!("{}_{day}", self.seed));
            for trial in 0..trials {
                let walk = self.trial(style);
                let filmed = Synthetic {
                    motions: walk.motions(&self.filmed.model, &self.filmed.shape, FPS, FRAMES)?,
                    seed: self.seed.wrapping_add((1 + trial + trials * day as u64) << 32),
                    ..self.filmed.clone()
                };
                synthetic::write(&filmed, &place.join(format!("walk_{trial}")))?;
            }
            places.push(place);
        }

        let out = folder.join("out");
        let before = fitted(&places[..1], &out)?;
        let norm = before.norm().cloned();
        let truths =
            [self.truth(&self.days[0], norm.as_ref())?, self.truth(&self.days[1], norm.as_ref())?];
        let apart = Comparison::new(before, fitted(&places[1..], &out)?)?;
        let together = Comparison::of_conditions(&fitted(&places, &out)?, None)?;
        fs::remove_dir_all(folder)?;

        let ways = [(Way::TwoSessions, apart), (Way::OneSession, together)];
        let found = ways.iter().flat_map(|(way, comparison)| {
            let changes = comparison.changes.iter();
            changes.filter_map(|change| found(*way, change, &truths, numbers))
        });
        Ok(found.collect())
    }

    /// A walk of a day, somewhere in the room.
    fn trial(&mut self, style: &WalkingStyle) -> Walk {
        let style = style.again(&mut self.rng);
        let mut draw = || -> f64 { StandardNormal.sample(&mut self.rng) };
        let heading = HEADING_SD * draw();
        let middle_world = PLACE_SD_M * Vector2::new(draw(), draw());
        let start_phase = self.rng.random();
        Walk { style, heading, middle_world, start_phase, ground: Ground::Floor }
    }

    /// All numbers of the walk about which the trials of a day are drawn.
    fn truth(
        &self,
        style: &WalkingStyle,
        norm: Option<&Norm>,
    ) -> Result<Vec<(Measure, f64)>, Box<dyn Error>> {
        let walk = Walk {
            style: style.clone(),
            heading: 0.0,
            middle_world: Vector2::zeros(),
            start_phase: 0.0,
            ground: Ground::Floor,
        };
        let (model, shape) = (&self.filmed.model, &self.filmed.shape);
        let frames = walk.motions(model, shape, FPS, TRUE_FRAMES)?.into_iter().enumerate();
        let pose = |(i, motion)| {
            let body = Posed::new(model, shape, &motion);
            let points_m = body.points().into_iter().map(Into::into).collect();
            FramePose {
                frame: FrameIndex(i),
                is_seen: true,
                motion,
                points_m,
                sd: None,
                cameras: 1,
            }
        };
        let moved = FittedMotion {
            model: model.clone(),
            shape: shape.clone(),
            rate_hz: FPS,
            points: model.points.iter().map(|point| point.name.clone()).collect(),
            frames: frames.map(pose).collect(),
        };
        let gait = analyse(&moved.into_movement()?.0, &GaitOptions::default())?;
        let all = measured(&gait, norm);
        Ok(all.into_iter().map(|(measure, measured)| (measure, measured.value)).collect())
    }
}

/// The same person on another day.
fn changed(style: &WalkingStyle, rng: &mut ChaCha8Rng) -> WalkingStyle {
    let mut draw = |sd: f64| -> f64 {
        let drawn: f64 = StandardNormal.sample(rng);
        1.0 + sd * drawn.clamp(-2.0, 2.0)
    };
    let (knees, steps, cadence) = (draw(KNEE_SD), draw(STEP_SD), draw(CADENCE_SD));
    let swung = |curve: &Curve, gain: f64| Curve {
        mean: curve.mean,
        harmonics: curve.harmonics.iter().map(|(a, b)| (gain * a, gain * b)).collect(),
    };
    let joint = |(name, curve): (&String, &Curve)| {
        let own = if name.starts_with("knee_flexion") { knees } else { 1.0 };
        (name.clone(), swung(curve, own * steps))
    };
    WalkingStyle {
        stride_hz: cadence * style.stride_hz,
        pelvis: style.pelvis.each_ref().map(|curve| swung(curve, steps)),
        joints: style.joints.iter().map(joint).collect(),
    }
}

/// A session of these folders of trials.
fn fitted(places: &[PathBuf], out: &Path) -> Result<SessionStudy, Box<dyn Error>> {
    let options = FitOptions { body: Some("human-ellipsoids".into()), ..FitOptions::default() };
    let session = SessionFolder { path: out, existing: Existing::Overwrite };
    Session::open(places)?.fit_into(session, &options, &NoProgress)?;
    Ok(SessionStudy::open(out, None, NormChoice::Shipped)?)
}

/// The change of one of the numbers, with the true one; `None` of another number, and where there is no interval.
fn found(
    way: Way,
    change: &Change,
    truths: &[Vec<(Measure, f64)>; 2],
    numbers: &[(&'static str, Quantity)],
) -> Option<Found> {
    let measure = change.measure;
    let (name, _) = numbers.iter().find(|(_, quantity)| *quantity == measure.quantity)?;
    let of = |truth: &Vec<(Measure, f64)>| {
        truth.iter().find(|(own, _)| *own == measure).map(|(_, value)| *value)
    };
    let (low, high) = change.interval?;
    let side = match measure.side {
        Side::Left => "left",
        Side::Right => "right",
    };
    let truth = of(&truths[1])? - of(&truths[0])?;
    Some(Found { way, name, side, truth, found: change.difference, low, high })
}
