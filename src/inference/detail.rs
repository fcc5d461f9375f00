//! How closely a frame is looked at.

use crate::likelihood::LikelihoodOptions;

/// How much of what a frame shows a posterior looks at.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Detail {
    /// A thinned part, and forgiving: to sort starts.
    Coarse,
    /// A thinned part: to approach an optimum.
    Thinned,
    /// All: to measure.
    Fine,
}

/// Coarse evaluations forgive this much mismatch, m.
const COARSE_SIGMA_M: f64 = 0.03;
/// They look at so many points in space at most: several for each correlation length of a body.
const COARSE_POINTS: usize = 200;
/// To approach an optimum so many are enough: they share the weights of all, see [`PointOptions`](crate::likelihood::PointOptions).
const THINNED_POINTS: usize = 1500;
/// They look at so few samples of each ellipse's outline.
const COARSE_BACK_SAMPLES: usize = 6;

impl Detail {
    /// The distance between neighbouring border points, m.
    pub(super) fn spacing_m(self) -> f64 {
        match self {
            Self::Coarse => 0.15,
            Self::Thinned => 0.05,
            Self::Fine => 0.02,
        }
    }

    /// Every how many of `points` points in space one is looked at.
    pub(super) fn point_step(self, points: usize) -> usize {
        match self {
            Self::Coarse => points.div_ceil(COARSE_POINTS).max(1),
            Self::Thinned => points.div_ceil(THINNED_POINTS).max(1),
            Self::Fine => 1,
        }
    }

    /// The settings of the terms, from those of full detail.
    pub(super) fn likelihood(self, mut options: LikelihoodOptions) -> LikelihoodOptions {
        if self != Self::Coarse {
            return options;
        }
        let ellipses = &mut options.ellipses;
        ellipses.sigma_m = ellipses.sigma_m.max(COARSE_SIGMA_M);
        ellipses.back_samples = ellipses.back_samples.min(COARSE_BACK_SAMPLES);
        options.rays.sigma_m = options.rays.sigma_m.max(COARSE_SIGMA_M);
        options.points.sigma_m = options.points.sigma_m.max(COARSE_SIGMA_M);
        options
    }
}
