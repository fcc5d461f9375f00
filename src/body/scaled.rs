//! Lengths that differ between bodies: what the shape coefficients do to a vector of the model.
//!
//! v(s) = diag(λ₁, λ₂, λ₃)·v + Σ s_c·d_c: each component has a factor λ(s) of its own, and any number of shifts are added, each
//! along a direction. So a place in the flesh can grow with a limb and shift as well.

use nalgebra::{DVector, Vector3};

use super::{CoefficientId, Shape};

/// The factor by which a shape coefficient s scales a length.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scale {
    /// 1: this length is the same in every body.
    Fixed,
    /// eˢ (PF02 eq. 1: λ = eˢ, positive by construction).
    Log(CoefficientId),
    /// 2/(1 + e⁻ˢ): this length's share of a fixed total.
    Share(CoefficientId),
    /// 2/(1 + eˢ): what the other length's share leaves.
    Rest(CoefficientId),
}

impl Scale {
    /// The coefficient that it reads, if any.
    pub fn coefficient(self) -> Option<CoefficientId> {
        match self {
            Self::Fixed => None,
            Self::Log(c) | Self::Share(c) | Self::Rest(c) => Some(c),
        }
    }

    /// λ and its derivative with respect to s.
    fn factor(self, shape: &DVector<f64>) -> (f64, f64) {
        let share = |s: f64| {
            let half = 1.0 / (1.0 + (-s).exp());
            (2.0 * half, 2.0 * half * (1.0 - half))
        };
        match self {
            Self::Fixed => (1.0, 0.0),
            Self::Log(c) => {
                let factor = shape[c.0].exp();
                (factor, factor)
            }
            Self::Share(c) => share(shape[c.0]),
            Self::Rest(c) => {
                let (factor, slope) = share(-shape[c.0]);
                (factor, -slope)
            }
        }
    }
}

/// A shift by s metres along a direction: where a joint or the flesh lies.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shift {
    /// s.
    pub coefficient: CoefficientId,
    /// d, length 1 where s is in metres.
    pub direction: Vector3<f64>,
}

/// Three lengths, each with its own scale, and shifts.
#[derive(Debug, Clone, PartialEq)]
pub struct ScaledVector {
    /// Where all coefficients are 0, metres.
    pub value: Vector3<f64>,
    /// What scales x, y and z.
    pub scale: [Scale; 3],
    /// What is added.
    pub shifts: Vec<Shift>,
}

impl ScaledVector {
    /// The same in every body.
    pub fn fixed(value: Vector3<f64>) -> Self {
        Self { value, scale: [Scale::Fixed; 3], shifts: Vec::new() }
    }

    /// The coefficients that it reads; one may occur more than once.
    pub fn coefficients(&self) -> impl Iterator<Item = CoefficientId> {
        let scales = self.scale.iter().filter_map(|scale| scale.coefficient());
        scales.chain(self.shifts.iter().map(|shift| shift.coefficient))
    }

    /// The three lengths in a body of this shape, metres.
    pub(crate) fn at(&self, shape: &Shape) -> Vector3<f64> {
        self.factors(shape).component_mul(&self.value) + self.shifted(shape)
    }

    /// ∂v/∂s for each coefficient that it reads; the slopes of a coefficient that occurs more than once add up.
    pub(crate) fn slopes(
        &self,
        shape: &Shape,
    ) -> impl Iterator<Item = (CoefficientId, Vector3<f64>)> {
        let scaled = (0..3).filter_map(|k| {
            let slope = self.scale[k].factor(&shape.0).1 * self.value[k];
            Some((self.scale[k].coefficient()?, Vector3::ith(k, slope)))
        });
        let shifted = self.shifts.iter().map(|s| (s.coefficient, s.direction));
        scaled.chain(shifted)
    }

    /// Changes the lengths so that they are `lengths` in a body of this shape.
    pub(crate) fn set_at(&mut self, lengths: Vector3<f64>, shape: &Shape) {
        self.value = (lengths - self.shifted(shape)).component_div(&self.factors(shape));
    }

    fn factors(&self, shape: &Shape) -> Vector3<f64> {
        Vector3::from_fn(|k, _| self.scale[k].factor(&shape.0).0)
    }

    fn shifted(&self, shape: &Shape) -> Vector3<f64> {
        let shifts = self.shifts.iter();
        shifts.map(|s| s.direction * shape.0[s.coefficient.0]).sum()
    }
}
