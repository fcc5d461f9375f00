//! The law of kinematics: its Jacobians are the derivatives of its positions.

use nalgebra::{DMatrix, DVector};

use super::{BodyModel, EllipsoidJacobians, Layout, PartId, Posed, State};
use crate::math::quadric::Ellipsoid;
use crate::math::{DerivativeFault, central_differences, compare_derivatives};

/// Checks the Jacobians of every exported point, keypoint, part and ellipsoid of a model at a state.
///
/// # Errors
/// The first entry that is off by more than `tolerance` (absolute, metres or square metres per unit).
pub fn check_kinematics(
    model: &BodyModel,
    state: &State,
    tolerance: f64,
) -> Result<(), DerivativeFault> {
    let layout = Layout::new(model);
    let body = Posed::new(model, &state.shape, &state.motion);

    for point in model.points.iter().chain(&model.keypoints) {
        let numeric = central_differences(layout.total(), 1e-3, |delta| {
            let moved = layout.retract(state, delta);
            let at = Posed::new(model, &moved.shape, &moved.motion).named_point(point);
            DVector::from_column_slice(at.coords.as_slice())
        });
        compare(&point.name, &body.named_point_jacobian(point), &numeric, tolerance)?;
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
) -> Result<(), DerivativeFault> {
    let names = |row, component| [format!("({what})[{row}]"), format!("δ[{component}]")];
    compare_derivatives(analytic, numeric, |_| tolerance, names)
}
