//! Who was recorded: for the report, and for the norm of steps and strides.

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use maquette::io::gait::Sex;
use maquette::report::Subject;
use maquette::workflow::NormChoice;
use maquette::{GaitStudy, Recording};

use crate::error::CliError;

/// Who was recorded, and how, for the report and for whom a walk is compared with.
#[derive(Debug, Args)]
pub(super) struct SubjectArguments {
    /// Who was recorded, as the report should name them
    #[arg(long, value_name = "TEXT")]
    subject: Option<String>,
    /// Their age in completed years, which chooses the norm of steps and strides
    #[arg(long, value_name = "YEARS")]
    age: Option<u32>,
    /// Their sex, which does too
    #[arg(long, value_enum)]
    sex: Option<SexArgument>,
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
enum SexArgument {
    Female,
    Male,
}

impl From<SexArgument> for Sex {
    fn from(sex: SexArgument) -> Self {
        match sex {
            SexArgument::Female => Self::Female,
            SexArgument::Male => Self::Male,
        }
    }
}

impl SubjectArguments {
    /// The study compared with a norm: a file, `none`, or the shipped one.
    pub(super) fn compare(
        &self,
        study: GaitStudy,
        norm: Option<&str>,
    ) -> Result<GaitStudy, CliError> {
        let norm = match norm {
            None => NormChoice::Shipped,
            Some("none") => NormChoice::None,
            Some(path) => NormChoice::File(Path::new(path)),
        };
        Ok(study.compared_with(norm, self.age, self.sex.map(Sex::from))?)
    }

    /// The report of a study that was made from this folder or file.
    pub(super) fn report(&self, study: &GaitStudy, from: &Path) -> Result<String, CliError> {
        let subject = self.subject(from);
        Ok(match &self.recording {
            Some(folder) => study.report_with_views(&subject, &Recording::open(folder)?)?,
            None => study.report(&subject)?,
        })
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
