//! What the optimum would be if joints lay elsewhere in the flesh: considered parameters.
//!
//! Where in the flesh a joint lies (c, standard normal, [`PlacedBody`]) is not estimated, because no outline shows it: the
//! optimum θ̂ is found at c = 0. A real person has another c. The optimum at that c errs as H⁻¹ says; the one at 0 is off
//! from it by −S c,
//!
//! S = ∂θ̂/∂c = −H_θθ⁻¹ H_θc
//!
//! to first order, with H the Gauss–Newton matrix of what was minimised. No prior depends on c, so H_θc comes from the data
//! alone. They are linearised once more, with the components of c and of the joints v that turn flesh beside those of θ:
//! H_θc ← H_θc + H_θv ∂v/∂c. S solves the chain that is factorised already, a column for each c: O(n). A number q(θ, c) of the
//! body (an angle, a joint's centre, a length) then errs by
//!
//! cov(q) = J Σ Jᵀ + (J S + D)(J S + D)ᵀ,  J = ∂q/∂θ, D = ∂q/∂c
//!
//! Where the data hold θ in place, S is small and q keeps D. Where θ can follow c without a cost, J S cancels D.
//!
//! # Source
//! Schmidt 1966, *Application of state-space methods to navigation problems*; Tapley, Schutz, Born 2004, *Statistical Orbit
//! Determination*, ch. 6 (consider covariance analysis).

use nalgebra::DMatrix;
use rayon::prelude::*;

use super::Terms;
use super::frame::linearize_data;
use super::sequence_posterior::SequenceState;
use crate::body::{BodyModel, Layout, Motion, PlacedBody, Posed, Shape};
use crate::solver::{BorderedChain, Columns, NormalEquations};

/// The places c and what they do to the optimum.
#[derive(Debug, Clone)]
pub struct Considered {
    /// The body with c.
    pub placed: PlacedBody,
    /// S: of every motion and of s, a column for each c.
    pub sensitivity: Columns,
}

impl Considered {
    /// S at an optimum whose g and H are the chain's, the data as they are stated; `None` where H is singular.
    pub fn new(
        model: &BodyModel,
        terms: &[Terms<'_>],
        state: &SequenceState,
        chain: &BorderedChain,
    ) -> Option<Self> {
        let placed = PlacedBody::new(model, &state.shape);
        let shape = placed.shape(&state.shape);

        // H_θc, frame by frame
        let frames = terms.par_iter().zip(&state.motions);
        let pulls: Vec<DMatrix<f64>> = match placed.count() {
            0 => frames.map(|_| DMatrix::zeros(Layout::new(model).total(), 0)).collect(),
            _ => frames
                .map(|(terms, motion)| cross_hessian(model, &placed, terms, &shape, motion))
                .collect(),
        };

        // S: minus the chain's solution for it
        let (m, p) = (Layout::new(model).motion(), state.shape.0.len());
        let shared = DMatrix::zeros(p, placed.count());
        let shared = pulls.iter().fold(shared, |sum, pull| sum - pull.rows(m, p));
        let frames = pulls.iter().map(|pull| -pull.rows(0, m)).collect();
        Some(Self { sensitivity: chain.solve(Columns { frames, shared })?, placed })
    }
}

/// H_θc of one frame, θ its motion and s.
fn cross_hessian(
    model: &BodyModel,
    placed: &PlacedBody,
    terms: &Terms<'_>,
    shape: &Shape,
    motion: &Motion,
) -> DMatrix<f64> {
    let (layout, all) = (Layout::new(model), Layout::new(&placed.model));
    let motion = placed.motion(motion);
    let body = Posed::new(&placed.model, shape, &motion);

    // the data's H of all components
    let mut equations = NormalEquations::zeros(all.total());
    linearize_data(terms, &body, &mut equations);
    equations.hessian.fill_upper_triangle_with_lower_triangle();

    // H_θc + H_θv ∂v/∂c
    let theta: Vec<usize> = layout.components_in(placed).collect();
    let rows = equations.hessian.select_rows(&theta);
    let turned = rows.columns(layout.motion(), all.motion() - layout.motion());
    rows.columns(all.total() - placed.count(), placed.count()) + turned * &placed.turns
}
