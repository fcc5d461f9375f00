//! `maquette report`.

use std::path::{Path, PathBuf};

use clap::Args;
use rayon::prelude::*;

use super::error::CliError;
use super::gait::norm_of;
use super::print;
use crate::camera::CameraId;
use crate::gait::{Gait, GaitOptions, Norm, analyse};
use crate::io::gait::{GaitFile, GaitInput, gait_file, read_fit};
use crate::io::out_folder::write_atomically;
use crate::io::recording::Recording;
use crate::io::result::ResultFile;
use crate::report::{CameraOutlines, Identity, ReportInput, html, outline_points};
use crate::silhouette::FrameIndex;

pub(super) const ABOUT: &str = "\
Write a report that a clinician can read: one HTML file that needs nothing else.

Reads the folder of a finished `maquette fit` and writes OUT/report.html: identity and method, quality, steps and \
strides, joint angles against a norm, shape, and the body in motion. It opens in any browser without a network and \
prints on A4. docs/report.md explains every page.";

pub(super) const EXAMPLES: &str = "\
Examples:
  maquette report out/me --recording my-recording
  maquette report out/me --subject 'P 017' --date 2026-03-02 --condition barefoot";

/// What the person says who makes a report.
#[derive(Debug, Args)]
pub(super) struct IdentityArguments {
    /// Who was recorded, as the report shall name them
    #[arg(long, value_name = "TEXT")]
    subject: Option<String>,
    /// When it was recorded
    #[arg(long, value_name = "TEXT")]
    date: Option<String>,
    /// Barefoot, with shoes, with an orthosis, …
    #[arg(long, value_name = "TEXT")]
    condition: Option<String>,
    /// The recording that was fitted: shows what the cameras saw
    #[arg(long, value_name = "FOLDER")]
    recording: Option<PathBuf>,
}

/// Arguments of `maquette report`.
#[derive(Debug, Args)]
pub(super) struct ReportArguments {
    /// Folder of a finished fit
    out: PathBuf,
    #[command(flatten)]
    identity: IdentityArguments,
    /// Norm of healthy people: a .toml file, or none [default: schwartz-2008-free]
    #[arg(long, value_name = "FILE|none")]
    norm: Option<String>,
    /// Body model of the fit, if it is not a shipped one
    #[arg(long, value_name = "FILE")]
    body: Option<String>,
    /// Print nothing but errors
    #[arg(long)]
    quiet: bool,
}

/// Reads the fit, analyses it and writes the report.
pub(super) fn run(arguments: &ReportArguments) -> Result<(), CliError> {
    let input = read_fit(&arguments.out, arguments.body.as_deref(), None)?;
    let norm = norm_of(arguments.norm.as_deref())?;
    let gait = analyse(&input.recording, &GaitOptions::default())?;
    let file = gait_file(&input, &gait, norm.as_ref());
    let analysed = Analysed {
        from: &arguments.out,
        input: &input,
        gait: &gait,
        file: &file,
        norm: norm.as_ref(),
    };
    let path = arguments.out.join("report.html");
    analysed.write(&arguments.identity, &path)?;
    if !arguments.quiet {
        print(&format!("{}\n", path.display()));
    }
    Ok(())
}

/// What a report is made of.
#[derive(Debug)]
pub(super) struct Analysed<'a> {
    /// Folder of the fit, or file of points.
    pub(super) from: &'a Path,
    pub(super) input: &'a GaitInput,
    pub(super) gait: &'a Gait,
    pub(super) file: &'a GaitFile,
    pub(super) norm: Option<&'a Norm>,
}

impl Analysed<'_> {
    /// Writes the report.
    pub(super) fn write(&self, said: &IdentityArguments, path: &Path) -> Result<(), CliError> {
        let result = match self.from.is_dir() {
            true => Some(ResultFile::read(self.from)?),
            false => None,
        };
        let views = match &said.recording {
            Some(folder) => views(folder, self.input)?,
            None => Vec::new(),
        };
        let name = |path: &Path| {
            let name = path.file_name().map(|n| n.to_string_lossy().into_owned());
            name.unwrap_or_else(|| path.display().to_string())
        };
        let identity = Identity {
            recording: name(said.recording.as_deref().unwrap_or(self.from)),
            subject: said.subject.clone(),
            date: said.date.clone(),
            condition: said.condition.clone(),
        };
        let text = html(&ReportInput {
            identity: &identity,
            result: result.as_ref(),
            input: self.input,
            gait: self.gait,
            file: self.file,
            norm: self.norm,
            views: &views,
        })?;
        Ok(write_atomically(path, text.as_bytes())?)
    }
}

/// The outlines of all masks, camera by camera.
fn views(folder: &Path, input: &GaitInput) -> Result<Vec<CameraOutlines>, CliError> {
    let recording = Recording::open(folder, Some(input.recording.rate_hz))?;
    let first = input.recording.first_frame;
    let frames: Vec<FrameIndex> = (0..input.recording.frames)
        .map(|i| FrameIndex(first + i))
        .collect();
    let cameras: Vec<CameraId> = recording.rig.iter().map(|(id, _)| id).collect();
    let outlines = |id: CameraId, frame: FrameIndex| -> Result<Vec<Vec<i16>>, CliError> {
        let mask = recording.load_mask(id, frame)?;
        let camera = recording.rig.camera(id);
        let borders = mask
            .zip(camera)
            .map(|(mask, camera)| outline_points(camera, &mask));
        Ok(borders.unwrap_or_default())
    };
    let mut views = Vec::new();
    for id in cameras {
        let all = frames.par_iter().map(|frame| outlines(id, *frame));
        let all: Vec<Result<Vec<Vec<i16>>, CliError>> = all.collect();
        // the first fault in the order of the frames, whichever thread met one first
        let all = all.into_iter().collect::<Result<_, _>>()?;
        if let Some(camera) = recording.rig.camera(id) {
            views.push(CameraOutlines::new(camera, all));
        }
    }
    Ok(views)
}
