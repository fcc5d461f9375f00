//! Settings of the joint optimum.

use crate::inference::step::MotionModel;
use crate::inference::{Look, SequenceTerms};

/// Steps in each of the rounds before the last, after which E falls by less than a hundredth.
const APPROACH: [usize; 2] = [4, 6];

/// Settings of the joint optimum.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct JointOptions {
    /// Steps at most in the last round.
    pub iterations: usize,
    /// How a motion follows the others.
    pub motion_model: MotionModel,
    /// Which rounds are made.
    pub rounds: Rounds,
    /// Whether it counts beside the outlines what cameras side by side see differently.
    pub differences: Differences,
}

/// Whether what cameras side by side see differently counts by itself ([`contrasts`](crate::inference::contrasts)).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Differences {
    /// As they err.
    #[default]
    Counted,
    /// Outlines that were drawn from one body in all cameras differ as that body's do: fitted to them by turns, the body would follow
    /// itself.
    LeftOut,
}

/// Rounds of a few steps before a part of the border points, and a last one of many steps.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Rounds {
    /// From Algorithm 1's winner to the optimum before all border points.
    #[default]
    All,
    /// To the optimum before a part of the border points: from there the optimum of several trials starts.
    Thinned,
    /// From such an optimum to that before all border points: one round fewer.
    FromThinned,
}

impl Rounds {
    /// The most steps of each round before the last.
    pub(super) fn approach(self) -> &'static [usize] {
        match self {
            Self::All => &APPROACH,
            Self::Thinned | Self::FromThinned => &APPROACH[..1],
        }
    }

    /// What the last round looks at.
    pub(super) fn last<'t, 'f>(self, terms: &'t SequenceTerms<'f>) -> &'t [Vec<Look<'f>>] {
        match self {
            Self::All | Self::FromThinned => &terms.all,
            Self::Thinned => &terms.thinned,
        }
    }
}

impl Default for JointOptions {
    fn default() -> Self {
        let motion_model = MotionModel::ConstantVelocity;
        let (rounds, differences) = (Rounds::default(), Differences::default());
        Self { iterations: 25, motion_model, rounds, differences }
    }
}

impl JointOptions {
    /// Steps of the work at most: in each round the first linearisation and one for each iteration, and the standard deviations.
    pub fn most_steps(&self) -> usize {
        let approach = self.rounds.approach();
        let approach: usize = approach.iter().map(|iterations| iterations + 1).sum();
        approach + (self.iterations + 1) + 1
    }
}
