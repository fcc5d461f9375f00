//! What `gait`, `report` and `export` share: reading, analysing, and the report of both.

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use rayon::prelude::*;

use super::error::CliError;
use maquette::camera::CameraId;
use maquette::gait::{GaitAnalysis, GaitOptions, Norm, analyse};
use maquette::io::folder::write_atomically;
use maquette::io::gait::{
    GaitFile, GaitInput, SHIPPED_NORM, Sex, add_parameters, from_result, gait_file, load_norm,
    parse_norm, read_points,
};
use maquette::io::model;
use maquette::io::recording::Recording;
use maquette::io::result::ResultFile;
use maquette::report::{CameraOutlines, ReportInput, Subject, html, outline_points};
use maquette::silhouette::FrameIndex;

/// What is to be analysed, and against what.
#[derive(Debug, Clone, Copy)]
pub(super) struct Asked<'a> {
    /// Folder of a finished fit, or a file of points.
    pub(super) from: &'a Path,
    /// Body model of the fit, if it is not a shipped one.
    pub(super) body: Option<&'a str>,
    /// Frames per second, in place of what the input states.
    pub(super) fps: Option<f64>,
    /// File of a norm, `none`, or the shipped one.
    pub(super) norm: Option<&'a str>,
    /// Age in completed years and sex, which choose the norm of steps and strides.
    pub(super) person: (Option<u32>, Option<Sex>),
}

/// A fit or points, and what was found in them.
#[derive(Debug)]
pub(super) struct Analysed {
    from: PathBuf,
    result: Option<ResultFile>,
    pub(super) input: GaitInput,
    pub(super) norm: Option<Norm>,
    pub(super) gait: GaitAnalysis,
    pub(super) file: GaitFile,
}

impl Analysed {
    /// Reads and analyses.
    pub(super) fn of(asked: &Asked<'_>, options: &GaitOptions) -> Result<Self, CliError> {
        let (input, result) = match asked.from.is_dir() {
            true => {
                let result = ResultFile::read(asked.from)?;
                let body = asked.body.unwrap_or(&result.body);
                let model = model::load(body, Path::new(""))?;
                (from_result(&result, model, asked.fps)?, Some(result))
            }
            false => (read_points(asked.from, asked.fps)?, None),
        };
        let norm = norm_of(asked)?;
        let gait = analyse(&input.movement, options)?;
        Ok(Self {
            from: asked.from.into(),
            result,
            file: gait_file(&input, &gait, norm.as_ref()),
            input,
            norm,
            gait,
        })
    }

    /// Writes the report.
    pub(super) fn write_report(
        &self,
        said: &IdentityArguments,
        path: &Path,
    ) -> Result<(), CliError> {
        let result = self.result.as_ref();
        let views = match &said.recording {
            Some(folder) => views(folder, &self.input, result)?,
            None => Vec::new(),
        };
        let text = html(&ReportInput {
            subject: &said.subject(&self.from),
            result,
            body: self.input.body.as_ref(),
            movement: &self.input.movement,
            gait: &self.gait,
            norm: self.norm.as_ref(),
            views: &views,
        })?;
        Ok(write_atomically(path, text.as_bytes())?)
    }
}

fn norm_of(asked: &Asked<'_>) -> Result<Option<Norm>, CliError> {
    let mut norm = match asked.norm {
        Some("none") => return Ok(None),
        Some(path) => load_norm(Path::new(path))?,
        None => parse_norm(SHIPPED_NORM.1, Path::new(SHIPPED_NORM.0))?,
    };
    // a laboratory's own parameters stay
    if let ((Some(age_years), sex), true) = (asked.person, norm.parameters.is_empty()) {
        add_parameters(&mut norm, age_years, sex)?;
    }
    Ok(Some(norm))
}

/// What the person says who makes a report.
#[derive(Debug, Args)]
pub(super) struct IdentityArguments {
    /// Who was recorded, as the report shall name them
    #[arg(long, value_name = "TEXT")]
    subject: Option<String>,
    /// Their age, completed years: steps and strides are compared with people of that age
    #[arg(long, value_name = "YEARS")]
    age: Option<u32>,
    /// Their sex, for the same
    #[arg(long, value_enum)]
    sex: Option<SaidSex>,
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

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum SaidSex {
    Female,
    Male,
}

impl From<SaidSex> for Sex {
    fn from(said: SaidSex) -> Self {
        match said {
            SaidSex::Female => Self::Female,
            SaidSex::Male => Self::Male,
        }
    }
}

impl IdentityArguments {
    /// Age and sex.
    pub(super) fn person(&self) -> (Option<u32>, Option<Sex>) {
        (self.age, self.sex.map(Sex::from))
    }

    fn subject(&self, from: &Path) -> Subject {
        let path = self.recording.as_deref().unwrap_or(from);
        let name = path.file_name().map(|n| n.to_string_lossy().into_owned());
        Subject {
            recording: name.unwrap_or_else(|| path.display().to_string()),
            name: self.subject.clone(),
            age_years: self.age,
            sex: self.sex.map(Sex::from),
            date: self.date.clone(),
            condition: self.condition.clone(),
        }
    }
}

/// The outlines of all masks, camera by camera, each looking where the fit found it to look.
fn views(
    folder: &Path,
    input: &GaitInput,
    result: Option<&ResultFile>,
) -> Result<Vec<CameraOutlines>, CliError> {
    let mut recording = Recording::open(folder)?
        .with_fps(input.movement.rate_hz)
        .observations()?;
    if let Some(result) = result {
        recording.rig = recording.rig.aimed(&result.aims_px(&recording.rig));
    }
    let first = input.movement.first_frame;
    let frames: Vec<FrameIndex> = (0..input.movement.frames)
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
