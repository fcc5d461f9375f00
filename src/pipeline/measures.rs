//! Which stage looks at what.

use super::FitError;
use crate::body::BodyModel;
use crate::likelihood::Measure;

/// Whether the body has what it was asked to be compared by; known before anything is searched.
///
/// # Errors
/// [`FitError::Primitives`] if it has not.
pub fn check_measure(model: &BodyModel, asked: Option<Measure>) -> Result<(), FitError> {
    Measures::choose(model, asked).map(|_| ())
}

/// Whether any stage compares points with the body: only the skin of metaballs meets them.
pub(crate) fn fits_points(model: &BodyModel, asked: Option<Measure>) -> bool {
    let measures = Measures::choose(model, asked);
    measures.is_ok_and(|m| m.search.has_metaballs() || m.joint.has_metaballs())
}

/// What each stage compares silhouettes and points with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Measures {
    /// Algorithm 1.
    pub(super) search: Measure,
    /// The joint optimum.
    pub(super) joint: Measure,
}

impl Measures {
    /// What was asked for, in every stage; or the ellipsoids first and the metaballs then, as far as the model has them.
    pub(super) fn choose(model: &BodyModel, asked: Option<Measure>) -> Result<Self, FitError> {
        let lacks = |measure: Measure| {
            (measure.has_ellipses() && model.ellipsoids.is_empty())
                || (measure.has_metaballs() && model.metaballs.is_empty())
        };
        let first_of = |preferred, other| if lacks(preferred) { other } else { preferred };

        match asked {
            Some(measure) if lacks(measure) => Err(FitError::Primitives {
                model: model.name.clone(),
                lacking: match model.metaballs.is_empty() {
                    true => "metaballs",
                    false => "ellipsoids",
                },
            }),
            Some(measure) => Ok(Self { search: measure, joint: measure }),
            None => Ok(Self {
                search: first_of(Measure::Ellipses, Measure::Metaballs),
                joint: first_of(Measure::Metaballs, Measure::Ellipses),
            }),
        }
    }

    /// What is possible where no frame shows a silhouette to two cameras: only the skin of metaballs meets points.
    ///
    /// # Errors
    /// [`FitError::Primitives`] if there is none, or it was not to be looked at.
    pub(super) fn choose_for_points(
        model: &BodyModel,
        asked: Option<Measure>,
    ) -> Result<Self, FitError> {
        let asked = asked.unwrap_or(Measure::Metaballs);
        if !asked.has_metaballs() {
            return Err(FitError::PointsOnEllipses);
        }
        Self::choose(model, Some(asked))
    }
}
