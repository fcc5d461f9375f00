//! The law of the field: its derivatives in space and state are those of its value.

use nalgebra::{DMatrix, DVector, Point3, Vector3};

use super::{Field, FieldRow, FieldSample, FieldSlopes};
use crate::body::{BodyModel, Layout, Posed, State};
use crate::math::{DerivativeFault, central_differences, compare_derivatives};

/// Rows of the checked Jacobians.
const ROWS: [&str; 4] = ["ln F", "∂x ln F", "∂y ln F", "∂z ln F"];

/// Step of the differences, metres, radians and coefficients.
const STEP: f64 = 1e-4;

/// Checks ∂/∂x and ∂/∂θ of ln F and ∇ ln F at a state and a point, in the limb whose sum is largest there.
///
/// # Errors
/// The first entry that is off by more than `tolerance` times the largest entry of its row, or times 1 (ln F) or 1/m
/// (its gradient) if that is more.
pub fn check_field(
    model: &BodyModel,
    state: &State,
    point_world: &Point3<f64>,
    tolerance: f64,
) -> Result<(), DerivativeFault> {
    let x = point_world.coords;
    let body = Posed::new(model, &state.shape, &state.motion);
    let field = Field::from_body(&body);
    let Some(sample) = field.sample(&x) else {
        return Ok(());
    };

    let compare = |variable: &str, analytic: &DMatrix<f64>, numeric: &DMatrix<f64>| {
        let names = |row: usize, component| {
            [format!("({})", ROWS[row]), format!("{variable}[{component}] at {point_world}")]
        };
        let scaled = |row| tolerance * numeric.row(row).amax().max(1.0);
        compare_derivatives(analytic, numeric, scaled, names)
    };
    let at = |field: &Field, x: &Vector3<f64>| {
        let mut moved = FieldSample::default();
        moved.update_limb(field, sample.limb, x, &field.limbs[sample.limb]);
        numbers(&moved)
    };

    let numeric =
        central_differences(3, STEP, |d| at(&field, &(x + Vector3::new(d[0], d[1], d[2]))));
    compare("x", &in_space(&field, &sample), &numeric)?;

    let layout = Layout::new(model);
    let numeric = central_differences(layout.total(), STEP, |delta| {
        let moved = layout.retract(state, delta);
        let body = Posed::new(model, &moved.shape, &moved.motion);
        at(&Field::from_body(&body), &x)
    });
    let analytic = in_state(&FieldSlopes::new(&body, &field), &sample, layout.total());
    compare("δ", &analytic, &numeric)
}

fn numbers(sample: &FieldSample) -> DVector<f64> {
    let gradient = sample.log_gradient.iter().copied();
    DVector::from_iterator(4, std::iter::once(sample.log_value).chain(gradient))
}

fn in_space(field: &Field, sample: &FieldSample) -> DMatrix<f64> {
    let log_hessian = sample.log_hessian(field);
    DMatrix::from_fn(4, 3, |row, k| match row.checked_sub(1) {
        None => sample.log_gradient[k],
        Some(i) => log_hessian[(i, k)],
    })
}

fn in_state(slopes: &FieldSlopes, sample: &FieldSample, total: usize) -> DMatrix<f64> {
    let mut jacobian = DMatrix::zeros(4, total);
    let mut row = FieldRow::default();
    for i in 0..4 {
        match i {
            0 => slopes.row(sample, |_| 1.0, &Vector3::zeros(), &mut row),
            _ => slopes.row(sample, |_| 0.0, &Vector3::ith(i - 1, 1.0), &mut row),
        }
        for (&component, &value) in slopes.components(sample.limb).iter().zip(&row.values) {
            jacobian[(i, component)] = value;
        }
    }
    jacobian
}
