//! Two sessions of one person compared, or two conditions or the two sides of one session.
//!
//! The trials of a session have one body. What the fit has wrong with it, most of its standard deviation u, is wrong in both conditions alike
//! and cancels in their difference: only trials say how far a change may be chance. Of two sessions, each with a body of its own, u counts twice.

use std::collections::BTreeMap;

use super::SessionStudy;
use crate::gait::Zero;
use crate::gait::trials::{
    Change, CurveChange, LEAST_TRIALS, Measure, Sides, Spread, changes, curve_changes,
    side_differences,
};
use crate::io::gait::{changes_csv, curve_changes_csv};
use crate::pipeline::OneBody;
use crate::workflow::{Error, SessionError};

/// Two sessions of one person, two recordings, or two conditions or the two sides of a session, and what differs between them.
#[derive(Debug)]
pub struct Comparison {
    /// The first.
    pub before: SessionStudy,
    /// The second; of sides the same.
    pub after: SessionStudy,
    /// Which side is compared with which.
    pub sides: Sides,
    /// Every number that both have.
    pub changes: Vec<Change>,
    /// Where over the cycle curves differ, of every curve that both sessions have in three trials or more.
    pub curves: Vec<CurveChange>,
    /// Whether the lengths of both can be those of one body.
    pub one_body: OneBody,
    /// What else a person should know, each in one line.
    pub notes: Vec<String>,
}

impl Comparison {
    /// What changed from one session to another.
    ///
    /// # Errors
    /// [`SessionError::OtherPerson`] if both name a person and not the same, [`SessionError::OtherZero`] if only one has a standing trial,
    /// and [`SessionError::NothingInCommon`].
    pub fn new(before: SessionStudy, mut after: SessionStudy) -> Result<Self, Error> {
        let id = |study: &SessionStudy| study.file.as_ref()?.person.id.clone();
        if let (Some(first), Some(second)) = (id(&before), id(&after))
            && first != second
        {
            return Err(SessionError::OtherPerson { first, second }.into());
        }
        match (before.zero(), after.zero()) {
            (Zero::Standing, Zero::Anatomical) => return Err(other_zero(&before, &after)),
            (Zero::Anatomical, Zero::Standing) => return Err(other_zero(&after, &before)),
            _ => {}
        }
        // a person who has aged from one norm into another is compared with one of them
        let has_other_norm = after.norm() != before.norm();
        if has_other_norm {
            let norm = before.norm().cloned();
            after.trials.iter_mut().for_each(|(_, study)| study.norm.clone_from(&norm));
        }

        let changes = changes(&before.spreads(), &after.spreads());
        let mut notes = notes(&before, &after);
        if has_other_norm {
            notes.push(format!("both are compared with the norm of the age in {}", before.name));
        }
        let one_body = before.one_body_with(&after);
        let (sides, curves) = (Sides::Same, Vec::new());
        Self { before, after, sides, changes, curves, one_body, notes }.with_curves()
    }

    /// What differs between two conditions of the trials of a session; between the only two, if none are named.
    ///
    /// # Errors
    /// [`SessionError::Conditions`], [`SessionError::NoCondition`], [`SessionError::SameCondition`] and [`SessionError::NothingInCommon`].
    pub fn of_conditions(session: &SessionStudy, named: Option<[&str; 2]>) -> Result<Self, Error> {
        let known = session.conditions();
        let listed = || if known.is_empty() { "none".into() } else { known.join(", ") };
        let [first, second] = match (named, known.as_slice()) {
            (Some(named), _) => named,
            (None, [first, second]) => [first.as_str(), second],
            (None, _) => {
                let (name, found) = (session.name.clone(), listed());
                return Err(SessionError::Conditions { name, found }.into());
            }
        };
        let unknown = [first, second].into_iter().find(|name| !known.iter().any(|k| k == name));
        if let Some(condition) = unknown {
            let (condition, known) = (condition.into(), listed());
            return Err(SessionError::NoCondition { condition, known }.into());
        }
        if first == second {
            return Err(SessionError::SameCondition { condition: first.into() }.into());
        }

        let [before, after] = [first, second].map(|name| session.of_condition(name));
        let changes = changes(&of_trials_alone(&before), &of_trials_alone(&after));
        let mut notes = notes(&before, &after);
        notes.push("both are of one session and have one body: what the fit has wrong with it cancels, if clothes and shoes are the same in both".into());
        let (sides, curves, one_body) = (Sides::Same, Vec::new(), OneBody::Yes);
        Self { before, after, sides, changes, curves, one_body, notes }.with_curves()
    }

    /// How the right side differs from the left in the trials of a session.
    ///
    /// # Errors
    /// [`SessionError::NothingInCommon`].
    pub fn of_sides(session: &SessionStudy) -> Result<Self, Error> {
        let [before, after] = [session.clone(), session.clone()];
        let changes = side_differences(&session.spreads());
        let mut notes = vec![
            "both sides of the body are fitted alike: of legs that are not equally long, half of the difference is taken for motion".to_owned(),
            "what cameras see of one side and not of the other is off in the same way in every trial: intervals hold the fit's own SD of each side, and curves are not tested".to_owned(),
        ];
        if session.trials.len() == 1 {
            notes.push("one trial: how far trials differ by chance is not known, so no interval and no minimal detectable change can be given".into());
        }
        if changes.is_empty() {
            return Err(SessionError::NothingInCommon.into());
        }
        let (sides, curves, one_body) = (Sides::Opposite, Vec::new(), OneBody::Yes);
        Ok(Self { before, after, sides, changes, curves, one_body, notes })
    }

    /// Tests whole curves.
    fn with_curves(mut self) -> Result<Self, Error> {
        if self.changes.is_empty() {
            return Err(SessionError::NothingInCommon.into());
        }
        let [a, b] = [&self.before, &self.after].map(SessionStudy::curves);
        let curves = curve_changes(&a, &b);
        if curves.is_empty() {
            self.notes.push(format!(
                "whole curves are not tested: that needs {LEAST_TRIALS} trials or more in each session"
            ));
        }
        Ok(Self { curves, ..self })
    }

    /// That the two have two bodies, in one line; `None` where they have one, or that is not known.
    pub fn two_bodies(&self) -> Option<String> {
        let OneBody::No(odd) = &self.one_body else {
            return None;
        };
        let [m, nu] = odd.degrees;
        Some(format!(
            "the bodies differ: {} {:.3} m in {}, {:.3} m in {} (all lengths: F({m}, {nu}) = {:.0}): two people, a person who has \
             grown, or a calibration of another scale; no change below is to be trusted before that is known",
            odd.length.replace('_', " "),
            odd.others_m,
            self.before.name,
            odd.own_m,
            self.after.name,
            odd.f
        ))
    }

    /// All that a person should know, each in one line.
    pub fn lines(&self) -> Vec<String> {
        self.two_bodies().into_iter().chain(self.notes.iter().cloned()).collect()
    }

    /// Where curves differ, as comma-separated values: a row for each stretch of the cycle, and one for each curve without any.
    ///
    /// # Errors
    /// As [`csv`](Self::csv).
    pub fn curves_csv(&self) -> Result<Vec<u8>, Error> {
        Ok(curve_changes_csv(&self.curves)?)
    }

    /// The table of differences as comma-separated values, a row for each number and side.
    ///
    /// # Errors
    /// [`Error::Table`], if the writer has any.
    pub fn csv(&self) -> Result<Vec<u8>, Error> {
        Ok(changes_csv(&self.changes, self.sides, &self.one_body)?)
    }
}

fn other_zero(standing: &SessionStudy, other: &SessionStudy) -> Error {
    let (standing, other) = (standing.name.clone(), other.name.clone());
    SessionError::OtherZero { standing, other }.into()
}

/// Every number with how far its trials vary, and no u.
fn of_trials_alone(study: &SessionStudy) -> BTreeMap<Measure, Spread> {
    let spreads = study.spreads().into_iter();
    spreads.map(|(measure, spread)| (measure, Spread { fit: None, ..spread })).collect()
}

fn notes(before: &SessionStudy, after: &SessionStudy) -> Vec<String> {
    let mut notes = Vec::new();
    match (before.trials.len(), after.trials.len()) {
        (1, 1) => notes.push(
            "one trial each: how far trials differ by chance is not known, so no interval and no minimal detectable change can be given".into(),
        ),
        (1, _) => notes.push(format!("{} has one trial: it is taken to vary as {} does", before.name, after.name)),
        (_, 1) => notes.push(format!("{} has one trial: it is taken to vary as {} does", after.name, before.name)),
        _ => {}
    }
    let footwear = |study: &SessionStudy| study.file.as_ref()?.person.footwear;
    if let (Some(a), Some(b)) = (footwear(before), footwear(after))
        && a != b
    {
        notes.push(format!(
            "{} was walked {}, {} {}: shoes alone change steps and ankle angles",
            before.name,
            a.words(),
            after.name,
            b.words()
        ));
    }
    for study in [before, after] {
        let is_own = |trial: &String| study.trials.iter().any(|(name, _)| name == trial);
        let odd = study.file.iter().flat_map(|file| &file.disagreements);
        let odd = odd.filter(|odd| is_own(&odd.trial));
        notes.extend(odd.map(|odd| format!("{}: {}", study.name, odd.line)));
    }
    notes
}
