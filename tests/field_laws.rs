//! The law of every problem, `linearize` says what `cost` does, for the likelihoods of the metaball field.
//!
//! The limb that is largest changes from state to state, and with it the piece of the cost. So, as in `laws.rs`, a
//! law is broken only if it fails at each of three states a hair apart.

#[allow(dead_code, reason = "this person is of metaballs, and rendered otherwise")]
mod ellipsoid_person;

use std::path::Path;

use maquette::body::metaball::Field;
use maquette::body::{BodyModel, Layout, Posed, Shape, State};
use maquette::camera::Rig;
use maquette::inference::frame::{FramePosterior, KeyframePosterior};
use maquette::inference::prior::{PosePrior, ShapePrior};
use maquette::inference::step::StepPrior;
use maquette::io::model;
use maquette::likelihood::{
    Derivatives, PointField, PointOptions, PointResidual, RayOptions, RayView, Residual,
    SilhouetteRays, SkinScale, SkinTouch, SurfacePoint, Term,
};
use maquette::render::silhouette;
use maquette::silhouette::{Silhouette, SilhouetteOptions, extract};
use maquette::solver::{
    LinearizationFault, Loss, NormalEquations, Options, Problem, check_linearization,
    levenberg_marquardt,
};
use nalgebra::{DVector, Matrix3, Point3, Rotation3, Unit, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use ellipsoid_person::{rig, walk};

// a random body has spots that bend within 4 mm, whose feet longer steps move too far
const STEP: f64 = 3e-6;
/// Of the largest component of the gradient.
const TOLERANCE: f64 = 1e-6;
/// How far the states are apart at which a law is tried.
const HAIR: f64 = 1e-5;

/// One frame of a walk, seen by three cameras.
struct Scene {
    model: BodyModel,
    rig: Rig,
    silhouettes: Vec<Silhouette>,
    truth: State,
}

impl Scene {
    fn new() -> Self {
        let model = model::load("walker-metaballs", Path::new("")).expect("a shipped model");
        let rig = rig(3);
        let shape = Shape(model.statistics.mean.clone());
        let motion = walk(&model, &shape, 10.0, 1).remove(0);
        let field = Field::from_body(&Posed::new(&model, &shape, &motion));
        let seen = |camera| {
            let mask = silhouette(camera, &field);
            extract(&mask, camera, &SilhouetteOptions::default()).expect("the person is seen")
        };
        Self {
            silhouettes: rig.iter().map(|(_, camera)| seen(camera)).collect(),
            truth: State { motion, shape },
            model,
            rig,
        }
    }

    /// The state moved by random amounts of this size: metres, radians and coefficients.
    fn displaced(&self, state: &State, size: f64, seed: u64) -> State {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let layout = Layout::new(&self.model);
        let delta = DVector::from_fn(layout.total(), |_, _| size * rng.random_range(-1.0..1.0));
        layout.retract(state, &delta)
    }

    /// Standing straight where the person is, every angle 1e-8: knees and elbows at their singularity.
    fn straight(&self) -> State {
        let mut state = self.truth.clone();
        state.motion.world_from_root = Rotation3::from_scaled_axis(Vector3::repeat(1e-8));
        state.motion.angles.fill(1e-8);
        state
    }

    fn regimes(&self) -> Vec<(&'static str, State)> {
        vec![
            ("at the truth", self.truth.clone()),
            ("straight", self.straight()),
            ("ordinary", self.displaced(&self.truth, 0.05, 40)),
            ("random", self.displaced(&self.truth, 0.4, 41)),
        ]
    }

    fn rays(&self, options: RayOptions) -> SilhouetteRays {
        let views = self.rig.iter().zip(&self.silhouettes);
        let views = views.map(|((_, camera), seen)| RayView::new(camera, seen, 4.6, 0.1));
        SilhouetteRays::new(views.collect(), options, SkinScale::new(&self.model))
    }

    /// Points on the skin of the truth: rays from each metaball's centre outwards.
    fn surface(&self) -> Vec<SurfacePoint> {
        let mut rng = ChaCha8Rng::seed_from_u64(43);
        let field =
            Field::from_body(&Posed::new(&self.model, &self.truth.shape, &self.truth.motion));
        let mut points = Vec::new();
        for ball in &field.metaballs {
            let centre = ball.ellipsoid.centre;
            let out = Vector3::from_fn(|_, _| rng.random_range(-1.0..1.0));
            let out = Unit::new_normalize(out).into_inner();
            let steps = (0..300).map(|i| centre + out * (1e-3 * f64::from(i)));
            let outside = steps.skip_while(|x| field.value(x) > 0.5);
            let covariance = depth_covariance(&mut rng);
            points.extend(
                outside
                    .take(1)
                    .map(|x| SurfacePoint { position_world: Point3::from(x), covariance }),
            );
        }
        points
    }

    fn posed(&self) -> Posed<'_> {
        Posed::new(&self.model, &self.truth.shape, &self.truth.motion)
    }

    fn points(&self, options: PointOptions) -> PointField {
        PointField::new(self.surface(), options, SkinScale::new(&self.model))
    }

    fn terms(&self) -> Vec<(&'static str, Box<dyn Term>)> {
        let metric = RayOptions::default();
        let field = RayOptions { residual: Residual::Field, ..metric };
        let squared = RayOptions { loss: Loss::Squared, ..metric };
        let worn = RayOptions { outward: 0.25, ..metric };
        let points = PointOptions::default();
        let points_field = PointOptions { residual: PointResidual::Field, ..points };
        vec![
            ("points, distance", Box::new(self.points(points))),
            ("points, field", Box::new(self.points(points_field))),
            ("rays, metric", Box::new(self.rays(metric))),
            ("rays, field", Box::new(self.rays(field))),
            ("rays, squared", Box::new(self.rays(squared))),
            ("rays, of what may be worn", Box::new(self.rays(worn))),
        ]
    }
}

/// That of a point which errs by 20 mm along one direction and by 1 mm across it.
fn depth_covariance(rng: &mut impl RngExt) -> Matrix3<f64> {
    let depth = Vector3::from_fn(|_, _| rng.random_range(-1.0..1.0));
    let depth = Unit::new_normalize(depth).into_inner();
    Matrix3::from_diagonal_element(1e-6) + depth * depth.transpose() * 4e-4
}

/// Checks a law for every likelihood in every regime, and names all that break it.
fn check_all(
    law: impl Fn(&Scene, &[Box<dyn Term>], &State) -> Result<(), LinearizationFault> + Sync,
) {
    let scene = Scene::new();
    let broken: Vec<String> = scene
        .terms()
        .into_par_iter()
        .flat_map_iter(|(name, term)| {
            let terms = [term];
            let regimes = scene.regimes().into_iter();
            let regimes = regimes.filter_map(|(regime, state)| {
                // the next one only if this one fails
                let seeds = [None, Some(50), Some(51)];
                let states =
                    seeds.map(|s| s.map_or(state.clone(), |s| scene.displaced(&state, HAIR, s)));
                let faults = states.iter().map(|s| law(&scene, &terms, s).err());
                let faults: Option<Vec<_>> = faults.collect();
                Some(format!("{name}, {regime}: {}", faults?[0]))
            });
            regimes.collect::<Vec<_>>()
        })
        .collect();
    assert!(broken.is_empty(), "{}", broken.join("\n"));
}

/// A term alone, all components free.
struct Alone<'a> {
    model: &'a BodyModel,
    term: &'a dyn Term,
}

impl Problem for Alone<'_> {
    type State = State;
    type Model = NormalEquations;

    fn empty_model(&self) -> NormalEquations {
        NormalEquations::zeros(Layout::new(self.model).total())
    }

    fn cost(&self, x: &State) -> f64 {
        self.term.cost(&Posed::new(self.model, &x.shape, &x.motion))
    }

    fn linearize(&self, x: &State, equations: &mut NormalEquations) -> f64 {
        let body = Posed::new(self.model, &x.shape, &x.motion);
        self.term.linearize(&body, equations)
    }

    fn retract(&self, x: &State, delta: &DVector<f64>) -> State {
        Layout::new(self.model).retract(x, delta)
    }
}

#[test]
fn every_term_is_linearized_right_by_itself() {
    check_all(|scene, terms, state| {
        let alone = Alone { model: &scene.model, term: terms[0].as_ref() };
        check_linearization(&alone, state, STEP, TOLERANCE)
    });
}

#[test]
fn the_keyframe_posterior_is_linearized_right_with_every_term() {
    check_all(|scene, terms, state| {
        let problem = KeyframePosterior {
            model: &scene.model,
            shape_prior: &ShapePrior::new(&scene.model),
            pose_prior: &PosePrior::new(&scene.model),
            terms,
        };
        check_linearization(&problem, state, STEP, TOLERANCE)
    });
}

#[test]
fn the_frame_posterior_is_linearized_right_with_every_term() {
    check_all(|scene, terms, state| {
        let step = StepPrior::new(&scene.model, 0.02);
        let problem = FramePosterior {
            model: &scene.model,
            shape: &state.shape,
            pose_prior: &PosePrior::new(&scene.model),
            step: Some((&step, &scene.truth.motion)),
            terms,
        };
        check_linearization(&problem, &state.motion, STEP, TOLERANCE)
    });
}

#[test]
fn first_order_derivatives_break_the_law() {
    let scene = Scene::new();
    let first_order =
        scene.rays(RayOptions { derivatives: Derivatives::FirstOrder, ..RayOptions::default() });
    let state = scene.displaced(&scene.truth, 0.05, 40);
    let alone = Alone { model: &scene.model, term: &first_order };
    let fault = check_linearization(&alone, &state, STEP, TOLERANCE).unwrap_err();
    assert!(matches!(fault, LinearizationFault::Gradient { .. }), "{fault}");
}

#[test]
fn a_term_has_no_other_gradient_in_the_motion_when_the_shape_is_free() {
    let scene = Scene::new();
    let layout = Layout::new(&scene.model);
    let state = scene.displaced(&scene.truth, 0.05, 42);
    let body = Posed::new(&scene.model, &state.shape, &state.motion);
    for (_, term) in scene.terms() {
        let mut all = NormalEquations::zeros(layout.total());
        let mut motion = NormalEquations::zeros(layout.motion());
        term.linearize(&body, &mut all);
        term.linearize(&body, &mut motion);
        let m = layout.motion();
        assert_eq!(all.gradient.rows(0, m), motion.gradient.rows(0, m));
        assert_eq!(all.hessian.view((0, 0), (m, m)), motion.hessian);
    }
}

#[test]
fn at_the_truth_lines_of_sight_touch_the_skin_within_a_fraction_of_a_pixel() {
    let scene = Scene::new();
    let State { motion, shape } = &scene.truth;
    let body = Posed::new(&scene.model, shape, motion);
    let residuals = scene.rays(RayOptions::default()).residuals(&body);
    assert!(residuals.len() > 80, "{}", residuals.len());
    let size = |touch: &SkinTouch| touch.residual_m.abs();
    let mut sizes: Vec<f64> = residuals.iter().map(size).collect();
    sizes.sort_by(f64::total_cmp);
    // a pixel is 9 mm there
    let (median, p95) = (sizes[sizes.len() / 2], sizes[sizes.len() * 19 / 20]);
    assert!(median < 2e-3 && p95 < 6e-3, "{median} {p95}");
}

#[test]
fn a_ray_that_misses_the_body_by_a_metre_still_pulls() {
    let scene = Scene::new();
    let mut state = scene.truth.clone();
    state.motion.position_world.y += 1.0;
    let body = Posed::new(&scene.model, &state.shape, &state.motion);
    let mut equations = NormalEquations::zeros(Layout::new(&scene.model).total());
    scene.rays(RayOptions::default()).linearize(&body, &mut equations);
    // downhill is back
    assert!(equations.gradient[1] > 0.0, "{}", equations.gradient[1]);
}

#[test]
fn points_on_the_skin_have_no_residual_and_points_off_it_their_distance() {
    let scene = Scene::new();
    let State { motion, shape } = &scene.truth;
    let body = Posed::new(&scene.model, shape, motion);
    let on_skin = scene.points(PointOptions::default()).residuals(&body);
    assert_eq!(on_skin.len(), scene.surface().len());
    assert!(on_skin.len() > 40);
    // the surface is sampled by the millimetre
    for r in on_skin {
        assert!((-1e-4..1.5e-3).contains(&r.residual_m), "{r:?}");
    }
}

#[test]
fn a_point_errs_by_its_covariance_along_the_normal() {
    let scene = Scene::new();
    let body = scene.posed();
    let field = Field::from_body(&body);
    let options = PointOptions::default();
    let touches = scene.points(options).residuals(&body);
    let mut checked = 0;
    for (point, touch) in scene.surface().iter().zip(&touches) {
        let (value, gradient) = field.value_and_gradient(&touch.place_world.coords);
        // where limbs overlap, another one may be larger there
        if (value - 0.5).abs() < 1e-5 {
            let normal = Unit::new_normalize(gradient).into_inner();
            let variance = normal.dot(&(point.covariance * normal)) + options.sigma_m.powi(2);
            approx::assert_relative_eq!(touch.sigma_m, variance.sqrt(), max_relative = 1e-4);
            checked += 1;
        }
    }
    assert!(checked > 30, "{checked}");
}

/// Mean distance of the exported points from the truth after a fit of the motion, m.
fn error_after_fit(scene: &Scene, term: Box<dyn Term>, start: &State) -> f64 {
    let terms = [term];
    let problem = FramePosterior {
        model: &scene.model,
        shape: &scene.truth.shape,
        pose_prior: &PosePrior::new(&scene.model),
        step: None,
        terms: &terms,
    };
    let options = Options { max_iterations: 30, ..Options::default() };
    let found = levenberg_marquardt(&problem, start.motion.clone(), &options).state;
    let points = |motion| Posed::new(&scene.model, &scene.truth.shape, motion).points();
    let pairs = points(&found).into_iter().zip(points(&scene.truth.motion));
    let distances: Vec<f64> = pairs.map(|(a, b)| (a - b).norm()).collect();
    distances.iter().sum::<f64>() / distances.len() as f64
}

#[test]
fn a_fit_to_lines_of_sight_or_to_points_finds_the_pose() {
    let scene = Scene::new();
    let start = scene.displaced(&scene.truth, 0.1, 44);
    let rays = scene.rays(RayOptions::default());
    let error = error_after_fit(&scene, Box::new(rays), &start);
    assert!(error < 0.02, "rays: {error}");
    let points = scene.points(PointOptions::default());
    let error = error_after_fit(&scene, Box::new(points), &start);
    assert!(error < 0.02, "points: {error}");
}
