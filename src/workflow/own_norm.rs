//! A norm of one's own, of the fits and sessions of healthy people.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use super::session::SessionStudy;
use super::{Error, NormChoice};
use crate::gait::{Footwear, GaitAnalysis, LEAST_PEOPLE, Norm, OfPeople, Zero, of_people};
use crate::io::folder::origin;

/// People whose norm is made.
#[derive(Debug, Clone, Copy)]
pub struct NormPeople<'a> {
    /// A session, fit or TRC file of each.
    pub paths: &'a [PathBuf],
    /// The body model of all, if it is not a shipped one.
    pub body: Option<&'a str>,
    /// What those wore who do not state it.
    pub footwear: Option<Footwear>,
    /// What the norm is called.
    pub name: &'a str,
}

/// Why no norm can be made.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum OwnNormError {
    /// Too few people.
    #[error(
        "a norm needs three people or more, for its standard deviation is that between people: {found} given"
    )]
    TooFew {
        /// How many there are.
        found: usize,
    },
    /// One person twice.
    #[error("{first} and {second} are of the same {what}: a norm takes each person once")]
    Twice {
        /// A path.
        first: String,
        /// Another one.
        second: String,
        /// person or recording.
        what: &'static str,
    },
    /// Footwear that differs.
    #[error("{first} was walked {worn}, {second} {other}: a norm is of one footwear")]
    Footwear {
        /// A path.
        first: String,
        /// In words.
        worn: &'static str,
        /// Another path.
        second: String,
        /// In words.
        other: &'static str,
    },
    /// Angles from a standing pose, and angles from anatomical axes.
    #[error(
        "{first} has a standing trial, {second} has none: a norm counts the angles of all its people from one zero"
    )]
    Zero {
        /// A path.
        first: String,
        /// Another path.
        second: String,
    },
    /// A walk that cannot be used.
    #[error("{path}: {why}")]
    Unusable {
        /// Whose.
        path: String,
        /// Why.
        why: String,
    },
    /// Nothing that enough people have.
    #[error("no angle and no parameter is known of {LEAST_PEOPLE} people or more")]
    NothingInCommon,
}

impl NormPeople<'_> {
    /// Mean and standard deviation between these people, as a norm.
    ///
    /// # Errors
    /// [`OwnNormError`], and of each person as [`SessionStudy::open`].
    pub fn norm(&self) -> Result<Norm, Error> {
        let found = self.paths.len();
        if found < LEAST_PEOPLE {
            return Err(OwnNormError::TooFew { found }.into());
        }
        let open = |path: &PathBuf| SessionStudy::open(path, self.body, NormChoice::None);
        let people = self.paths.iter().map(open).collect::<Result<Vec<_>, _>>()?;
        each_once(&people)?;
        let footwear = self.one_footwear(&people)?;

        let mut walks = Vec::with_capacity(found);
        for person in &people {
            walks.push(usable(person)?);
        }
        let zero = one_zero(&people)?;
        let common = of_people(&walks);
        if common.curves.is_empty() && common.parameters.is_empty() {
            return Err(OwnNormError::NothingInCommon.into());
        }
        Ok(Norm { zero, ..self.named(common, &people, footwear) })
    }

    fn named(&self, common: OfPeople, people: &[SessionStudy], footwear: Option<Footwear>) -> Norm {
        let all = people.len();
        let ages: Option<Vec<u32>> =
            people.iter().map(|person| person.file.as_ref()?.age_years()).collect();
        let ages = ages.and_then(|ages| Some([*ages.iter().min()?, *ages.iter().max()?]));
        let mut remarks = Vec::new();
        for (angle, (_, n)) in common.curves.iter().filter(|(_, (_, n))| *n < all) {
            remarks.push(format!("{}: of {n} of its {all} people", angle.name()));
        }
        for (parameter, (.., n)) in common.parameters.iter().filter(|(_, (.., n))| *n < all) {
            remarks.push(format!("{}: of {n} of its {all} people", parameter.name()));
        }
        let bodies = bodies(people);
        if bodies.len() > 1 {
            let bodies = bodies.into_iter().collect::<Vec<_>>().join(", ");
            remarks.push(format!("its people were measured by several bodies, {bodies}, between which angles have offsets"));
        }
        Norm {
            name: self.name.into(),
            source: format!("{all} people"),
            ages,
            remarks,
            footwear,
            parameters_footwear: footwear,
            curves: common.curves.into_iter().map(|(angle, (band, _))| (angle, band)).collect(),
            parameters: common
                .parameters
                .into_iter()
                .map(|(p, (mean, sd, _))| (p, (mean, sd)))
                .collect(),
            ..Norm::default()
        }
    }

    /// What all wore; `None` where nobody says so.
    fn one_footwear(&self, people: &[SessionStudy]) -> Result<Option<Footwear>, OwnNormError> {
        let worn = |person: &SessionStudy| {
            person.file.as_ref().and_then(|file| file.person.footwear).or(self.footwear)
        };
        let Some(first) = people.first() else { return Ok(None) };
        for second in people {
            if worn(first) != worn(second) {
                let words = |person| {
                    worn(person).map_or("in nobody knows what (--footwear)", Footwear::words)
                };
                return Err(OwnNormError::Footwear {
                    first: shown(&first.path),
                    worn: words(first),
                    second: shown(&second.path),
                    other: words(second),
                });
            }
        }
        Ok(worn(first))
    }
}

/// The analyses of a person's trials.
fn usable(person: &SessionStudy) -> Result<Vec<&GaitAnalysis>, OwnNormError> {
    for (_, study) in &person.trials {
        if let Err(fault) = study.usable() {
            let (path, why) = (shown(&person.path), fault.to_string());
            return Err(OwnNormError::Unusable { path, why });
        }
    }
    Ok(person.trials.iter().map(|(_, study)| &study.analysis).collect())
}

/// What the angles of all are counted from.
fn one_zero(people: &[SessionStudy]) -> Result<Zero, OwnNormError> {
    let of = |wanted| people.iter().find(|person| person.zero() == wanted);
    match (of(Zero::Standing), of(Zero::Anatomical)) {
        (Some(first), Some(second)) => {
            let (first, second) = (shown(&first.path), shown(&second.path));
            Err(OwnNormError::Zero { first, second })
        }
        (Some(_), None) => Ok(Zero::Standing),
        (None, _) => Ok(Zero::Anatomical),
    }
}

fn bodies(people: &[SessionStudy]) -> BTreeSet<String> {
    let trials = people.iter().flat_map(|person| &person.trials);
    trials.filter_map(|(_, study)| Some(study.result.as_ref()?.body.clone())).collect()
}

/// Refuses a person who is there twice: by the id of the session, else by the recordings.
fn each_once(people: &[SessionStudy]) -> Result<(), OwnNormError> {
    for (i, first) in people.iter().enumerate() {
        for second in &people[i + 1..] {
            let id = |person: &'_ SessionStudy| person.file.as_ref()?.person.id.clone();
            let what = match (id(first), id(second)) {
                (Some(a), Some(b)) if a == b => "person",
                _ if !recordings(first).is_disjoint(&recordings(second)) => "recording",
                _ => continue,
            };
            let (first, second) = (shown(&first.path), shown(&second.path));
            return Err(OwnNormError::Twice { first, second, what });
        }
    }
    Ok(())
}

/// Where a person's recordings are: those that the fits name, and the place of the person itself.
fn recordings(person: &SessionStudy) -> BTreeSet<PathBuf> {
    let trials = person.file.iter().flat_map(|file| &file.trials);
    let fits = trials.map(|trial| person.path.join(&trial.folder)).chain([person.path.clone()]);
    let whole = |path: PathBuf| path.canonicalize().unwrap_or(path);
    fits.flat_map(|fit| [origin::read(&fit), Some(fit)]).flatten().map(whole).collect()
}

fn shown(path: &Path) -> String {
    path.display().to_string()
}
