//! What a residual has to do with the offsets of the surface.

use crate::body::{Layout, Offset};
use crate::solver::NormalEquations;

/// b in the unit of a residual, and the residual's derivatives with respect to its coefficients.
#[derive(Debug, Clone, Copy)]
pub(super) struct OffsetRow {
    pub(super) value: f64,
    /// By component of the state.
    pub(super) slopes: [(usize, f64); 4],
}

impl OffsetRow {
    /// `unit`·b: what a residual grows by for each metre of b.
    pub(super) fn new(b: &Offset, layout: Layout, unit: f64) -> Self {
        let slopes = b.slopes.map(|(c, phi)| (layout.coefficient(c), phi * unit));
        Self { value: b.value_m * unit, slopes }
    }

    /// Whether the equations have the coefficients: s may be held.
    pub(super) fn is_free(&self, equations: &NormalEquations) -> bool {
        self.slopes.iter().all(|(component, _)| *component < equations.gradient.len())
    }

    /// Adds the coefficients' own equations, of a residual r of weight w that depends on all these.
    pub(super) fn add_own(rows: &[Self], r: f64, w: f64, equations: &mut NormalEquations) {
        let all = || rows.iter().flat_map(|row| row.slopes);
        for (component, slope) in all() {
            equations.gradient[component] += w * slope * r;
            for (other, other_slope) in all().filter(|(o, _)| *o <= component) {
                equations.hessian[(component, other)] += w * slope * other_slope;
            }
        }
    }
}
