//! A gait analysis with what it was made from, of a fit or of points of any system.

use std::path::{Path, PathBuf};

use serde::Serialize;

use super::{Error, FittedRecording};
use crate::gait::{
    GaitAnalysis, GaitOptions, Indices, Movement, NeutralError, NeutralPose, Norm, StatedEvent,
    analyse, analyse_stated, indices,
};
use crate::io::folder::OutFolder;
use crate::io::gait::{
    EVENTS, GaitInput, Sex, add_parameters, angles_csv, curves_csv, from_result, gait_file,
    load_norm, parameters_csv, read_events, read_points, shipped_norm,
};
use crate::io::result::ResultFile;

/// How somebody walks, with what that was found from and what it is compared with.
#[derive(Debug, Clone)]
pub struct GaitStudy {
    /// The movement that was analysed.
    pub input: GaitInput,
    /// The fit; `None` of points.
    pub result: Option<ResultFile>,
    /// Events, strides, parameters, angles, curves. SI units, radians.
    pub analysis: GaitAnalysis,
    /// Healthy people; `None` without a comparison.
    pub norm: Option<Norm>,
}

/// Where a movement is read from.
#[derive(Debug, Clone, Copy)]
pub struct GaitSource<'a> {
    /// The folder of a finished fit, or a TRC file of points of any system.
    pub path: &'a Path,
    /// The body model of the fit, if it is not a shipped one.
    pub body: Option<&'a str>,
    /// Frames per second, in place of what the source states.
    pub fps: Option<f64>,
    /// Foot strikes and foot offs.
    pub events: EventChoice<'a>,
}

/// Who says when feet strike and leave.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum EventChoice<'a> {
    /// A person, by the `events.json` of the fit's folder, which the report's page saves; the program where there is none.
    #[default]
    Beside,
    /// A person, by such a file.
    File(&'a Path),
    /// The program.
    Detected,
}

/// Whom a walk is compared with.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum NormChoice<'a> {
    /// The norm that comes with the library for the person's age.
    #[default]
    Shipped,
    /// A file of one's own.
    File(&'a Path),
    /// Nobody.
    None,
}

/// Why a trial gives no zero for the angles of another.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum StandingError {
    /// A fit and points.
    #[error(
        "{}: a standing pose and a walk are both fits of one body, or both points of one set of markers",
        path.display()
    )]
    OtherKind {
        /// The standing trial.
        path: PathBuf,
    },
    /// Another person.
    #[error(
        "{}: the legs are {there_m:.3} m long there and {here_m:.3} m in the walk: another person, or another scale",
        path.display()
    )]
    OtherPerson {
        /// The standing trial.
        path: PathBuf,
        /// Hip to knee to ankle.
        there_m: f64,
        /// In the walk.
        here_m: f64,
    },
    /// A fit that cannot be used.
    #[error("{name}: {why}")]
    Unusable {
        /// The standing trial.
        name: String,
        /// Why.
        why: String,
    },
    /// Nobody who stands still.
    #[error("{name}: {source}")]
    Neutral {
        /// The standing trial.
        name: String,
        /// Why.
        source: NeutralError,
    },
}

/// Legs that differ by more of their length are not of one person.
const OTHER_LEGS: f64 = 0.05;

impl GaitStudy {
    /// Reads a fit or points of any system and analyses the gait, against the shipped norm.
    ///
    /// # Errors
    /// [`Error::GaitInput`] and [`Error::Result`] name file and line, [`Error::Events`] file and event, [`Error::Gait`] says why
    /// there is no gait.
    ///
    /// ```no_run
    /// # fn main() -> Result<(), maquette::Error> {
    /// use maquette::GaitStudy;
    /// use maquette::gait::GaitOptions;
    /// use maquette::workflow::{EventChoice, GaitSource};
    ///
    /// let path = std::path::Path::new("walk.trc");
    /// let source = GaitSource { path, body: None, fps: None, events: EventChoice::Beside };
    /// let study = GaitStudy::open(source, &GaitOptions::default())?;
    /// println!("{} strides", study.analysis.cycles.len());
    /// # Ok(())
    /// # }
    /// ```
    pub fn open(source: GaitSource<'_>, options: &GaitOptions) -> Result<Self, Error> {
        let (input, result) = match source.path.is_dir() {
            true => {
                let fitted = FittedRecording::read(source.path, source.body)?;
                let input = from_result(&fitted.result, fitted.model, source.fps)?;
                (input, Some(fitted.result))
            }
            false => (read_points(source.path, source.fps)?, None),
        };
        let events = source.events.read(source.path, &input.movement)?;
        Self::new(input, result, events.as_deref(), options)
    }

    /// Whether the fit can be used; points always can.
    ///
    /// # Errors
    /// [`Error::Unusable`] has its verdict if not.
    pub fn usable(&self) -> Result<(), Error> {
        let why = self.result.as_ref().and_then(|result| result.verdict.why_unusable());
        why.map_or(Ok(()), |why| Err(Error::Unusable(why)))
    }

    /// Analyses a movement, with the events that a person states if one does, against the shipped norm; of a fit that cannot be used all numbers are withheld.
    pub(super) fn new(
        input: GaitInput,
        result: Option<ResultFile>,
        events: Option<&[StatedEvent]>,
        options: &GaitOptions,
    ) -> Result<Self, Error> {
        let mut analysis = match events {
            Some(events) => analyse_stated(&input.movement, events, options)?,
            None => analyse(&input.movement, options)?,
        };
        if let Some(why) = result.as_ref().and_then(|result| result.verdict.why_unusable()) {
            analysis = analysis.withheld(why);
        }

        Ok(Self { analysis, norm: NormChoice::Shipped.read(None)?, input, result })
    }

    /// The same with angles from the pose of somebody who stands still, in the folder of a fit by the same body or a TRC file of the same markers.
    ///
    /// # Errors
    /// [`Error::Standing`], and as [`GaitStudy::open`] of that trial.
    pub fn counted_from_standing(self, standing: &Path) -> Result<Self, Error> {
        let path = || standing.to_path_buf();
        let (input, result) = match (&self.input.body, standing.is_dir()) {
            (Some(body), true) => {
                let result = ResultFile::read(standing)?;
                (from_result(&result, body.model.clone(), None)?, Some(result))
            }
            (None, false) => (read_points(standing, None)?, None),
            _ => return Err(StandingError::OtherKind { path: path() }.into()),
        };
        let stands = Self::new(input, result, None, &GaitOptions::default())?;
        let pose = stands.neutral_pose(&standing.display().to_string())?;
        let lengths = stands.analysis.leg_length_m.zip(self.analysis.leg_length_m);
        if let Some((there_m, here_m)) = lengths
            && (there_m / here_m - 1.0).abs() > OTHER_LEGS
        {
            return Err(StandingError::OtherPerson { path: path(), there_m, here_m }.into());
        }
        Ok(self.counted_from(&pose))
    }

    /// How the person of this trial stands.
    ///
    /// # Errors
    /// [`Error::Standing`] if the fit cannot be used or they do not stand still.
    pub(super) fn neutral_pose(&self, name: &str) -> Result<NeutralPose, Error> {
        if let Err(fault) = self.usable() {
            return Err(
                StandingError::Unusable { name: name.into(), why: fault.to_string() }.into()
            );
        }
        let named = |source| StandingError::Neutral { name: name.into(), source };
        Ok(NeutralPose::of(&self.analysis, name).map_err(named)?)
    }

    /// The same with angles from a standing pose.
    pub(super) fn counted_from(self, pose: &NeutralPose) -> Self {
        let analysis = self.analysis.counted_from(pose);
        Self { norm: self.norm.map(|norm| norm.for_zero(analysis.zero())), analysis, ..self }
    }

    /// The same compared with another norm, and its steps and strides with people of this age and sex.
    ///
    /// # Errors
    /// [`Error::Norm`] names the file and what is wrong with it.
    pub fn compared_with(
        self,
        norm: NormChoice<'_>,
        age_years: Option<u32>,
        sex: Option<Sex>,
    ) -> Result<Self, Error> {
        let mut norm = norm.read(age_years)?;
        // a laboratory's own parameters stay
        if let (Some(norm), Some(age)) = (&mut norm, age_years)
            && norm.parameters.is_empty()
        {
            add_parameters(norm, age, sex)?;
        }
        let norm = norm.map(|norm| norm.for_zero(self.analysis.zero()));
        Ok(Self { norm, ..self })
    }

    /// Writes `gait.json`, `parameters.csv`, `curves.csv` and `angles.csv` into a folder, which is made where there is none.
    ///
    /// # Errors
    /// [`Error::Out`] for the file that cannot be written.
    pub fn save(&self, folder: &Path) -> Result<(), Error> {
        let (gait, norm) = (&self.analysis, self.norm.as_ref());
        let out = OutFolder::open(folder)?;
        for (name, bytes) in [
            ("parameters.csv", parameters_csv(gait)?),
            ("curves.csv", curves_csv(gait, norm)?),
            ("angles.csv", angles_csv(gait, &self.input.movement)?),
            ("gait.json", serde_json::to_vec_pretty(&self.file())?),
        ] {
            out.write(name, &bytes)?;
        }
        Ok(())
    }

    /// What `gait.json` holds.
    pub fn file(&self) -> impl Serialize + '_ {
        gait_file(&self.input, &self.analysis, self.norm.as_ref())
    }

    /// How far the angles lie from those of healthy people; `None` without a norm, or an angle of it.
    pub fn indices(&self) -> Option<Indices> {
        indices(&self.analysis.curves, self.norm.as_ref()?)
    }
}

impl EventChoice<'_> {
    /// The events that a person states of a movement, which is that of a fit's folder or of points; `None`: the program finds them.
    pub(super) fn read(
        self,
        source: &Path,
        movement: &Movement,
    ) -> Result<Option<Vec<StatedEvent>>, Error> {
        let beside = source.join(EVENTS);
        Ok(match self {
            Self::File(path) => Some(read_events(path, movement)?),
            Self::Beside if beside.exists() => Some(read_events(&beside, movement)?),
            Self::Beside | Self::Detected => None,
        })
    }
}

impl NormChoice<'_> {
    fn read(self, age_years: Option<u32>) -> Result<Option<Norm>, Error> {
        Ok(match self {
            Self::Shipped => Some(shipped_norm(age_years)?),
            Self::File(path) => Some(load_norm(path)?),
            Self::None => None,
        })
    }
}
