//! Why a session cannot be made.

use crate::workflow::Error;

/// Why a session cannot be made.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SessionError {
    /// A trial that cannot be fitted.
    #[error("trial {name}: {source}")]
    Trial {
        /// Its name.
        name: String,
        /// Why.
        source: Box<Error>,
    },
    /// A trial whose fit cannot be used.
    #[error(
        "trial {name}: {why}; what the other trials were found to be is kept: leave it out with --resume --without {name}"
    )]
    Unusable {
        /// Its name.
        name: String,
        /// Its verdict.
        why: String,
    },
    /// A trial that has no joint optimum.
    #[error(
        "trial {name}: it was fitted without the joint optimum, which all trials of a session share"
    )]
    NotJoint {
        /// Its name.
        name: String,
    },
    /// Trials of two body models.
    #[error(
        "trial {first} is fitted with the body {body}, trial {second} with {other}: give one with --body"
    )]
    TwoBodies {
        /// A trial.
        first: String,
        /// Its body.
        body: String,
        /// Another trial.
        second: String,
        /// Its body.
        other: String,
    },
    /// A trial that there is not.
    #[error("--without {name}: no trial has that name: there are {known}")]
    NoTrial {
        /// As asked for.
        name: String,
        /// The names there are.
        known: String,
    },
    /// Two sessions of two people.
    #[error("the two sessions are of two people, {first} and {second}: what differs is no change")]
    OtherPerson {
        /// As the first says.
        first: String,
        /// As the second says.
        second: String,
    },
    /// Angles from a standing pose, and angles from anatomical axes.
    #[error(
        "{standing} has a standing trial, {other} has none: their angles are counted from another zero; make {standing} again with --resume --without its standing trial"
    )]
    OtherZero {
        /// A session.
        standing: String,
        /// The other.
        other: String,
    },
    /// Two sessions without a number that both have.
    #[error("the two sessions have no number in common: neither strides nor angles are in both")]
    NothingInCommon,
    /// One session, whose trials are not of two conditions.
    #[error(
        "{name}: a session alone is compared by the conditions of its trials: expected two, found {found}; name two with --conditions, or give each \
         [[trial]] of session.toml its condition"
    )]
    Conditions {
        /// Its name.
        name: String,
        /// The conditions there are.
        found: String,
    },
    /// A condition that no trial has.
    #[error("--conditions {condition}: no trial has that condition: there are {known}")]
    NoCondition {
        /// As asked for.
        condition: String,
        /// Those there are.
        known: String,
    },
    /// One condition beside itself.
    #[error("--conditions {condition} {condition}: expected two that differ")]
    SameCondition {
        /// As asked for.
        condition: String,
    },
    /// No trial.
    #[error("--without leaves no walk of all trials")]
    NothingLeft,
}
