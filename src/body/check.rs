//! The law of kinematics: its Jacobians are the derivatives of its positions.

use nalgebra::{DMatrix, DVector};

use super::{BodyModel, EllipsoidJacobians, Layout, PartId, Posed, State};
use crate::math::quadric::Ellipsoid;
use crate::math::{central_differences, first_difference};

/// A derivative of the kinematics that is wrong.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("∂({what})[{row}]/∂δ[{component}] is {analytic} and {numeric} by differences")]
pub struct KinematicsFault {
    /// Which point, part or ellipsoid.
    pub what: String,
    /// Which of its numbers.
    pub row: usize,
    /// Which component of the state.
    pub component: usize,
    /// What the code says.
    pub analytic: f64,
    /// What differences say.
    pub numeric: f64,
}

/// Checks the Jacobians of every exported point, part and ellipsoid of a model at a state.
///
/// # Errors
/// The first entry that is off by more than `tolerance` (absolute, metres or square metres per unit).
pub fn check_kinematics(
    model: &BodyModel,
    state: &State,
    tolerance: f64,
) -> Result<(), KinematicsFault> {
    let layout = Layout::new(model);
    let body = Posed::new(model, &state.shape, &state.motion);

    for index in 0..model.points.len() {
        let numeric = central_differences(layout.total(), 1e-3, |delta| {
            let moved = layout.retract(state, delta);
            let points = Posed::new(model, &moved.shape, &moved.motion).points();
            DVector::from_column_slice(points[index].coords.as_slice())
        });
        compare(&model.points[index].name, &body.point_jacobian(index), &numeric, tolerance)?;
    }

    for (index, part) in model.parts.iter().enumerate() {
        let part_from_world = body.world_from_part(PartId(index)).transpose();
        let numeric = central_differences(layout.total(), 1e-3, |delta| {
            let moved = layout.retract(state, delta);
            let moved = Posed::new(model, &moved.shape, &moved.motion);
            let r = part_from_world * moved.world_from_part(PartId(index));
            // sin φ · axis, whose slope at no turn is that of φ · axis
            let twice = [r.m32 - r.m23, r.m13 - r.m31, r.m21 - r.m12];
            DVector::from_iterator(3, twice.map(|v| 0.5 * v))
        });
        let analytic = body.rotation_jacobian(PartId(index));
        compare(&part.name, &analytic, &numeric, tolerance)?;
    }

    let mut jacobians = EllipsoidJacobians::new(model);
    jacobians.update(&body, &body.ellipsoids());
    for (index, primitive) in model.ellipsoids.iter().enumerate() {
        let numeric = central_differences(layout.total(), 1e-3, |delta| {
            let moved = layout.retract(state, delta);
            numbers(&Posed::new(model, &moved.shape, &moved.motion).primitive(primitive))
        });
        let mut analytic = DMatrix::zeros(9, layout.total());
        for (column, &component) in jacobians.components[index].iter().enumerate() {
            analytic.set_column(component, &jacobians.values[index].column(column));
        }
        compare(&format!("ellipsoid {index}"), &analytic, &numeric, tolerance)?;
    }

    Ok(())
}

fn numbers(e: &Ellipsoid) -> DVector<f64> {
    DVector::from_iterator(
        9,
        e.centre.iter().copied().chain(Ellipsoid::INDEX.map(|(r, s)| e.shape[(r, s)])),
    )
}

fn compare(
    what: &str,
    analytic: &DMatrix<f64>,
    numeric: &DMatrix<f64>,
    tolerance: f64,
) -> Result<(), KinematicsFault> {
    match first_difference(analytic, numeric, |_| tolerance) {
        None => Ok(()),
        Some((row, component)) => Err(KinematicsFault {
            what: what.to_owned(),
            row,
            component,
            analytic: analytic[(row, component)],
            numeric: numeric[(row, component)],
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sign_error_in_one_row_is_found_and_named() {
        let numeric = DMatrix::from_row_slice(2, 2, &[1.0, 2.0, 3.0, 4.0]);
        let mut analytic = numeric.clone();
        assert_eq!(compare("RKnee", &analytic, &numeric, 1e-9), Ok(()));
        analytic[(1, 0)] = -3.0;
        let fault = compare("RKnee", &analytic, &numeric, 1e-9).unwrap_err();
        assert_eq!(fault.to_string(), "∂(RKnee)[1]/∂δ[0] is -3 and 3 by differences");
    }
}
