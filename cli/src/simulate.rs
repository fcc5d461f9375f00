//! `maquette simulate`.

use std::path::PathBuf;

use clap::Args;
use maquette::io::folder::{Existing, check_out, origin};
use maquette::io::recording::synthetic;
use maquette::pipeline::counted;
use maquette::workflow::Simulation;
use maquette::{FittedRecording, Recording};
use serde_json::json;

use super::error::CliError;
use super::said::Said;
use super::switches::Output;
use super::synth::Noise;

pub(super) const ABOUT: &str = "\
Make a recording of a fitted body, by the fit's own cameras, with the truth beside it.

Shape and motion are those of the fit, clothes and flesh included, and the cameras stand where the fit found them, with clocks \
that agree. The folder can be given to `maquette fit`; truth.trc and truth.json hold what is true of it. So it can be seen how \
far from a truth that is known a fit of such a recording lies. Another --seed makes other errors of the masks. The first frame \
that was fitted becomes frame 0.";

pub(super) const EXAMPLES: &str = "\
Examples:
  maquette simulate out/me --out out/me-again
  maquette fit out/me-again --out out/me-again-fit
  maquette simulate out/me --out out/me-exact --noise none";

/// Arguments of `maquette simulate`.
#[derive(Debug, Args)]
pub(super) struct SimulateArguments {
    /// Folder of a finished fit
    fit: PathBuf,
    /// Folder to write into; it must be empty or new
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Errors of the masks: any number
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Segmentation errors of the masks
    #[arg(long, value_enum, default_value_t = Noise::Mild)]
    noise: Noise,
    /// The recording that was fitted, which has the cameras [default: where the fit found it]
    #[arg(long, value_name = "FOLDER")]
    recording: Option<PathBuf>,
    /// Body model of the fit, if it is not a shipped one
    #[arg(long, value_name = "FILE")]
    body: Option<String>,
    #[command(flatten)]
    output: Output,
}

/// Makes and writes the recording.
pub(super) fn run(arguments: &SimulateArguments) -> Result<(), CliError> {
    arguments.said()?.print(arguments.output);
    Ok(())
}

impl SimulateArguments {
    /// What there is to say of the recording, which is written.
    pub(super) fn said(&self) -> Result<Said, CliError> {
        check_out(&self.out, Existing::Refuse)?;
        let fit = FittedRecording::read(&self.fit, self.body.as_deref())?;
        let simulated = fit.simulated(&Simulation {
            recording: &Recording::open(self.recording()?)?,
            out: &self.fit,
            errors: self.noise.errors(),
            seed: self.seed,
        })?;
        synthetic::write(&simulated, &self.out)?;

        let out = self.out.display().to_string();
        let (frames, cameras) = (simulated.frames(), simulated.rig.cameras.len());
        let counted = counted(frames, "frame");
        Ok(Said {
            text: format!(
                "{out}: {counted} of {cameras} cameras at {} Hz; the truth is in truth.trc and truth.json\n",
                simulated.fps
            ),
            json: json!({ "out": out, "frames": frames, "cameras": cameras, "fps": simulated.fps }),
            notes: Vec::new(),
        })
    }

    /// The recording as it was named, or where the fit found it.
    fn recording(&self) -> Result<PathBuf, CliError> {
        let found = self.recording.clone().or_else(|| origin::read(&self.fit));
        Ok(found.ok_or_else(|| maquette::Error::NoOrigin { path: self.fit.clone() })?)
    }
}
