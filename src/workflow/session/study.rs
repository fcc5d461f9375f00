//! The gait of a session: of each trial, of all together, and how far numbers vary.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use nalgebra::DMatrix;

use super::FittedSession;
use crate::gait::trials::{Measure, Measured, NamedTrial, Spread, measured, pooled, spreads};
use crate::gait::{Curve, GaitAnalysis, GaitOptions, NeutralPose, Norm, Zero};
use crate::io::gait::variation_csv;
use crate::io::session::{SESSION, SessionFile, TrialPart};
use crate::pipeline::{FittedBody, OneBody, one_body};
use crate::workflow::{Error, EventChoice, GaitSource, GaitStudy, NormChoice};

/// How somebody walks in the trials of one session, or in one recording.
#[derive(Debug, Clone)]
pub struct SessionStudy {
    /// The name of its folder.
    pub name: String,
    /// Where it is.
    pub path: PathBuf,
    /// The session; `None` of one fit, or of points.
    pub file: Option<SessionFile>,
    /// Walk by walk: the name of the trial, and its analysis. Standing trials are the zero of their angles.
    pub trials: Vec<(String, GaitStudy)>,
}

impl SessionStudy {
    /// Whether a folder is that of a session.
    pub fn is_session(path: &Path) -> bool {
        path.join(SESSION).is_file()
    }

    /// Analyses the gait of every trial of a session, or of one fit or TRC, against a norm and people of their age. `body` is the
    /// model, if it is not a shipped one.
    ///
    /// # Errors
    /// [`Error::SessionFile`], and of each trial as [`GaitStudy::open`]; a trial without gait is named.
    pub fn open(path: &Path, body: Option<&str>, norm: NormChoice<'_>) -> Result<Self, Error> {
        let whole = path.canonicalize().unwrap_or_else(|_| path.into());
        let name = whole.file_name().map(|name| name.to_string_lossy().into_owned());
        let (name, options) = (name.unwrap_or_default(), GaitOptions::default());
        if !Self::is_session(path) {
            let source = GaitSource { path, body, fps: None, events: EventChoice::Beside };
            let study = GaitStudy::open(source, &options)?;
            let study = study.compared_with(norm, None, None)?;
            let trials = vec![(name.clone(), study)];
            return Ok(Self { name, path: path.into(), file: None, trials });
        }

        let session = FittedSession::read(path, body)?;
        let (age, sex) = (session.file.age_years(), session.file.person.sex);
        let (mut walks, mut poses) = (Vec::with_capacity(session.trials.len()), Vec::new());
        for (part, fitted) in session.file.trials.iter().zip(&session.trials) {
            let study = fitted
                .gait_in(&path.join(&part.folder), EventChoice::Beside, &options)
                .map_err(|source| super::named(&part.name, source))?;
            match part.standing {
                true => poses.push(study.neutral_pose(&part.name)?),
                false => walks.push((part.name.clone(), study)),
            }
        }

        let pose = NeutralPose::mean_of(&poses);
        let compared = |(name, study): (String, GaitStudy)| {
            let study = match &pose {
                Some(pose) => study.counted_from(pose),
                None => study,
            };
            Ok((name, study.compared_with(norm, age, sex)?))
        };
        let trials = walks.into_iter().map(compared).collect::<Result<_, Error>>()?;
        Ok(Self { name, path: path.into(), file: Some(session.file), trials })
    }

    /// The conditions of its trials, each once, in the order of the trials.
    pub fn conditions(&self) -> Vec<String> {
        let mut conditions: Vec<String> = Vec::new();
        for condition in self.walks().filter_map(|trial| trial.condition.as_ref()) {
            if !conditions.contains(condition) {
                conditions.push(condition.clone());
            }
        }
        conditions
    }

    /// The trials that are no standing pose.
    fn walks(&self) -> impl Iterator<Item = &TrialPart> {
        let trials = self.file.iter().flat_map(|file| &file.trials);
        trials.filter(|trial| !trial.standing)
    }

    /// The trials of one condition, as a session of its name.
    pub(super) fn of_condition(&self, condition: &str) -> Self {
        let parts = self.walks();
        let own = parts.filter(|part| part.condition.as_deref() == Some(condition));
        let own: Vec<&String> = own.map(|part| &part.name).collect();
        let file = self.file.clone();
        Self {
            name: condition.into(),
            path: self.path.clone(),
            file: file.map(|file| SessionFile { condition: Some(condition.into()), ..file }),
            trials: self.trials.iter().filter(|(name, _)| own.contains(&name)).cloned().collect(),
        }
    }

    /// Whether another session has the same body, by the lengths of both.
    pub(super) fn one_body_with(&self, other: &Self) -> OneBody {
        match (self.body(), other.body()) {
            (Some((body, own)), Some((others, other))) if body.model == others.model => {
                one_body(&body.model, (&body.shape, &own), (&others.shape, &other))
            }
            _ => OneBody::Unknown,
        }
    }

    /// The body of all trials, and the covariance of its shape; `None` of points, and of a fit that states none.
    fn body(&self) -> Option<(&FittedBody, DMatrix<f64>)> {
        let (_, study) = self.trials.first()?;
        let body = study.input.body.as_ref()?;
        let covariance = study.result.as_ref()?.shape_covariance()?;
        (covariance.nrows() == body.shape.0.len()).then_some((body, covariance))
    }

    /// Healthy people, whom all trials are compared with.
    pub fn norm(&self) -> Option<&Norm> {
        self.trials.first()?.1.norm.as_ref()
    }

    /// What the angles of its walks are counted from.
    pub fn zero(&self) -> Zero {
        self.trials.first().map_or(Zero::Anatomical, |(_, study)| study.analysis.zero())
    }

    /// The mean curves of each trial.
    pub(super) fn curves(&self) -> Vec<&[Curve]> {
        self.trials.iter().map(|(_, study)| study.analysis.curves.as_slice()).collect()
    }

    /// All strides of all trials, as if of one; `None` without a trial.
    pub fn pooled(&self) -> Option<GaitAnalysis> {
        let named = |(name, study): &'_ (String, GaitStudy)| (name.clone(), study.analysis.clone());
        let all: Vec<(String, GaitAnalysis)> = self.trials.iter().map(named).collect();
        let all: Vec<NamedTrial<'_>> =
            all.iter().map(|(name, gait)| NamedTrial { name, gait }).collect();
        pooled(&all)
    }

    /// How far every number varies between strides and between trials, beside the fit's own standard deviation.
    pub fn spreads(&self) -> BTreeMap<Measure, Spread> {
        let of = |(_, study): &(String, GaitStudy)| measured(&study.analysis, study.norm.as_ref());
        let trials: Vec<Vec<(Measure, Measured)>> = self.trials.iter().map(of).collect();
        spreads(&trials)
    }

    /// The same as comma-separated values, a row for each number and side.
    ///
    /// # Errors
    /// [`Error::Table`], if the writer has any.
    pub fn csv(&self) -> Result<Vec<u8>, Error> {
        let names: Vec<&str> = self.trials.iter().map(|(name, _)| name.as_str()).collect();
        Ok(variation_csv(&names, &self.spreads())?)
    }
}
