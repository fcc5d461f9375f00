//! Who was recorded: for the report, and for the norm of steps and strides.

use std::path::{Path, PathBuf};

use clap::Args;
use maquette::gait::Footwear;
use maquette::io::folder::origin;
use maquette::io::gait::Sex;
use maquette::pipeline::Progress;
use maquette::report::{Language, Subject};
use maquette::workflow::{EventChoice, NormChoice, ReportedRecording};
use maquette::{GaitStudy, Recording};

use crate::choice::{Choice, one_of};
use crate::error::CliError;

/// Who was recorded, and how, for the report and for whom a walk is compared with.
#[derive(Debug, Args)]
pub(super) struct SubjectArguments {
    /// Who was recorded, as the report should name them
    #[arg(long, value_name = "TEXT")]
    subject: Option<String>,
    /// Their age in completed years, which chooses the norms
    #[arg(long, value_name = "YEARS")]
    age: Option<u32>,
    /// Their sex, which chooses the norm of steps and strides with it
    #[arg(long, value_parser = one_of(SEXES))]
    sex: Option<Sex>,
    /// When it was recorded
    #[arg(long, value_name = "TEXT")]
    date: Option<String>,
    /// With an orthosis, on a slope, …
    #[arg(long, value_name = "TEXT")]
    condition: Option<String>,
    /// They stand still in it: a fit of the same body, or a .trc of the same markers. Angles are counted from that pose
    #[arg(long, value_name = "FOLDER|FILE")]
    neutral: Option<PathBuf>,
    /// What they wore on their feet; a norm of other footwear is compared with a caution
    #[arg(long, value_parser = one_of(FOOTWEAR))]
    footwear: Option<Footwear>,
    /// The recording that was fitted, which shows what the cameras saw [default: where the fit found it]
    #[arg(long, value_name = "FOLDER")]
    recording: Option<PathBuf>,
    /// Show the outlines of the person without the recorded pictures
    #[arg(long)]
    no_pictures: bool,
}

const SEXES: &[Choice<Sex>] = &[("female", Sex::Female, ""), ("male", Sex::Male, "")];

pub(super) const FOOTWEAR: &[Choice<Footwear>] =
    &[("barefoot", Footwear::Barefoot, ""), ("shoes", Footwear::Shoes, "")];

/// A file, `none`, or the shipped norm.
pub(super) fn norm_choice(norm: Option<&str>) -> NormChoice<'_> {
    match norm {
        None => NormChoice::Shipped,
        Some("none") => NormChoice::None,
        Some(path) => NormChoice::File(Path::new(path)),
    }
}

/// Who says when feet strike and leave.
#[derive(Debug, Args)]
pub(super) struct EventArguments {
    /// Foot strikes and foot offs as a person corrected them, or none [default: events.json of OUT, if it is there]
    #[arg(long, value_name = "FILE|none")]
    events: Option<PathBuf>,
}

impl EventArguments {
    pub(super) fn choice(&self) -> EventChoice<'_> {
        match self.events.as_deref() {
            None => EventChoice::Beside,
            Some(path) if path == "none" => EventChoice::Detected,
            Some(path) => EventChoice::File(path),
        }
    }
}

impl SubjectArguments {
    /// The first argument that says who was recorded, or shows them.
    pub(super) fn given(&self) -> Option<&'static str> {
        let all = [
            ("--subject", self.subject.is_some()),
            ("--age", self.age.is_some()),
            ("--sex", self.sex.is_some()),
            ("--date", self.date.is_some()),
            ("--condition", self.condition.is_some()),
            ("--neutral", self.neutral.is_some()),
            ("--footwear", self.footwear.is_some()),
            ("--recording", self.recording.is_some()),
        ];
        all.into_iter().find(|(_, is_given)| *is_given).map(|(name, _)| name)
    }

    /// The study with angles from the standing pose, if there is one, compared with a norm: a file, `none`, or the shipped one.
    pub(super) fn compare(
        &self,
        study: GaitStudy,
        norm: Option<&str>,
    ) -> Result<GaitStudy, CliError> {
        let study = match &self.neutral {
            Some(standing) => study.counted_from_standing(standing)?,
            None => study,
        };
        Ok(study.compared_with(norm_choice(norm), self.age, self.sex)?)
    }

    /// The report of a study that was made from this folder or file.
    pub(super) fn report(
        &self,
        study: &GaitStudy,
        from: &Path,
        language: Language,
        progress: &dyn Progress,
    ) -> Result<String, CliError> {
        let with_views = |recording: &Path| {
            let shown = ReportedRecording {
                recording: &Recording::open(recording)?,
                out: from,
                pictures: !self.no_pictures,
                progress,
            };
            Ok(study.report_with_views(&self.subject(recording), shown, language)?)
        };
        if let Some(path) = &self.recording {
            return with_views(path);
        }

        // the recording that the fit was made from, if it is still there
        let Some(path) = origin::read(from) else {
            return Ok(study.report(&self.subject(from), language)?);
        };
        match with_views(&path) {
            Ok(text) => Ok(text),
            Err::<_, CliError>(fault) => {
                progress.note(&format!("the report is without camera views: {fault}"));
                Ok(study.report(&self.subject(&path), language)?)
            }
        }
    }

    /// What they wore, as stated.
    pub(super) fn footwear(&self) -> Option<Footwear> {
        self.footwear
    }

    fn subject(&self, recording: &Path) -> Subject {
        let whole = recording.canonicalize().unwrap_or_else(|_| recording.into());
        let name = whole.file_name().map(|n| n.to_string_lossy().into_owned());
        Subject {
            recording: name.unwrap_or_else(|| recording.display().to_string()),
            name: self.subject.clone(),
            age_years: self.age,
            sex: self.sex,
            date: self.date.clone(),
            condition: self.condition.clone(),
            footwear: self.footwear(),
        }
    }
}
