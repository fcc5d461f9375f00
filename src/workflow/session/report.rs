//! The report of a session and of a comparison; with the feature `report`.

use super::{Comparison, SessionStudy};
use crate::gait::Side;
use crate::gait::trials::Sides;
use crate::io::session::SessionFile;
use crate::report::{
    Compared, ComparisonInput, Language, ReportInput, ReportedTrial, SessionInput, Subject, Views,
    Words, comparison_html, session_html,
};
use crate::workflow::Error;

impl SessionStudy {
    /// Who walked, as the report states it.
    pub fn subject(&self) -> Subject {
        let file = self.file.as_ref();
        let person = file.map(|file| file.person.clone()).unwrap_or_default();
        Subject {
            recording: self.name.clone(),
            name: person.id,
            age_years: file.and_then(SessionFile::age_years),
            sex: person.sex,
            date: file.and_then(|file| file.date).map(|date| date.to_string()),
            condition: file.and_then(|file| file.condition.clone()),
            footwear: person.footwear,
        }
    }

    /// The report of a session: one HTML page that needs nothing else. That of one fit is its own.
    ///
    /// # Errors
    /// [`Error::Json`], if the serialiser has any.
    pub fn report(&self, language: Language) -> Result<String, Error> {
        let subject = self.subject();
        let (Some(file), Some(pooled)) = (&self.file, self.pooled()) else {
            let study = self.trials.first().map(|(_, study)| study.report(&subject, language));
            return study.unwrap_or_else(|| Ok(String::new()));
        };
        let (views, spreads, words) = (Views::default(), self.spreads(), Words::new(language));
        let trials: Vec<ReportedTrial<'_>> = self
            .trials
            .iter()
            .map(|(name, study)| ReportedTrial {
                name,
                input: ReportInput {
                    subject: &subject,
                    result: study.result.as_ref(),
                    body: study.input.body.as_ref(),
                    movement: &study.input.movement,
                    gait: &study.analysis,
                    norm: study.norm.as_ref(),
                    views: &views,
                    words: &words,
                },
            })
            .collect();
        Ok(session_html(&SessionInput {
            subject: &subject,
            file,
            trials: &trials,
            pooled: &pooled,
            spreads: &spreads,
            norm: self.norm(),
        })?)
    }
}

impl Comparison {
    /// The comparison as one HTML page that needs nothing else.
    pub fn report(&self, language: Language) -> String {
        let sides = [&self.before, &self.after];
        let subjects = sides.map(SessionStudy::subject);
        let [Some(before), Some(after)] = sides.map(SessionStudy::pooled) else {
            return String::new();
        };
        let names = match self.sides {
            Sides::Same => sides.map(|study| study.name.as_str()),
            Sides::Opposite => Side::BOTH.map(Side::name),
        };
        let [a, b] = [0, 1].map(|k| (names[k], sides[k].trials.len()));
        comparison_html(&ComparisonInput {
            before: Compared { name: a.0, subject: &subjects[0], trials: a.1, gait: &before },
            after: Compared { name: b.0, subject: &subjects[1], trials: b.1, gait: &after },
            sides: self.sides,
            changes: &self.changes,
            curves: &self.curves,
            one_body: &self.one_body,
            notes: &self.notes,
            norm: self.after.norm(),
            words: &Words::new(language),
        })
    }
}
