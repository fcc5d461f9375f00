//! The laws of the metaball field, against differences and against automatic differentiation.

mod dual_field;

use std::path::Path;

use maquette::body::metaball::{Field, FieldRow, FieldSlopes, check_field};
use maquette::body::{BodyModel, Layout, Motion, PartId, Posed, Shape, State};
use maquette::io::model;
use nalgebra::{DVector, Point3, Rotation3, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use dual_field::DualField;

/// Against automatic differentiation: of the largest entry of a row.
const EXACT: f64 = 1e-9;
/// Against differences.
const NUMERIC: f64 = 1e-6;

fn models() -> Vec<BodyModel> {
    let load = |(name, _): &(&str, &str)| {
        model::load(name, Path::new("")).expect("shipped models are right")
    };
    let all = model::SHIPPED.iter().map(load);
    all.filter(|m| !m.metaballs.is_empty()).collect()
}

fn at_rest(model: &BodyModel) -> State {
    State { motion: Motion::rest(model), shape: Shape(model.statistics.mean.clone()) }
}

/// At rest, straight, with angles of 1e-8, and in random poses and shapes.
fn states(model: &BodyModel) -> Vec<State> {
    let mut rng = ChaCha8Rng::seed_from_u64(70);
    let layout = Layout::new(model);
    let mut straight = at_rest(model);
    straight.motion.angles.fill(0.0);
    let mut tiny = straight.clone();
    tiny.motion.angles.fill(1e-8);
    tiny.motion.world_from_root = Rotation3::from_scaled_axis(Vector3::repeat(1e-8));
    let mut states = vec![at_rest(model), straight, tiny];
    for size in [0.2, 0.6] {
        let delta = DVector::from_fn(layout.total(), |_, _| size * rng.random_range(-1.0..1.0));
        states.push(layout.retract(&at_rest(model), &delta));
    }
    states
}

/// A metaball's centre, points around the skin, and points so far that F underflows.
fn points(field: &Field, rng: &mut ChaCha8Rng) -> Vec<Point3<f64>> {
    let any = |rng: &mut ChaCha8Rng| {
        let ball = &field.metaballs[rng.random_range(0..field.metaballs.len())];
        ball.ellipsoid.centre
    };
    let mut points = vec![any(rng)];
    for reach in [0.1, 0.1, 0.3, 3.0, 30.0] {
        let aside = Vector3::from_fn(|_, _| rng.random_range(-1.0..1.0));
        points.push(any(rng) + aside * reach);
    }
    points.into_iter().map(Point3::from).collect()
}

fn every_case(mut check: impl FnMut(&BodyModel, &State, &Point3<f64>)) {
    let mut rng = ChaCha8Rng::seed_from_u64(71);
    for model in models() {
        for state in states(&model) {
            let field = Field::from_body(&Posed::new(&model, &state.shape, &state.motion));
            for point in points(&field, &mut rng) {
                check(&model, &state, &point);
            }
        }
    }
}

#[test]
fn derivatives_are_those_of_differences() {
    every_case(|model, state, point| check_field(model, state, point, NUMERIC).unwrap());
}

#[test]
fn derivatives_are_those_of_automatic_differentiation() {
    every_case(|model, state, point| against_dual_numbers(model, state, point).unwrap());
}

#[test]
fn derivatives_hold_with_two_metaballs_in_one_place() {
    for mut model in models() {
        let doubled = model.metaballs.clone();
        model.metaballs.extend(doubled);
        let state = states(&model).remove(3);
        let field = Field::from_body(&Posed::new(&model, &state.shape, &state.motion));
        for ball in field.metaballs.iter().step_by(5) {
            let beside = ball.ellipsoid.centre + Vector3::new(0.02, 0.0, -0.01);
            for point in [ball.ellipsoid.centre, beside] {
                check_field(&model, &state, &point.into(), NUMERIC).unwrap();
                against_dual_numbers(&model, &state, &point.into()).unwrap();
            }
        }
    }
}

#[test]
fn a_wrong_radius_slope_is_caught() {
    for mut model in models() {
        let state = at_rest(&model);
        let centre = {
            let field = Field::from_body(&Posed::new(&model, &state.shape, &state.motion));
            field.metaballs[0].ellipsoid.centre
        };
        let point = Point3::from(centre + Vector3::new(0.03, 0.02, 0.01));
        against_dual_numbers(&model, &state, &point).unwrap();
        // the analytic side sees another model than the dual numbers
        let truth = model.clone();
        model.metaballs[0].radii.value.x *= 1.0 + 1e-6;
        let fault = compare(&model, &truth, &state, &point).unwrap_err();
        assert!(fault.contains("ln F"), "{fault}");
    }
}

#[test]
fn the_pelvis_belongs_to_both_legs_and_the_trunk() {
    let model = model::load("walker-metaballs", Path::new("")).unwrap();
    let named = |name: &str| PartId(model.parts.iter().position(|p| p.name == name).unwrap());
    let limbs = model.limbs();
    let with = |name: &str| limbs.iter().filter(|l| l.contains(&named(name))).count();
    assert_eq!((with("pelvis"), with("thorax"), with("abdomen")), (3, 4, 1));
    assert_eq!(limbs.len(), 6);
}

fn against_dual_numbers(
    model: &BodyModel,
    state: &State,
    point: &Point3<f64>,
) -> Result<(), String> {
    compare(model, model, state, point)
}

/// Compares every first and second derivative of ln F of `model` with those of `truth`.
fn compare(
    model: &BodyModel,
    truth: &BodyModel,
    state: &State,
    point: &Point3<f64>,
) -> Result<(), String> {
    let body = Posed::new(model, &state.shape, &state.motion);
    let field = Field::from_body(&body);
    let slopes = FieldSlopes::new(&body, &field);
    let sample = field.sample(&point.coords).expect("there are metaballs");
    let dual = DualField::new(truth, state, point, sample.limb);
    // in space
    let log_hessian = sample.log_hessian(&field);
    let curvature = log_hessian.amax();
    for k in 0..3 {
        for l in 0..3 {
            let exact = dual.space_space(k, l);
            let scale = sample.log_gradient.amax();
            close(&format!("∂x{k} ln F"), sample.log_gradient[k], exact.eps1, scale)?;
            let found = log_hessian[(k, l)];
            close(&format!("∂x{k}∂x{l} ln F"), found, exact.eps1eps2, curvature)?;
        }
    }
    // in the state
    let mut row = FieldRow::default();
    let total = Layout::new(model).total();
    for k in 0..3 {
        let mut analytic = vec![(0.0, 0.0); total];
        slopes.row(&sample, |_| 1.0, &Vector3::zeros(), &mut row);
        for (&c, &value) in slopes.components(sample.limb).iter().zip(&row.values) {
            analytic[c].0 = value;
        }
        slopes.row(&sample, |_| 0.0, &Vector3::ith(k, 1.0), &mut row);
        for (&c, &value) in slopes.components(sample.limb).iter().zip(&row.values) {
            analytic[c].1 = value;
        }
        let largest = |of: fn(&(f64, f64)) -> f64| analytic.iter().map(of).fold(1.0, f64::max);
        let scales = (largest(|a| a.0.abs()), largest(|a| a.1.abs()));
        for (c, (first, second)) in analytic.iter().enumerate() {
            let exact = dual.space_state(k, c);
            close(&format!("∂δ{c} ln F"), *first, exact.eps2, scales.0)?;
            close(&format!("∂x{k}∂δ{c} ln F"), *second, exact.eps1eps2, scales.1)?;
        }
    }
    Ok(())
}

fn close(what: &str, found: f64, exact: f64, scale: f64) -> Result<(), String> {
    let is_close = (found - exact).abs() <= EXACT * scale.max(1.0);
    is_close.then_some(()).ok_or_else(|| format!("{what} is {found}, should be {exact}"))
}
