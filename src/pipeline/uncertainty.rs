//! How sure the shape and its lengths are.
//!
//! A length is as sure as the coefficients that make it, and as the places of its two ends in the flesh.

use nalgebra::{DMatrix, DVector};

use crate::body::{BodyModel, Layout, Motion, Posed, Shape};

/// Standard deviations of the shape: of the true numbers, as far as a bias that returns in every frame can be known.
#[derive(Debug, Clone, PartialEq)]
pub struct ShapeUncertainty {
    /// Covariance of the coefficients.
    pub covariance: DMatrix<f64>,
    /// Of each length of the model, metres.
    pub lengths_sd_m: Vec<f64>,
}

impl ShapeUncertainty {
    /// Carries the coefficients' covariance on to the lengths: ∂‖b − a‖ = uᵀ(∂b − ∂a), u = (b − a)/‖b − a‖.
    pub fn of(model: &BodyModel, shape: &Shape, covariance: DMatrix<f64>) -> Self {
        let rest = Motion::rest(model);
        let body = Posed::new(model, shape, &rest);
        let points = body.points();
        let first = Layout::of(model).motion();
        let coefficients = shape.0.len();
        let sd_m = |(_, from, to): &(String, usize, usize)| {
            let along = (points[*to] - points[*from]).try_normalize(1e-12)?;
            let moved = body.point_jacobian(*to) - body.point_jacobian(*from);
            let gradient: DVector<f64> = moved.columns(first, coefficients).tr_mul(&along);
            let ends = along.dot(&(body.way_spread(*from, *to) * along));
            let variance = gradient.dot(&(&covariance * &gradient)).max(0.0);
            Some((variance + ends).sqrt())
        };
        let lengths_sd_m = model
            .lengths
            .iter()
            .map(|l| sd_m(l).unwrap_or(0.0))
            .collect();
        Self {
            covariance,
            lengths_sd_m,
        }
    }
}
