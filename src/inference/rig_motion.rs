//! What all cameras of a rig have in common: a world that is elsewhere, or of another size, shows the same.
//!
//! c holds the turns ω_c of all cameras about their own centres o_c and their displacements δ_c, world axes. In a world that is turned by α,
//! displaced by β and larger by κ, about the middle of the cameras,
//!
//! ω_c = α,  δ_c = α × o_c + β + κ o_c:
//!
//! c = N g with g = (α, β, κ). Of any c the common part is g = (NᵀMN)⁻¹NᵀM c, M weighing turns by the rig's size squared, and what is left
//! is P c, P = 1 − N(NᵀMN)⁻¹NᵀM: the cameras relative to each other (the free network of geodesy).
//!
//! # Source
//! Triggs et al. 2000, *Bundle adjustment: a modern synthesis*, § 9.

use nalgebra::{DMatrix, DVector, Point3, SMatrix, SVector, Vector3};

use crate::math::rotation::right_jacobian_inverse;
use crate::solver::NormalEquations;

/// ω and δ.
const POSE: usize = 6;
/// α, β and κ.
pub const COMMON: usize = 7;

/// The common part of turns and displacements.
#[derive(Debug, Clone, PartialEq)]
pub struct RigMotion {
    /// N, 6 of each camera × 7.
    moved: DMatrix<f64>,
    /// (NᵀMN)⁻¹NᵀM, 7 × 6 of each camera.
    common: DMatrix<f64>,
    /// The root mean square distance of the cameras from their middle, metres.
    size_m: f64,
}

impl RigMotion {
    /// Of cameras with these centres; `None` where they stand in one place.
    pub fn new(centres: &[Point3<f64>]) -> Option<Self> {
        let count = centres.len().max(1) as f64;
        let middle = centres.iter().map(|c| c.coords).sum::<Vector3<f64>>() / count;
        let places: Vec<Vector3<f64>> = centres.iter().map(|c| c.coords - middle).collect();
        let square = places.iter().map(Vector3::norm_squared).sum::<f64>() / count;

        let n = POSE * centres.len();
        let mut moved = DMatrix::zeros(n, COMMON);
        let mut weights = DVector::from_element(n, 1.0);
        for (c, place) in places.iter().enumerate() {
            let (turn, way) = (POSE * c, POSE * c + 3);
            moved.view_mut((turn, 0), (3, 3)).fill_with_identity();
            moved.view_mut((way, 0), (3, 3)).copy_from(&-place.cross_matrix());
            moved.view_mut((way, 3), (3, 3)).fill_with_identity();
            moved.view_mut((way, 6), (3, 1)).copy_from(place);
            weights.rows_mut(turn, 3).fill(square);
        }
        let weighted = DMatrix::from_diagonal(&weights) * &moved;
        let inner = (moved.transpose() * &weighted).cholesky()?;
        let common = inner.solve(&weighted.transpose());
        Some(Self { moved, common, size_m: square.sqrt() })
    }

    /// 1/σ² of α, β and κ, of a world whose axes and edges are known with these standard deviations (rad, m).
    pub(super) fn weights(&self, turn_sd: f64, displacement_sd_m: f64) -> SVector<f64, COMMON> {
        let sd = |k: usize| match k {
            0..3 => turn_sd,
            3..6 => displacement_sd_m,
            _ => displacement_sd_m / self.size_m,
        };
        SVector::from_fn(|k, _| sd(k).powi(-2))
    }

    /// PΣPᵀ: the covariance of the cameras relative to each other.
    pub fn relative(&self, covariance: &DMatrix<f64>) -> DMatrix<f64> {
        let n = self.moved.nrows();
        let rest = DMatrix::identity(n, n) - &self.moved * &self.common;
        &rest * covariance * rest.transpose()
    }
}

/// −log p of what all cameras have in common: ½ Σ g²/σ².
#[derive(Debug, Clone, PartialEq)]
pub(super) struct HeldWorld {
    motion: RigMotion,
    /// 1/σ² of g.
    weights: SVector<f64, COMMON>,
}

impl HeldWorld {
    /// As sure as the turns and displacements of one camera of a usual calibration.
    pub(super) fn new(motion: RigMotion, turn_sd: f64, displacement_sd_m: f64) -> Self {
        let weights = motion.weights(turn_sd, displacement_sd_m);
        Self { motion, weights }
    }

    /// g of turns and displacements.
    fn common(&self, poses: &[[Vector3<f64>; 2]]) -> SVector<f64, COMMON> {
        let part = |(c, [turn, way]): (usize, &[Vector3<f64>; 2])| {
            let by = self.motion.common.fixed_view::<COMMON, POSE>(0, POSE * c);
            let turned = by.fixed_columns::<3>(0) * turn;
            turned + by.fixed_columns::<3>(3) * way
        };
        poses.iter().enumerate().map(part).sum()
    }

    pub(super) fn cost(&self, poses: &[[Vector3<f64>; 2]]) -> f64 {
        let g = self.common(poses);
        0.5 * g.component_mul(&g).dot(&self.weights)
    }

    /// Adds its gradient and Gauss–Newton matrix; the components of the first camera are from `first` on, those of the next `step` further.
    pub(super) fn linearize(
        &self,
        poses: &[[Vector3<f64>; 2]],
        (first, step): (usize, usize),
        equations: &mut NormalEquations,
    ) {
        let pull = self.common(poses).component_mul(&self.weights);
        let slope = |(c, [turn, _]): (usize, &[Vector3<f64>; 2])| {
            let mut slope = self.motion.common.fixed_view::<COMMON, POSE>(0, POSE * c).into_owned();
            let turned = slope.fixed_columns::<3>(0) * right_jacobian_inverse(&-turn);
            slope.fixed_columns_mut::<3>(0).copy_from(&turned);
            slope
        };
        let slopes: Vec<SMatrix<f64, COMMON, POSE>> = poses.iter().enumerate().map(slope).collect();
        for (c, slope) in slopes.iter().enumerate() {
            let own = first + step * c;
            let mut gradient = equations.gradient.fixed_rows_mut::<POSE>(own);
            gradient += slope.transpose() * pull;
            for (d, other) in slopes.iter().enumerate() {
                let weighed = SMatrix::<f64, COMMON, COMMON>::from_diagonal(&self.weights) * other;
                let place = (own, first + step * d);
                let mut block = equations.hessian.fixed_view_mut::<POSE, POSE>(place.0, place.1);
                block += slope.transpose() * weighed;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_world_that_is_uncertain_itself_makes_no_camera_less_certain_and_one_that_errs_alone_does()
    {
        let centres = [[0.0, 0.0, 2.0], [4.0, 0.0, 2.0], [0.0, 5.0, 1.0], [3.0, 4.0, 2.5]];
        let centres: Vec<Point3<f64>> = centres.map(Point3::from).into();
        let motion = RigMotion::new(&centres).unwrap();
        let n = POSE * centres.len();

        // the world turned and larger, by any amount
        let (turn, larger) = (Vector3::new(0.1, -0.2, 0.3), 0.2);
        let moved = DVector::from_fn(n, |k, _| {
            let (place, axis) = (centres[k / POSE].coords, k % POSE);
            if axis < 3 { turn[axis] } else { (turn.cross(&place) + larger * place)[axis - 3] }
        });
        let found = &motion.common * &moved;
        assert!((found[6] - larger).abs() < 1e-12 && (found[2] - turn.z).abs() < 1e-12, "{found}");
        let world = &moved * moved.transpose();
        let left = motion.relative(&world);
        assert!(left.amax() < 1e-12, "{}", left.amax());

        let mut alone = DMatrix::zeros(n, n);
        alone[(3, 3)] = 1.0;
        let sd = motion.relative(&(world + alone))[(3, 3)].sqrt();
        assert!((0.2..1.0).contains(&sd), "{sd}");
        assert!(RigMotion::new(&[Point3::origin(); 3]).is_none());
    }
}
