//! What `maquette fit` is told.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use maquette::FitOptions;
use maquette::inference::search::Pruning;
use maquette::io::folder::Existing;
use maquette::likelihood::{EllipseOptions, Measure};
use maquette::pipeline::stereo::StereoMethod;
use maquette::pipeline::{FitTo, FrameRange};
use maquette::workflow::SilhouetteSource;

use crate::stereo::Method;
use crate::switches::{Quiet, Threads};

pub(crate) const ABOUT: &str = "\
Fit a body to a recording: shape, motion and confidence.

The recording is a folder with a calibration and masks/<camera>/*.png (white where the person is, the frame number \
in the name), or videos/<camera>.* or images/<camera>/*, or a sequence.toml that says where things are. Pictures without \
masks are segmented first, and the masks kept in OUT. Into OUT go result.json (everything), joints.trc (joint \
centres, for OpenSim and others) and, on request, overlays/. A run that was stopped can be continued with --resume.";

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
    /// Body model: a shipped one (see `maquette models`) or a .toml file [default: that of sequence.toml, or human-ellipsoids]
    #[arg(long, value_name = "NAME|FILE")]
    pub(super) body: Option<String>,
    /// Fit only the frames of these numbers, both included
    #[arg(long, value_name = "FIRST:LAST")]
    pub(super) frames: Option<FrameRange>,
    /// Every how many frames a keyframe proposes a body [default: 20, or less where that would be fewer than five keyframes]
    #[arg(long, value_name = "FRAMES")]
    keyframe_every: Option<usize>,
    /// What outlines are compared with, in every stage [default: ellipses first, then metaballs if the body has them]
    #[arg(long, value_enum)]
    likelihood: Option<Likelihood>,
    /// Whether all frames are fitted at once in the end, with a standard deviation for every number
    #[arg(long, value_enum, default_value_t = Switch::On)]
    joint: Switch,
    /// Whether cameras may look a little elsewhere than their calibration says: found from outlines, and told
    #[arg(long, value_enum, default_value_t = Switch::On)]
    aim: Switch,
    /// Follow every proposed body to the end, also when it can no longer win
    #[arg(long)]
    no_pruning: bool,
    /// Measure points on the person with cameras that stand side by side and fit to them too; they are kept in OUT/points
    #[arg(long, value_enum, value_name = "METHOD", num_args = 0..=1, require_equals = true, default_missing_value = "matching")]
    pub(super) stereo: Option<Method>,
    /// How silhouettes are found where there are pictures [default: those of the masks; without masks joint, if cameras stand
    /// side by side and no picture of the empty scene is given, else background]
    #[arg(long, value_enum, value_name = "WAY")]
    pub(super) silhouettes: Option<Silhouettes>,
    /// What is fitted to
    #[arg(long, value_enum, default_value_t = Fitted::All)]
    fit_to: Fitted,
    #[command(flatten)]
    pub(super) threads: Threads,
    /// Write pictures of the fit over the masks into OUT/overlays
    #[arg(long)]
    pub(super) overlays: bool,
    /// Continue a run that was stopped
    #[arg(long, conflicts_with = "overwrite")]
    resume: bool,
    /// Replace the result in OUT when the new one is complete
    #[arg(long)]
    overwrite: bool,
    #[command(flatten)]
    pub(super) quiet: Quiet,
    /// Print the summary as JSON
    #[arg(long)]
    pub(super) json: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Likelihood {
    /// Signed distance to the outline of all ellipses, and back
    Ellipses,
    /// Distance to the nearest ellipse, as Zimmermann and Svoboda published it
    Published,
    /// Lines of sight and points against the skin of the metaballs
    Metaballs,
    /// Both ellipses and metaballs
    Both,
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

/// How silhouettes are found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum Silhouettes {
    /// Those of masks, given or made by learning the background
    Background,
    /// Those that the body predicts, by depth and active contours, as `maquette silhouettes` does; and points with them, or those of --stereo
    Joint,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Fitted {
    /// Silhouettes, and points where there are any
    All,
    /// Points alone; masks only say where the person is
    Points,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Switch {
    On,
    Off,
}

impl From<Silhouettes> for SilhouetteSource {
    fn from(way: Silhouettes) -> Self {
        match way {
            Silhouettes::Background => Self::Background,
            Silhouettes::Joint => Self::Joint,
        }
    }
}

impl From<Fitted> for FitTo {
    fn from(fitted: Fitted) -> Self {
        match fitted {
            Fitted::All => Self::All,
            Fitted::Points => Self::Points,
        }
    }
}

impl FitArguments {
    pub(super) fn options(&self) -> FitOptions {
        let mut options = FitOptions {
            body: self.body.clone(),
            frames: self.frames.unwrap_or_default(),
            silhouettes: self.silhouettes.map(SilhouetteSource::from),
            stereo: self.stereo.map(StereoMethod::from),
            ..FitOptions::default()
        };
        options.observations.fit_to = self.fit_to.into();

        let estimate = &mut options.estimate;
        estimate.search.keyframe_every = self.keyframe_every;
        if self.no_pruning {
            estimate.search.pruning = Pruning::Off;
        }
        estimate.measure = self.likelihood.map(Likelihood::measure);
        if self.likelihood == Some(Likelihood::Published) {
            estimate.likelihood.ellipses = EllipseOptions::published();
        }
        if self.joint == Switch::Off {
            estimate.joint = None;
        }
        estimate.aim = self.aim == Switch::On;
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
