//! The law of every problem, `linearize` says what `cost` does, for the likelihoods of the metaball field.
//!
//! The limb that is largest changes from state to state, and with it the piece of the cost. So, as in `laws.rs`, a
//! law is broken only if it fails at each of three states a hair apart.

#[allow(
    dead_code,
    reason = "this person is of metaballs, and rendered otherwise"
)]
mod ellipsoid_person;

use std::path::Path;

use maquette::body::metaball::Field;
use maquette::body::{BodyModel, Layout, Posed, Shape, State};
use maquette::camera::Rig;
use maquette::inference::frame::{FramePosterior, KeyframePosterior};
use maquette::inference::prior::{PosePrior, ShapePrior, StepPrior};
use maquette::io::model;
use maquette::likelihood::{Derivatives, RayOptions, RayView, Residual, SilhouetteRays, Term};
use maquette::render::silhouette;
use maquette::silhouette::{Silhouette, SilhouetteOptions, extract};
use maquette::solver::{LinearizationFault, Loss, NormalEquations, Problem, check_linearization};
use nalgebra::{DVector, Rotation3, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use ellipsoid_person::{rig, walk};

const STEP: f64 = 1e-5;
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
        let field = Field::of(&Posed::new(&model, &shape, &motion));
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
        let layout = Layout::of(&self.model);
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
        let views = views.map(|((_, camera), seen)| RayView::new(camera, seen, 4.6, 0.05));
        SilhouetteRays::new(views.collect(), options, self.model.field_ceiling())
    }

    fn terms(&self) -> Vec<(&'static str, Box<dyn Term>)> {
        let metric = RayOptions::default();
        let field = RayOptions {
            residual: Residual::Field,
            ..metric
        };
        let squared = RayOptions {
            loss: Loss::Squared,
            ..metric
        };
        vec![
            ("rays, metric", Box::new(self.rays(metric))),
            ("rays, field", Box::new(self.rays(field))),
            ("rays, squared", Box::new(self.rays(squared))),
        ]
    }
}

/// Checks a law for every likelihood in every regime, and names all that break it.
fn check_all(law: impl Fn(&Scene, &[Box<dyn Term>], &State) -> Result<(), LinearizationFault>) {
    let scene = Scene::new();
    let mut broken = Vec::new();
    for (name, term) in scene.terms() {
        let terms = [term];
        for (regime, state) in scene.regimes() {
            let states = [
                state.clone(),
                scene.displaced(&state, HAIR, 50),
                scene.displaced(&state, HAIR, 51),
            ];
            let faults = states.iter().map(|s| law(&scene, &terms, s).err());
            if let Some(faults) = faults.collect::<Option<Vec<_>>>() {
                broken.push(format!("{name}, {regime}: {}", faults[0]));
            }
        }
    }
    assert!(broken.is_empty(), "{}", broken.join("\n"));
}

/// A term alone, all components free.
struct Alone<'a> {
    model: &'a BodyModel,
    term: &'a dyn Term,
}

impl Problem for Alone<'_> {
    type State = State;

    fn dimension(&self) -> usize {
        Layout::of(self.model).total()
    }

    fn cost(&self, x: &State) -> f64 {
        self.term.cost(&Posed::new(self.model, &x.shape, &x.motion))
    }

    fn linearize(&self, x: &State, equations: &mut NormalEquations) -> f64 {
        let body = Posed::new(self.model, &x.shape, &x.motion);
        self.term.linearize(&body, equations)
    }

    fn retract(&self, x: &State, delta: &DVector<f64>) -> State {
        Layout::of(self.model).retract(x, delta)
    }
}

#[test]
fn every_term_is_linearized_right_by_itself() {
    check_all(|scene, terms, state| {
        let alone = Alone {
            model: &scene.model,
            term: terms[0].as_ref(),
        };
        check_linearization(&alone, state, STEP, TOLERANCE)
    });
}

#[test]
fn the_keyframe_posterior_is_linearized_right_with_every_term() {
    check_all(|scene, terms, state| {
        let problem = KeyframePosterior {
            model: &scene.model,
            shape_prior: &ShapePrior::of(&scene.model),
            pose_prior: &PosePrior::of(&scene.model),
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
            pose_prior: &PosePrior::of(&scene.model),
            step: Some((&step, &scene.truth.motion)),
            terms,
        };
        check_linearization(&problem, &state.motion, STEP, TOLERANCE)
    });
}

#[test]
fn first_order_derivatives_break_the_law() {
    let scene = Scene::new();
    let first_order = scene.rays(RayOptions {
        derivatives: Derivatives::FirstOrder,
        ..RayOptions::default()
    });
    let state = scene.displaced(&scene.truth, 0.05, 40);
    let alone = Alone {
        model: &scene.model,
        term: &first_order,
    };
    let fault = check_linearization(&alone, &state, STEP, TOLERANCE).unwrap_err();
    assert!(
        matches!(fault, LinearizationFault::Gradient { .. }),
        "{fault}"
    );
}

#[test]
fn a_term_has_no_other_gradient_in_the_motion_when_the_shape_is_free() {
    let scene = Scene::new();
    let layout = Layout::of(&scene.model);
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
    assert!(residuals.len() > 100, "{}", residuals.len());
    let mut sizes: Vec<f64> = residuals.iter().map(|r| r.residual_m.abs()).collect();
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
    let mut equations = NormalEquations::zeros(Layout::of(&scene.model).total());
    scene
        .rays(RayOptions::default())
        .linearize(&body, &mut equations);
    // downhill is back
    assert!(equations.gradient[1] > 0.0, "{}", equations.gradient[1]);
}
