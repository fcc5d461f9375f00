//! Pointing errors of the cameras: by how much each image is displaced from where its calibration puts it.
//!
//! A camera that was touched after its calibration is turned by a small angle. A turn about an axis across the line of
//! sight displaces the whole image by the same δ, f times the angle (to first order, and in a narrow field of view), in
//! every frame, as if its principal point had moved. A border point with the outward normal n that lies d outside the
//! body's outline then lies d − n·δ outside. With p(δ) = N(0, σ_δ²I), σ_δ = f · 3 mrad, and a body that is given,
//!
//! (Σ c w ρ′ nnᵀ/σ² + I/σ_δ²) δ = Σ c w ρ′ n d/σ²
//!
//! over all rows of the camera, c = 1/(κ²λτ) ([`Noise`]). Body and δ are
//! improved by turns, from δ = 0. A shift common to all cameras stays in the body.

use nalgebra::{Matrix2, Vector2};

use super::noise::Noise;
use crate::camera::{Camera, Rig};
use crate::likelihood::{PlacedResidual, Source};
use crate::silhouette::FrameObservations;

/// σ_δ/f.
const SIGMA_RAD: f64 = 0.003;

/// δ of every camera, px, in the order of the rig; `before` are those with which the residuals were measured.
pub fn estimate_aims_px(
    rig: &Rig,
    before: &[Vector2<f64>],
    frames: &[FrameObservations],
    residuals: &[Vec<PlacedResidual>],
    noise: &Noise,
) -> Vec<Vector2<f64>> {
    let prior = |camera: &Camera| {
        let sigma_px = SIGMA_RAD * camera.intrinsics.focal_px();
        Matrix2::identity() / (sigma_px * sigma_px)
    };
    let mut normal: Vec<_> = rig.cameras.iter().map(prior).collect();
    let mut right = vec![Vector2::zeros(); rig.cameras.len()];

    // both sides of the equation, row by row
    let c = noise.data_weight();
    for (frame, rows) in frames.iter().zip(residuals) {
        for row in rows {
            let Source::View(view) = row.source else {
                continue;
            };
            let camera = frame.views[view].0.0;
            let n = row.outward_px;
            let weight = c * row.weight * row.trust / (row.sigma * row.sigma);
            let outside_px = row.value * row.sigma + n.dot(&before[camera]);
            normal[camera] += n * n.transpose() * weight;
            right[camera] += n * (weight * outside_px);
        }
    }

    let solve = |(normal, right): (&Matrix2<f64>, &Vector2<f64>)| {
        let factor = normal.cholesky()?;
        Some(factor.solve(right))
    };
    let solved = normal.iter().zip(&right).map(solve);
    solved.map(Option::unwrap_or_default).collect()
}
