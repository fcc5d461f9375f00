//! PFD99 Figs. 8–11: arms that wave before three cameras, two seconds at 25 Hz, from the pictures alone.
//!
//! Image triplets of a person who is drawn as a mesh that bones bend (`synth/film`) → outlines from nothing (PF02 § 4) → clouds of
//! the pairs within them → the body, fitted to clouds and outlines. No truth enters but for comparison.
//!
//! **Differs** from the paper, which fits an arm by itself, from joints that tracked points give: here the whole body is found from
//! nothing, and both its arms are compared. The clouds are of correlation and not of least-squares matching (§ 2.1), with which the
//! joint optimum fattens this body; trajectories (§ 2.2) have no part in it. `pfd99_matching` measures both.
//!
//! Starts: from nothing; the paper's user clicks on a few joints.

mod pictures;

use std::error::Error;
use std::path::Path;
use std::process::ExitCode;

use experiments::film::photographed;
use experiments::limb::{Arm, LimbErrors, arm_errors};
use experiments::metrics::{self, offset_errors_mm};
use experiments::run::Run;
use experiments::table::Table;
use maquette::body::{Motion, Posed, Shape};
use maquette::io::recording::synthetic;
use maquette::math::stats::{mean, median};
use maquette::pipeline::stereo::StereoMethod;
use maquette::silhouette::FrameIndex;
use maquette::synth::{Film, FilmRecipe};
use maquette::workflow::SilhouetteSource;
use maquette::{FitOptions, FittedRecording, Recording};

/// Anything that ends the experiment.
type Fault = Box<dyn Error>;

/// The film of PFD99's length and rate.
const FRAMES: usize = 50;
const FPS: f64 = 25.0;
/// An arm whose joints are farther off on average is lost, mm.
const LOST_MM: f64 = 50.0;
/// Both arms and their names.
pub(crate) const ARMS: [(&str, Arm); 2] = [("right", Arm::Right), ("left", Arm::Left)];

/// The fitted body beside the true one.
pub(crate) struct Compared {
    pub(crate) film: Film,
    pub(crate) fit: FittedRecording,
    pub(crate) shape: Shape,
    pub(crate) motions: Vec<Motion>,
    /// Errors of each arm, frame by frame.
    pub(crate) errors: [Vec<LimbErrors>; 2],
}

fn main() -> Result<ExitCode, Fault> {
    let mut run = Run::start("pfd99_arm");
    run.setting("frames", FRAMES);
    run.setting("fps", FPS);
    let compared = Compared::new(run.seed(), &run.folder())?;
    report(&mut run, &compared)?;
    run.picture("errors", &pictures::errors(&compared))?;
    run.photograph("arms", &pictures::arms(&compared)?)?;
    Ok(run.finish()?)
}

impl Compared {
    /// Films, fits as a user would, and compares.
    fn new(seed: u64, folder: &Path) -> Result<Self, Fault> {
        // 1. the pictures
        let recipe = FilmRecipe { seed, frames: FRAMES, fps: FPS, ..FilmRecipe::default() };
        let recording = folder.join("recording");
        let film = photographed(&recipe, &recording)?;

        // 2. the body
        let options = FitOptions {
            silhouettes: Some(SilhouetteSource::Joint),
            stereo: Some(StereoMethod::Correlation),
            ..FitOptions::default()
        };
        let fit = Recording::open(recording)?.fit(&options)?;
        fit.usable()?;
        let shape = fit.result.shape_of(&fit.model)?;
        let motions: Vec<Motion> = fit.result.motion.frames.iter().map(|f| f.motion()).collect();

        // 3. its arms
        let errors = ARMS.map(|(_, arm)| {
            let fitted = motions.iter().map(|motion| Posed::new(&fit.model, &shape, motion));
            let truth = (0..FRAMES).filter_map(|i| film.synthetic.posed(FrameIndex(i)));
            fitted.zip(truth).map(|(fitted, truth)| arm_errors(&fitted, &truth, arm)).collect()
        });
        Ok(Self { film, fit, shape, motions, errors })
    }

    /// Frames in which an arm is lost, or that have none.
    fn lost(&self) -> usize {
        let is_lost = |i: &usize| {
            let off = |errors: &Vec<LimbErrors>| errors.get(*i).map(|e| e.joints_mm);
            self.errors.iter().any(|errors| off(errors).is_none_or(|mm| mm > LOST_MM))
        };
        (0..FRAMES).filter(is_lost).count()
    }

    /// Mean distance of an arm's joints after each one's own offset, mm.
    fn offset_mm(&self, arm: Arm) -> f64 {
        let fitted = metrics::trajectories(&self.fit.model, &self.shape, &self.motions, FPS);
        let truth = synthetic::trajectories(&self.film.synthetic);
        let joints = arm.joint_names();
        let errors = offset_errors_mm(&truth, &fitted);
        let named = errors.iter().flat_map(|frame| metrics::LIMB_JOINTS.iter().zip(frame));
        let of_arm =
            named.filter(|(name, _)| joints.iter().any(|joint| joint == *name)).map(|(_, mm)| *mm);
        mean(of_arm).unwrap_or(f64::NAN)
    }
}

fn report(run: &mut Run, compared: &Compared) -> Result<(), Fault> {
    let mut table = Table::new(
        "arms",
        &[
            "arm",
            "joints, mm",
            "joints after offset, mm",
            "elbow, °",
            "upper arm, mm",
            "forearm, mm",
            "width of upper arm, %",
            "width of forearm, %",
        ],
    );
    for ((name, arm), errors) in ARMS.iter().zip(&compared.errors) {
        let middle = |value: &dyn Fn(&LimbErrors) -> f64| {
            median(&mut errors.iter().map(value).collect::<Vec<f64>>()).unwrap_or(f64::NAN)
        };
        let numbers = [
            ("joints_mm", middle(&|e| e.joints_mm)),
            ("offset_mm", compared.offset_mm(*arm)),
            ("elbow_deg", middle(&|e| e.elbow_deg.abs())),
            ("upper_arm_mm", middle(&|e| e.length_mm[0])),
            ("forearm_mm", middle(&|e| e.length_mm[1])),
            ("upper_arm_width_pct", middle(&|e| e.width_pct[0])),
            ("forearm_width_pct", middle(&|e| e.width_pct[1])),
        ];
        for (number, value) in numbers {
            run.number(format!("{name}_{number}"), value);
        }
        let cells = numbers.iter().map(|(_, value)| format!("{value:.1}"));
        table.row(std::iter::once((*name).to_owned()).chain(cells));
    }
    run.number("frames_lost", compared.lost() as f64);
    Ok(run.table("Medians over the frames", &table)?)
}
