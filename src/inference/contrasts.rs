//! How much the differences between cameras side by side count ([`Parallax`]).
//!
//! The score of a contrast d of weight W is W d. If contrasts err independently, a sum of n scores has the variance v ΣW f, f the share
//! of a contrast that is free. They do not: what is finer than a place, or a camera that is not where its calibration says, stays.
//! So scores are summed over *clusters*: a part's border in one view that faces one way, over all frames; and as for τ in
//! [`noise`](super::noise)
//!
//! v = Σ_clusters (ΣWd)²/ΣW f · 1/(1 − k/n),   n = Σf ΣW²d²/Σ_clusters (ΣWd)²
//!
//! n is the number of independent contrasts. An optimum follows k of them, and they seem not to err: k = tr(H⁻¹ ∂²E_d/∂θ²), with
//! the optimum's own H and the contrasts' part of it. The contrasts count 1/v, of which the lines themselves hold c = 1/(κ²λτ).
//!
//! # Source
//! Liang & Zeger 1986; the degrees of freedom: Patterson & Thompson 1971, *Recovery of inter-block information when block
//! sizes are unequal*.

use std::collections::BTreeMap;

use rayon::prelude::*;

use super::Terms;
use super::sequence_posterior::SequenceState;
use crate::body::{BodyModel, Posed};
use crate::likelihood::{Contrast, Parallax};
use crate::solver::{BorderedChain, NormalEquations};

/// The contrasts of every frame.
#[derive(Debug, Clone)]
pub struct Contrasts {
    frames: Vec<Option<Parallax>>,
    /// How often their cost counts.
    weight: f64,
}

/// An optimum that follows more of the contrasts than this says nothing of how the others err.
const MOST_FOLLOWED: f64 = 0.9;

impl Contrasts {
    /// None, of so many frames.
    pub fn none(frames: usize) -> Self {
        Self { frames: vec![None; frames], weight: 0.0 }
    }

    /// At a state that is the optimum of others, of which it followed k; the lines themselves count `data_weight`.
    pub fn new(
        model: &BodyModel,
        terms: &[Terms<'_>],
        state: &SequenceState,
        followed: f64,
        data_weight: f64,
    ) -> Self {
        let frame = |(terms, motion)| {
            let body = Posed::new(model, &state.shape, motion);
            let terms: &Terms<'_> = terms;
            let parallax = terms.iter().find_map(|term| term.parallax(&body));
            let contrasts = parallax.as_ref().map(|p| p.contrasts(&body)).unwrap_or_default();
            (parallax, contrasts)
        };
        let pairs = terms.par_iter().zip(&state.motions);
        let (frames, contrasts): (_, Vec<Vec<Contrast>>) = pairs.map(frame).unzip();

        let variance = variance(&contrasts.concat(), followed);
        let weight = variance.map_or(0.0, |v| (1.0 / v - data_weight).max(0.0));
        Self { frames, weight }
    }

    /// Their cost in one frame.
    pub fn cost(&self, frame: usize, body: &Posed<'_>) -> f64 {
        self.frames[frame].as_ref().map_or(0.0, |parallax| self.weight * parallax.cost(body))
    }

    /// The same, and its rows added to the equations.
    pub fn linearize(
        &self,
        frame: usize,
        body: &Posed<'_>,
        equations: &mut NormalEquations,
    ) -> f64 {
        let parallax = self.frames[frame].as_ref();
        parallax.map_or(0.0, |parallax| parallax.linearize(body, self.weight, equations))
    }

    /// k: how many of them an optimum follows, of which `chain` is H.
    pub fn followed(
        &self,
        model: &BodyModel,
        optimum: &SequenceState,
        chain: &BorderedChain,
    ) -> f64 {
        let mut followed = 0.0;
        if self.frames.iter().all(Option::is_none) {
            return followed;
        }
        chain.marginals(|i, marginal| {
            let body = Posed::new(model, &optimum.shape, &optimum.motions[i]);
            let covariance = marginal.covariance();
            let mut own = NormalEquations::zeros(covariance.nrows());
            self.linearize(i, &body, &mut own);
            own.hessian.fill_upper_triangle_with_lower_triangle();
            followed += covariance.dot(&own.hessian);
        });
        followed
    }
}

/// v; `None` if there is nothing to tell it from.
fn variance(contrasts: &[Contrast], followed: f64) -> Option<f64> {
    let mut clusters: BTreeMap<_, f64> = BTreeMap::new();
    let (mut squares, mut free, mut free_weight) = (0.0, 0.0, 0.0);
    for Contrast { part, view, quarter, weight, value_m, freedom } in contrasts {
        let score = weight * value_m;
        *clusters.entry((part, view, quarter)).or_default() += score;
        squares += score * score;
        free += freedom;
        free_weight += weight * freedom;
    }

    // together they err no less than each by itself
    let together = clusters.values().map(|sum| sum * sum).sum::<f64>().max(squares);
    let independent = free * squares / together;
    let left = 1.0 - (followed / independent).min(MOST_FOLLOWED);
    let variance = together / (free_weight * left);
    (variance.is_finite() && variance > 0.0).then_some(variance)
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    use super::*;
    use crate::body::PartId;
    use crate::likelihood::Quarter;

    /// Two views of 20 parts in 50 frames, 5 contrasts each; d = a + e, a the same for a cluster.
    fn drawn(constant_sd: f64, own_sd: f64) -> Vec<Contrast> {
        let mut rng = ChaCha8Rng::seed_from_u64(7);
        let mut draw =
            |sd: f64| -> f64 { sd * Distribution::<f64>::sample(&StandardNormal, &mut rng) };
        let mut all = Vec::new();
        for part in (0..400).map(PartId) {
            let constant = draw(constant_sd);
            for _ in 0..250 {
                // of two views' contrasts of weight 1 each has half of the variance
                let value_m = (constant + draw(own_sd)) * 0.5_f64.sqrt();
                let (weight, freedom) = (1.0, 0.5);
                let quarter = Quarter::Left;
                all.push(Contrast { part, view: 0, quarter, weight, value_m, freedom });
            }
        }
        all
    }

    #[test]
    fn contrasts_that_err_independently_count_as_they_err() {
        // 400 squared sums: √(2/400), 7 %
        approx::assert_relative_eq!(
            variance(&drawn(0.0, 0.3), 0.0).unwrap(),
            0.09,
            max_relative = 0.2
        );
    }

    #[test]
    fn what_stays_counts_once_and_not_in_every_frame() {
        let v = variance(&drawn(0.1, 0.3), 0.0).unwrap();
        approx::assert_relative_eq!(v, 0.09 + 250.0 * 0.01, max_relative = 0.2);
    }

    #[test]
    fn contrasts_that_the_optimum_follows_do_not_make_the_others_surer() {
        let contrasts = drawn(0.0, 0.3);
        let free = 0.5 * contrasts.len() as f64;
        let (none, half) = (variance(&contrasts, 0.0), variance(&contrasts, 0.5 * free));
        approx::assert_relative_eq!(half.unwrap(), 2.0 * none.unwrap(), max_relative = 0.2);
    }

    #[test]
    fn nothing_is_told_from_nothing() {
        assert_eq!(variance(&[], 0.0), None);
    }
}
