//! Where a step is shortened to.

/// A step is not shortened to less than this part of it at once.
const SHORTEST: f64 = 0.1;

/// E along a step behind which the cost is higher.
#[derive(Debug, Clone, Copy)]
pub(super) struct Parabola {
    /// t: where on the step it is least; not finite where the dropped cost is not.
    least: f64,
    /// By how much it falls to there.
    pub(super) promised: f64,
}

impl Parabola {
    /// `slope` is gᵀδ.
    pub(super) fn new(cost: f64, dropped: f64, slope: f64) -> Self {
        let least = -slope / (2.0 * (dropped - cost - slope));
        Self { least, promised: -0.5 * slope * least }
    }

    /// Whether it says anything: a dropped cost far above the other says only that the step was too long.
    pub(super) fn is_known(self) -> bool {
        self.least >= SHORTEST
    }

    /// By how much the step is shortened.
    pub(super) fn step(self) -> f64 {
        if self.least.is_finite() { self.least.clamp(SHORTEST, 0.5) } else { SHORTEST }
    }
}
