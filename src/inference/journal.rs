//! The progress of a search, and what it need not do again.

use super::hypothesis::{Hypothesis, Trial};

/// Keeps what is finished and is told how far the search is; the search itself has no memory.
pub trait Journal: Sync {
    /// The hypotheses of a keyframe, if an earlier run kept them.
    fn kept_keyframe(&self, _keyframe: usize) -> Option<Vec<Hypothesis>> {
        None
    }
    /// A keyframe is finished.
    fn keep_keyframe(&self, _keyframe: usize, _hypotheses: &[Hypothesis]) {}
    /// The trial of a hypothesis, if an earlier run kept it.
    fn kept_trial(&self, _index: usize) -> Option<Trial> {
        None
    }
    /// A trial is finished or pruned.
    fn keep_trial(&self, _index: usize, _trial: &Trial) {}
    /// Whether something could not be kept, so that the search is to be given up.
    fn is_failing(&self) -> bool {
        false
    }
    /// The hypotheses are known: this many will be tried.
    fn hypotheses(&self, _count: usize) {}
    /// Frames of a hypothesis were fitted.
    fn advanced(&self, _index: usize, _frames: usize) {}
}

/// Keeps nothing.
#[derive(Debug, Clone, Copy)]
pub struct NoJournal;
impl Journal for NoJournal {}
