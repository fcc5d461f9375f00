//! Metaballs: a smooth skin around the skeleton (PF02 § 2.2–2.3), and all derivatives of its field.
//!
//! | symbol | here                       | unit | frame |
//! |--------|----------------------------|------|-------|
//! | F      | [`Field::value`]           | 1    |       |
//! | T      | [`THRESHOLD`]              | 1    |       |
//! | d      | [`Metaball::distance`]     | 1    |       |
//! | QS     | a square root of [`Metaball::precision`] | m⁻¹ | world |
//! | ∂²/∂xᵢ∂xⱼ (A.4) | [`FieldSample::log_hessian`], of ln F | m⁻² | world |
//! | ∂/∂θ, ∂²/∂xᵢ∂θ (A.2, A.3, A.5) | [`FieldSlopes::row`] | 1, m⁻¹ | world |
//!
//! **Differs** from PF02 eq. 3: the sum goes over a limb, and F is the largest of the sums. The module of
//! [`BodyModel::limbs`](super::BodyModel::limbs) says why.

mod check;
mod field;
mod sample;
mod sampler;
mod slopes;

pub use check::check_field;
pub use field::{Field, Metaball};
pub use sample::{FieldSample, Share};
pub use sampler::Sampler;
pub use slopes::{BallChange, FieldRow, FieldSlopes};

/// T: the skin is where F = T (PF02 eq. 2).
pub const THRESHOLD: f64 = 0.5;
