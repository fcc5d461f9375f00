//! `maquette synth`.

use std::path::{Path, PathBuf};

use clap::builder::PossibleValuesParser;
use clap::{Args, ValueEnum};
use serde_json::json;

use super::error::CliError;
use super::switches::Output;
use maquette::body::BodyModel;
use maquette::io::recording::{filmed, synthetic};
use maquette::io::{frame_rate, model};
use maquette::pipeline::counted;
use maquette::synth::{
    Action, FilmRecipe, Ground, Make, Movement, Recipe, Ring, SegmentationErrors, StereoPair,
};

pub(super) const ABOUT: &str = "\
Make a recording of a person who walks, or does something else, with the truth beside it.

A body and a way of walking are drawn from the seed, and ray-cast into a ring of cameras. The folder can be given to \
`maquette fit`; truth.trc and truth.json hold what is true of it. The same arguments give the same files.

With --clutter the person walks on the spot and waves before three cameras side by side, which take photographs: there are \
no masks but the true ones, in truth/masks, and no picture of the empty room.";

/// Arguments of `maquette synth`.
#[derive(Debug, Args)]
pub(super) struct SynthArguments {
    /// Folder to write into; it must be empty or new
    out: PathBuf,
    /// Who walks, and how: any number
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Which trial of the person: another one has the same body and cameras, and a walk that differs a little
    #[arg(long, default_value_t = 0, value_parser = clap::value_parser!(u32).range(0..=1_000_000), conflicts_with = "clutter")]
    trial: u32,
    /// Number of cameras around the person
    #[arg(long, default_value_t = 6, value_parser = clap::value_parser!(u16).range(1..=64))]
    cameras: u16,
    /// Number of frames [default: one gait cycle; with --clutter 300]
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    frames: Option<u32>,
    /// Frames per second [default: 50; with --clutter 25]
    #[arg(long, value_parser = rate)]
    fps: Option<f64>,
    /// The person walks on a treadmill, and so stays in the middle of the cameras
    #[arg(long, conflicts_with_all = ["clutter", "action"])]
    treadmill: bool,
    /// What the person does: walks, stands still (for the zero of the angles of other trials), or moves on the spot
    #[arg(long, default_value = WALK, value_parser = actions(), conflicts_with = "clutter")]
    action: String,
    /// What the person is made of
    #[arg(long, value_enum, default_value_t = MadeOf::Metaballs)]
    make: MadeOf,
    /// Segmentation errors of the masks
    #[arg(long, value_enum, default_value_t = Noise::Mild)]
    noise: Noise,
    /// Also points on the skin, as a second camera beside each would measure them
    #[arg(long, conflicts_with = "make")]
    points: bool,
    /// Photographs of a person before clutter, from three cameras side by side
    #[arg(long, conflicts_with_all = ["cameras", "make", "noise", "points"])]
    clutter: bool,
    /// Body model with metaballs: a shipped one or a .toml file
    #[arg(long, default_value = "walker-metaballs")]
    body: String,
    #[command(flatten)]
    output: Output,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum MadeOf {
    /// Metaballs, each fixed to its part
    Metaballs,
    /// A skin that follows the parts by shares, of uneven sections
    Flesh,
    /// The same with clothes, shoes and hair
    Dressed,
}

/// Segmentation errors of masks.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum Noise {
    /// Exact masks
    None,
    /// As from a good background subtraction
    Mild,
}

impl Noise {
    pub(super) fn errors(self) -> Option<SegmentationErrors> {
        match self {
            Self::None => None,
            Self::Mild => Some(SegmentationErrors::MILD),
        }
    }
}

/// The names of what a person does who does not move in another way.
const WALK: &str = "walk";
const STAND: &str = "stand";

/// The names of all that a person can do.
fn actions() -> PossibleValuesParser {
    let moves = Movement::ALL.map(Movement::name);
    PossibleValuesParser::new([WALK, STAND].into_iter().chain(moves))
}

fn action(name: &str) -> Action {
    let movement = Movement::ALL.into_iter().find(|movement| movement.name() == name);
    match movement {
        Some(movement) => Action::Move(movement),
        None if name == STAND => Action::Stand,
        None => Action::Walk,
    }
}

fn rate(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(hz) if frame_rate::is_one(hz) => Ok(hz),
        _ => Err(format!("expected {}", frame_rate::EXPECTED)),
    }
}

/// Makes and writes the recording.
pub(super) fn run(arguments: &SynthArguments) -> Result<(), CliError> {
    let (frames, cameras, fps) = arguments.written()?;
    let out = arguments.out.display().to_string();
    let counted = counted(frames, "frame");
    arguments.output.summarise(
        || {
            format!(
                "{out}: {counted} of {cameras} cameras at {fps} Hz; the truth is in truth.trc and truth.json\n"
            )
        },
        || json!({ "out": out, "frames": frames, "cameras": cameras, "fps": fps }),
    );
    Ok(())
}

/// Number of frames, number of cameras, frames per second.
pub(super) type Written = (usize, usize, f64);

impl SynthArguments {
    /// The recording, which is written into its folder.
    pub(super) fn written(&self) -> Result<Written, CliError> {
        let model = model::load(&self.body, Path::new(""))?;
        if self.clutter { film(self, &model) } else { ring(self, &model) }
    }
}

fn ring(arguments: &SynthArguments, model: &BodyModel) -> Result<Written, CliError> {
    let default = Recipe::default();
    let recipe = Recipe {
        seed: arguments.seed,
        trial: arguments.trial.into(),
        frames: arguments.frames.map(|frames| frames as usize),
        fps: arguments.fps.unwrap_or(default.fps),
        action: action(&arguments.action),
        ground: if arguments.treadmill { Ground::Treadmill } else { Ground::Floor },
        make: match arguments.make {
            MadeOf::Metaballs => Make::Metaballs,
            MadeOf::Flesh => Make::Flesh,
            MadeOf::Dressed => Make::Dressed,
        },
        ring: Ring { cameras: arguments.cameras.into(), ..default.ring },
        errors: arguments.noise.errors(),
        stereo: arguments.points.then(StereoPair::default),
    };

    let recording = recipe.walker(model)?;
    synthetic::write(&recording, &arguments.out)?;
    Ok((recording.frames(), arguments.cameras.into(), recipe.fps))
}

fn film(arguments: &SynthArguments, model: &BodyModel) -> Result<Written, CliError> {
    let default = FilmRecipe::default();
    let recipe = FilmRecipe {
        seed: arguments.seed,
        frames: arguments.frames.map_or(default.frames, |n| n as usize),
        fps: arguments.fps.unwrap_or(default.fps),
        ..default
    };
    let recording = recipe.film(model)?;
    filmed::write(&recording, &arguments.out)?;
    let cameras = recording.synthetic.rig.cameras.len();
    Ok((recipe.frames, cameras, recipe.fps))
}
