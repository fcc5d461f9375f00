//! Whether the body is as tall as the person is known to be: the only test of scale that needs no guess about the person.
//!
//! Silhouettes of a scene that is λ times as large show the same, and so do those of cameras whose focal lengths are all λ times
//! as short, as far as they look at one place. A person's height tells.

use nalgebra::DVector;

use crate::body::{BodyModel, Motion, Posed, Root, Shape};
use crate::inference::covariance::ShapeUncertainty;
use crate::math::central_differences;

/// What silhouettes add to a person's height at most, m: soles of four centimetres, and hair.
const WORN_M: f64 = 0.08;
/// By how much a stated height is too large at most, m: two standard deviations of what people say of themselves (ANSUR II).
const OVERSTATED_M: f64 = 0.05;
/// Standard deviations of the body's own height that are allowed on top.
const SIGMAS: f64 = 2.0;
/// Step of the derivatives by the coefficients.
const STEP: f64 = 1e-4;

/// The height of the standing body, m.
pub(in crate::pipeline) fn stature_m(model: &BodyModel, shape: &Shape) -> f64 {
    let body = Posed::new(model, shape, &Motion::rest(model));
    body.bounds().map_or(0.0, |(low, high)| (high - low).z)
}

/// The body's height, if it is not that of a person who is `given_m` tall, in whatever clothes; of a fixed limb `None`.
pub(super) fn wrong_stature_m(
    model: &BodyModel,
    shape: &Shape,
    uncertainty: Option<&ShapeUncertainty>,
    given_m: f64,
) -> Option<f64> {
    if model.root == Root::Fixed {
        return None;
    }
    let found_m = stature_m(model, shape);
    let allowed_m = SIGMAS * uncertainty.map_or(0.0, |u| stature_sd_m(model, shape, u));
    let (least, most) = (given_m - OVERSTATED_M - allowed_m, given_m + WORN_M + allowed_m);
    (found_m < least || found_m > most).then_some(found_m)
}

/// √(gᵀΣg), g the derivatives of the height by the coefficients.
fn stature_sd_m(model: &BodyModel, shape: &Shape, uncertainty: &ShapeUncertainty) -> f64 {
    let count = uncertainty.covariance.nrows().min(shape.0.len());
    let slope = central_differences(count, STEP, |delta| {
        let mut moved = shape.clone();
        moved.0.iter_mut().zip(delta.iter()).for_each(|(s, by)| *s += by);
        DVector::from_element(1, stature_m(model, &moved))
    });
    let covariance = uncertainty.covariance.view((0, 0), (count, count));
    (&slope * covariance * slope.transpose())[0].max(0.0).sqrt()
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use nalgebra::DMatrix;

    use super::*;

    fn human() -> (BodyModel, Shape) {
        let model = crate::io::model::load("human-ellipsoids", Path::new("")).unwrap();
        let shape = Shape(model.statistics.mean.clone());
        (model, shape)
    }

    #[test]
    fn a_body_a_tenth_too_large_or_too_small_is_not_the_person_and_one_in_shoes_is() {
        let (model, shape) = human();
        let tall_m = stature_m(&model, &shape);
        assert!((1.6..1.8).contains(&tall_m), "{tall_m}");
        let wrong = |given_m: f64| wrong_stature_m(&model, &shape, None, given_m);

        assert_eq!(wrong(tall_m), None);
        assert_eq!(wrong(tall_m - 0.06), None, "boots and a hat");
        assert_eq!(wrong(tall_m + 0.03), None, "taller by his own account");
        assert_eq!(wrong(tall_m / 1.1), Some(tall_m));
        assert_eq!(wrong(tall_m / 0.9), Some(tall_m));
    }

    #[test]
    fn a_body_that_is_not_sure_of_its_height_is_given_more_room() {
        let (model, shape) = human();
        let given_m = stature_m(&model, &shape) / 1.1;
        let count = shape.0.len();
        let unsure = |sd: f64| ShapeUncertainty {
            covariance: DMatrix::from_diagonal_element(count, count, sd * sd),
            lengths_sd_m: Vec::new(),
        };
        let wrong = |sd| wrong_stature_m(&model, &shape, Some(&unsure(sd)), given_m);
        assert!(wrong(0.01).is_some());
        assert_eq!(wrong(0.2), None);
    }
}
