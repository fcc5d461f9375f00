//! How much the differences between cameras side by side count ([`Parallax`]).
//!
//! The score of a contrast d of weight W is W d. If contrasts err independently, a sum of scores has the variance v ΣW f, f the share
//! of a contrast that is free. They do not: what is finer than a place, or a camera that is not where its calibration says, stays.
//! So scores are summed over *clusters*: a part's border in one view that faces one way, over all frames; and as for τ in
//! [`noise`](super::noise)
//!
//! v = Σ_clusters (ΣWd)²/(1 − h) / ΣW f,   but no less than with each contrast for a cluster.
//!
//! An optimum follows what errs, and least seems to err where it follows most. h is the *leverage* of a cluster: which share of the
//! variance of its sum the optimum takes. With g_im and g_s = Σᵢ g_is its gradient ΣW ∂d/∂θ with respect to the motion of frame i and to
//! what the frames share, Σ = H⁻¹, and w the weight of contrasts in H,
//!
//! h = w (g̃ᵀ Σ_ss g̃ + Σᵢ g_imᵀ Σᵢ′ g_im)/ΣW f,
//!
//! Σ_ss g̃ = Σ_ss g_s + Σᵢ Σ_si g_im,   Σᵢ′ = Σᵢᵢ − Σ_siᵀ Σ_ss⁻¹ Σ_si:
//!
//! a motion goes with what is shared, and by itself. By themselves, motions of different frames are taken to be independent. The
//! contrasts count 1/v, of which the lines themselves hold c = 1/(κ²λτ).
//!
//! # Source
//! Liang & Zeger 1986; the leverage: Bell & McCaffrey 2002, *Bias reduction in standard errors for linear regression with
//! multi-stage samples*.

use std::collections::BTreeMap;

use nalgebra::DVector;
use rayon::prelude::*;

use super::Look;
use super::sequence_state::SequenceState;
use crate::body::{BodyModel, PartId, Posed};
use crate::likelihood::{Contrast, Parallax, Quarter};
use crate::solver::{BorderedChain, NormalEquations};

/// The contrasts of every frame.
#[derive(Debug, Clone)]
pub struct Contrasts {
    frames: Vec<Option<Parallax>>,
    /// How often their cost counts.
    weight: f64,
}

/// A part's border in one view that faces one way.
type Cluster = (PartId, usize, Quarter);

/// h of each cluster; where there is none it is 0.
pub type Leverages = BTreeMap<Cluster, f64>;

/// A cluster that is followed by more than this says nothing of how it errs.
const MOST_FOLLOWED: f64 = 0.9;

impl Contrasts {
    /// None, of so many frames.
    pub fn none(frames: usize) -> Self {
        Self { frames: vec![None; frames], weight: 0.0 }
    }

    /// At a state that is an optimum with these leverages; the lines themselves count `data_weight`. Only of cameras that are
    /// trusted: what is side by side but turned by nobody knows how much says nothing of depth.
    pub fn new(
        model: &BodyModel,
        looks: &[Vec<&Look<'_>>],
        state: &SequenceState,
        leverages: &Leverages,
        data_weight: f64,
    ) -> Self {
        let frame = |(looks, motion): (&Vec<&Look<'_>>, _)| {
            let body = Posed::new(model, &state.shape, motion);
            let trusted = looks.iter().filter(|look| look.camera.is_none());
            let mut terms = trusted.flat_map(|look| &look.terms);
            let parallax = terms.find_map(|term| term.parallax(&body));
            let contrasts = parallax.as_ref().map(|p| p.contrasts(&body)).unwrap_or_default();
            (parallax, contrasts)
        };
        let pairs = looks.par_iter().zip(&state.motions);
        let (frames, contrasts): (_, Vec<Vec<Contrast>>) = pairs.map(frame).unzip();

        let variance = variance(&contrasts.concat(), leverages);
        let weight = variance.map_or(0.0, |v| (1.0 / v - data_weight).max(0.0));
        Self { frames, weight }
    }

    /// Whether no frame has any.
    pub(super) fn are_none(&self) -> bool {
        self.frames.iter().all(Option::is_none)
    }

    /// Whether a frame has any.
    pub(super) fn has(&self, frame: usize) -> bool {
        self.frames[frame].is_some()
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

    /// h of each cluster at an optimum, of which `chain` is H.
    pub fn leverages(
        &self,
        model: &BodyModel,
        optimum: &SequenceState,
        chain: &BorderedChain,
    ) -> Leverages {
        let mut clusters: BTreeMap<Cluster, Followed> = BTreeMap::new();
        if self.are_none() {
            return Leverages::new();
        }

        let mut shared = None;
        chain.marginals(|i, marginal| {
            let shared = shared.get_or_insert_with(|| marginal.shared.clone().cholesky());
            let (Some(parallax), Some(shared)) = (&self.frames[i], shared) else { return };
            let (m, p) = (marginal.frame.nrows(), marginal.shared.nrows());
            let body = Posed::new(model, &optimum.shape, &optimum.motions[i]);
            for (cluster, (gradient, free)) in scores(&parallax.rows(&body, m + p)) {
                let (of_motion, of_shared) = (gradient.rows(0, m), gradient.rows(m, p));
                let moved = marginal.cross * of_motion;
                let followed = clusters.entry(cluster).or_insert_with(|| Followed::none(p));
                followed.own +=
                    of_motion.dot(&(marginal.frame * of_motion)) - moved.dot(&shared.solve(&moved));
                followed.shared += marginal.shared * of_shared + moved;
                followed.free += free;
            }
        });

        let Some(Some(shared)) = shared else { return Leverages::new() };
        let leverage = |f: &Followed| (f.own + f.shared.dot(&shared.solve(&f.shared))) / f.free;
        clusters.iter().map(|(cluster, f)| (*cluster, self.weight * leverage(f))).collect()
    }
}

/// What an optimum follows of a cluster.
struct Followed {
    /// Σᵢ g_imᵀ Σᵢ′ g_im.
    own: f64,
    /// Σ_ss g̃.
    shared: DVector<f64>,
    /// ΣW f.
    free: f64,
}

impl Followed {
    fn none(shared: usize) -> Self {
        Self { own: 0.0, shared: DVector::zeros(shared), free: 0.0 }
    }
}

/// g and ΣW f of each cluster in a frame.
fn scores(rows: &[(Contrast, DVector<f64>)]) -> BTreeMap<Cluster, (DVector<f64>, f64)> {
    let mut scores: BTreeMap<Cluster, (DVector<f64>, f64)> = BTreeMap::new();
    for (contrast, row) in rows {
        let none = || (DVector::zeros(row.len()), 0.0);
        let (gradient, free) = scores.entry(cluster(contrast)).or_insert_with(none);
        gradient.axpy(contrast.weight, row, 1.0);
        *free += contrast.weight * contrast.freedom;
    }
    scores
}

fn cluster(contrast: &Contrast) -> Cluster {
    (contrast.part, contrast.view, contrast.quarter)
}

/// v; `None` if there is nothing to tell it from.
fn variance(contrasts: &[Contrast], leverages: &Leverages) -> Option<f64> {
    let mut clusters: BTreeMap<Cluster, f64> = BTreeMap::new();
    let (mut squares, mut free) = (0.0, 0.0);
    for contrast in contrasts {
        let score = contrast.weight * contrast.value_m;
        *clusters.entry(cluster(contrast)).or_default() += score;
        squares += score * score;
        free += contrast.weight * contrast.freedom;
    }

    let square = |(cluster, sum): (&Cluster, &f64)| {
        let leverage = leverages.get(cluster).copied().unwrap_or_default();
        sum * sum / (1.0 - leverage.min(MOST_FOLLOWED))
    };
    let together: f64 = clusters.iter().map(square).sum();
    let variance = together.max(squares) / free;
    (variance.is_finite() && variance > 0.0).then_some(variance)
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    use super::*;

    /// 250 contrasts of each of 400 parts; d = a + e, a the same for a part.
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

    fn found(constant_sd: f64, own_sd: f64) -> f64 {
        variance(&drawn(constant_sd, own_sd), &Leverages::new()).unwrap()
    }

    #[test]
    fn contrasts_that_err_independently_count_as_they_err() {
        // 400 squared sums: √(2/400), 7 %
        approx::assert_relative_eq!(found(0.0, 0.3), 0.09, max_relative = 0.2);
    }

    #[test]
    fn what_stays_counts_once_and_not_in_every_frame() {
        approx::assert_relative_eq!(found(0.1, 0.3), 0.09 + 250.0 * 0.01, max_relative = 0.2);
    }

    #[test]
    fn a_cluster_that_the_optimum_follows_counts_for_what_it_would_err() {
        let contrasts = drawn(0.0, 0.3);
        let half = contrasts.iter().map(|c| (cluster(c), 0.5)).collect();
        let found = variance(&contrasts, &half).unwrap();
        approx::assert_relative_eq!(found, 2.0 * 0.09, max_relative = 0.2);
    }

    #[test]
    fn nothing_is_told_from_nothing() {
        assert_eq!(variance(&[], &Leverages::new()), None);
    }
}
