//! Which data tell what they show: not what lies in folds of the skin ([`folds`](super::folds)), and no border that two parts share
//! ([`shared_border`](super::shared_border)). Both are decided once, where a round of the joint optimum begins.

use super::folds::Folds;
use super::skin_term::{SkinTerm, SkinTouch};
use super::{PlacedResidual, Source, Term};
use crate::body::Posed;
use crate::body::metaball::Field;

/// What a term says of the data that tell what they show.
pub struct Clear<'a> {
    /// Their residuals.
    pub residuals: Vec<PlacedResidual>,
    /// The term of them alone; `None` where it is of all data.
    pub term: Option<Box<dyn Term + 'a>>,
}

impl std::fmt::Debug for Clear<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Clear({} residuals)", self.residuals.len())
    }
}

/// The data of a term, divided by whether they tell what they show.
pub(super) struct Divided {
    /// Residuals of those that do.
    pub(super) clear: Vec<PlacedResidual>,
    /// Those that do not: of which source, and their position in it.
    pub(super) unclear: Vec<(Source, usize)>,
}

impl Divided {
    /// Divides the data of a term: what lies in folds is unclear, and what is said to be shared.
    pub(super) fn new(
        term: &impl SkinTerm,
        body: &Posed<'_>,
        is_shared: impl Fn(Source, usize) -> bool,
    ) -> Self {
        let field = Field::from_body(body);
        let folds = Folds::new(body.model, &field);
        let mut divided = Self { clear: Vec::new(), unclear: Vec::new() };
        term.touches(body, &field, &term.scale(body, &field), |touch, sample| {
            if folds.contain(sample) || is_shared(touch.source, touch.index) {
                divided.unclear.push((touch.source, touch.index));
            } else {
                let touch = SkinTouch::new(touch, sample);
                divided.clear.extend(touch.placed(body, &field, term.loss()));
            }
        });
        divided
    }
}

/// Of so many data of a source those that are clear.
pub(super) fn kept(source: Source, count: usize, unclear: &[(Source, usize)]) -> Vec<usize> {
    let mut is_kept = vec![true; count];
    let own = unclear.iter().filter(|(from, _)| *from == source);
    own.for_each(|(_, index)| is_kept[*index] = false);
    (0..count).filter(|&i| is_kept[i]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_each_source_only_its_own_data_are_left_out() {
        let unclear = [(Source::View(0), 1), (Source::View(1), 0), (Source::View(1), 3)];
        assert_eq!(kept(Source::View(0), 3, &unclear), [0, 2]);
        assert_eq!(kept(Source::View(1), 4, &unclear), [1, 2]);
        assert_eq!(kept(Source::Cloud, 2, &unclear), [0, 1]);
    }
}
