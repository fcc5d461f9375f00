//! The arguments of `maquette fit`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use maquette::FitOptions;
use maquette::inference::search::Pruning;
use maquette::io::folder::Existing;
use maquette::likelihood::{EllipseOptions, Measure};
use maquette::pipeline::stereo::StereoMethod;
use maquette::pipeline::{Cameras, Clocks, FitTo, FrameRange, PeopleOptions};
use maquette::workflow::SilhouetteSource;

use crate::choice::{Choice, one_of};
use crate::stereo::METHODS;
use crate::switches::{Output, Threads};

pub(crate) const ABOUT: &str = "\
Fit a body to a recording: shape, motion and confidence.

The recording is a folder with a calibration and masks/<camera>/*.png (white where the person is, the frame number \
in the name), or videos/<camera>.* or images/<camera>/*, or a sequence.toml that says where things are. Pictures without \
masks are segmented first, and the masks kept in OUT. The result goes into OUT: result.json (everything), joints.trc \
(joint centres, for OpenSim and others) and, on request, overlays/. --resume continues a run that was stopped.";

pub(crate) const EXAMPLES: &str = "\
Examples:
  maquette fit my-recording --fps 50 --out out/me
  maquette fit my-recording/sequence.toml --out out/me --overlays
  maquette fit my-recording --fps 50 --out out/me --resume        (go on after an interruption)
  maquette fit my-recording --fps 50 --out out/short --frames 100:300 --keyframe-every 10
  maquette fit my-recording --fps 50 --out out/me --stereo        (cameras side by side: points too)
  maquette fit my-recording --fps 50 --out out/me --silhouettes joint   (clutter, no picture of the empty scene)
  maquette fit my-recording --fps 50 --out out/me --json --quiet  (for other programs)";

/// Arguments of `maquette fit`.
#[derive(Debug, Args)]
pub(crate) struct FitArguments {
    /// Folder with calibration and masks, videos or images, or a sequence.toml
    pub(super) recording: PathBuf,
    /// Folder for the result; it must be empty or new
    #[arg(long)]
    pub(super) out: PathBuf,
    /// Frames per second; overrides sequence.toml
    #[arg(long, allow_negative_numbers = true)]
    pub(super) fps: Option<f64>,
    /// Body model: a shipped one (see `maquette models`) or a .toml file [default: that of sequence.toml, or human-metaballs]
    #[arg(long, value_name = "NAME|FILE")]
    pub(super) body: Option<String>,
    /// The person's height without shoes, m; overrides sequence.toml. It is compared with the body's, which tests the calibration
    /// of all cameras together, and changes nothing of the fit
    #[arg(long, value_name = "METRES")]
    height: Option<f64>,
    /// Only these frames, first and last included [default: all]
    #[arg(long, value_name = "FIRST:LAST")]
    pub(super) frames: Option<FrameRange>,
    /// Frames between keyframes, each of which proposes a body [default: 20, or as many as give five to 13 keyframes]
    #[arg(long, value_name = "FRAMES")]
    keyframe_every: Option<usize>,
    /// What outlines are compared with [default: ellipses in the search, then metaballs if the body has them]
    #[arg(long, value_enum)]
    likelihood: Option<Likelihood>,
    /// What lines of sight and points are compared with the metaballs' skin by [default: distance]
    #[arg(long, value_enum)]
    residual: Option<SkinResidual>,
    /// Fit all frames together at the end, which gives every number a standard deviation
    #[arg(long, value_enum, default_value_t = Switch::On)]
    joint: Switch,
    /// Where the cameras are: where their calibration says, or about there, with turns, displacements and focal lengths estimated and reported
    #[arg(long, value_parser = one_of(CAMERAS), default_value = "refine")]
    cameras: Cameras,
    /// When they took their pictures: all at once, or by clocks whose offsets are estimated and reported
    #[arg(long, value_parser = one_of(CLOCKS), default_value = "estimate")]
    clocks: Clocks,
    /// Follow every proposed body to the end, even when it can no longer win
    #[arg(long)]
    no_pruning: bool,
    /// Measure points on the person with cameras that stand side by side, and fit to them too (kept in OUT/points)
    #[arg(long, value_parser = one_of(METHODS), value_name = "METHOD", num_args = 0..=1, require_equals = true, default_missing_value = "matching")]
    pub(super) stereo: Option<StereoMethod>,
    /// How outlines are found in pictures [default: from masks if there are any; else joint if cameras stand side by side and
    /// there is no picture of the empty scene; else background]
    #[arg(long, value_parser = one_of(SILHOUETTES), value_name = "WAY")]
    pub(super) silhouettes: Option<SilhouetteSource>,
    /// What to fit to
    #[arg(long, value_parser = one_of(FITTED), default_value = "all")]
    fit_to: FitTo,
    /// How many people are looked for in the masks at most: `auto`, or a number
    #[arg(long, value_parser = most_people, default_value = "auto", value_name = "auto|NUMBER")]
    people: MostPeople,
    /// Who is measured, if there are several: 1 is the one who is in view longest and crosses the room (of several, the smallest); the
    /// others' results are in OUT/people
    #[arg(long, default_value_t = 1, value_name = "NUMBER")]
    person: usize,
    #[command(flatten)]
    pub(super) threads: Threads,
    /// Draw the fit over the masks, into OUT/overlays
    #[arg(long)]
    pub(super) overlays: bool,
    /// Continue a run that was stopped
    #[arg(long, conflicts_with = "overwrite")]
    resume: bool,
    /// Replace the result in OUT once the new one is complete
    #[arg(long)]
    overwrite: bool,
    #[command(flatten)]
    pub(super) output: Output,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Likelihood {
    /// Signed distance between the outline and that of all ellipses, both ways
    Ellipses,
    /// Distance to the nearest ellipse, as published by Zimmermann and Svoboda
    Published,
    /// Lines of sight and points against the metaballs' skin
    Metaballs,
    /// Both ellipses and metaballs
    Both,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum SkinResidual {
    /// How far they are from the skin
    Distance,
    /// What the field there is off the skin's value, T − F, in least squares, as published by Plänkers and Fua
    Field,
}

impl Likelihood {
    fn measure(self) -> Measure {
        match self {
            Self::Ellipses | Self::Published => Measure::Ellipses,
            Self::Metaballs => Measure::Metaballs,
            Self::Both => Measure::Both,
        }
    }
}

const SILHOUETTES: &[Choice<SilhouetteSource>] = &[
    (
        "background",
        SilhouetteSource::Background,
        "By masks, given or cut out by learning the background",
    ),
    (
        "joint",
        SilhouetteSource::Joint,
        "By active contours from a fitted body, as in `maquette silhouettes`; points come with them, or from --stereo",
    ),
];

const CAMERAS: &[Choice<Cameras>] = &[
    ("trust", Cameras::Trust, "Where their calibration says"),
    (
        "refine",
        Cameras::Refine,
        "About there: turns, displacements and focal lengths of cameras that two others cross are estimated",
    ),
    (
        "check",
        Cameras::Check,
        "Where their calibration says; turns, displacements and focal lengths are estimated and told, and not used",
    ),
];

const CLOCKS: &[Choice<Clocks>] = &[
    ("trust", Clocks::Trust, "All at once"),
    (
        "estimate",
        Clocks::Estimate,
        "By clocks that may be off; those of cameras that another crosses are estimated",
    ),
];

const FITTED: &[Choice<FitTo>] = &[
    ("all", FitTo::All, "Outlines, and points and detections where there are any"),
    ("silhouettes", FitTo::Silhouettes, "Outlines alone"),
    ("points", FitTo::Points, "Points alone; masks only say where the person is"),
    (
        "detections",
        FitTo::Detections,
        "Detections of joints alone, of each person whom two cameras see; masks are left out",
    ),
];

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Switch {
    On,
    Off,
}

/// How many people are looked for; none: as many as there are.
#[derive(Debug, Clone, Copy)]
struct MostPeople(Option<usize>);

fn most_people(text: &str) -> Result<MostPeople, String> {
    let number = || text.parse().ok().filter(|number| (1..=9).contains(number));
    match text {
        "auto" => Ok(MostPeople(None)),
        _ => number().map(|n| MostPeople(Some(n))).ok_or_else(|| "auto, or 1 to 9".into()),
    }
}

impl FitArguments {
    pub(super) fn options(&self) -> FitOptions {
        let mut options = FitOptions {
            body: self.body.clone(),
            frames: self.frames.unwrap_or_default(),
            silhouettes: self.silhouettes,
            stereo: self.stereo,
            ..FitOptions::default()
        };
        options.observations.fit_to = self.fit_to;
        options.observations.people = PeopleOptions { most: self.people.0, person: self.person };

        let estimate = &mut options.estimate;
        estimate.search.keyframe_every = self.keyframe_every;
        estimate.height_m = self.height;
        if self.no_pruning {
            estimate.search.pruning = Pruning::Off;
        }
        estimate.measure = self.likelihood.map(Likelihood::measure);
        if self.likelihood == Some(Likelihood::Published) {
            estimate.likelihood.ellipses = EllipseOptions::published();
        }
        if self.residual == Some(SkinResidual::Field) {
            estimate.likelihood = estimate.likelihood.by_field();
        }
        if self.joint == Switch::Off {
            estimate.joint = None;
        }
        (estimate.cameras, estimate.clocks) = (self.cameras, self.clocks);
        options
    }

    pub(super) fn existing(&self) -> Existing {
        match (self.resume, self.overwrite) {
            (true, _) => Existing::Resume,
            (false, true) => Existing::Overwrite,
            (false, false) => Existing::Refuse,
        }
    }
}
