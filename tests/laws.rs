//! The law of every problem, `linearize` says what `cost` does: posteriors with every likelihood, and priors.
//!
//! Likelihoods are smooth only piece by piece: the nearest ellipse changes, a distance map is bilinear, an
//! ellipse beyond 12 τ is dropped from the smooth minimum. So the steps are short (1e-6: of a thousand
//! samples less than one crosses a piece's border) and the tolerance is 1e-4 of the largest component for
//! the whole posterior; a wrong derivative is off by far more.

mod ellipsoid_person;

use std::path::Path;

use maquette::body::{BodyModel, Layout, Motion, Posed, Shape, State};
use maquette::camera::Rig;
use maquette::inference::frame::{FramePosterior, KeyframePosterior};
use maquette::inference::prior::{PosePrior, ShapePrior, StepPrior};
use maquette::io::model;
use maquette::likelihood::{
    EllipseDistance, EllipseOptions, EllipseSilhouette, Term, Variant, View,
};
use maquette::silhouette::FrameObservations;
use maquette::solver::{Loss, NormalEquations, Problem, check_linearization};
use nalgebra::{DVector, Rotation3, Unit, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use ellipsoid_person::{human, observe, rig, walk};

const STEP: f64 = 1e-6;
const TOLERANCE: f64 = 1e-4;

/// One frame of the walk, seen by three cameras.
struct Scene {
    model: BodyModel,
    rig: Rig,
    frame: FrameObservations,
    truth: State,
}

impl Scene {
    fn new() -> Self {
        let (model, rig) = (human(), rig(3));
        let shape = Shape(model.statistics.mean.clone());
        let motion = walk(&model, &shape, 10.0, 1).remove(0);
        let frame = observe(&Posed::new(&model, &shape, &motion), &rig, 0);
        let truth = State { motion, shape };
        Self {
            model,
            rig,
            frame,
            truth,
        }
    }

    /// The truth moved by random amounts of this size: metres, radians and coefficients.
    fn moved(&self, size: f64, seed: u64) -> State {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let layout = Layout::of(&self.model);
        let delta = DVector::from_fn(layout.total(), |_, _| size * rng.random_range(-1.0..1.0));
        layout.retract(&self.truth, &delta)
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
            ("ordinary", self.moved(0.05, 40)),
            ("random", self.moved(0.4, 41)),
        ]
    }

    fn terms(&self, options: EllipseOptions) -> Vec<Box<dyn Term + '_>> {
        let mut views = Vec::new();
        for (id, silhouette) in &self.frame.views {
            let camera = self.rig.camera(*id).expect("the rig's own camera");
            views.push(View::new(camera, silhouette, 4.6, 0.03));
        }
        vec![Box::new(EllipseSilhouette::new(views, options))]
    }
}

fn likelihoods() -> Vec<(&'static str, EllipseOptions)> {
    let outline = EllipseOptions::default();
    let of = |distance, back_samples| EllipseOptions {
        distance,
        back_samples,
        ..outline
    };
    let nearest = EllipseOptions {
        variant: Variant::Published,
        ..of(EllipseDistance::Orthogonal, 0)
    };
    let squared = EllipseOptions {
        loss: Loss::Squared,
        ..outline
    };
    vec![
        ("published", EllipseOptions::published()),
        ("nearest, orthogonal", nearest),
        ("gradient", of(EllipseDistance::Gradient, 0)),
        ("gradient and back", of(EllipseDistance::Gradient, 24)),
        ("orthogonal", of(EllipseDistance::Orthogonal, 0)),
        ("orthogonal and back", of(EllipseDistance::Orthogonal, 24)),
        ("radial", of(EllipseDistance::Published, 0)),
        ("radial and back", of(EllipseDistance::Published, 24)),
        ("squared loss", squared),
    ]
}

/// Checks a law for every likelihood in every regime, and names all that break it.
fn check_all(law: impl Fn(&Scene, &[Box<dyn Term + '_>], &State) -> Option<String> + Sync) {
    let scene = Scene::new();
    let broken: Vec<String> = likelihoods()
        .into_par_iter()
        .flat_map_iter(|(name, options)| {
            let terms = scene.terms(options);
            let faults = scene.regimes().into_iter().filter_map(|(regime, state)| {
                Some(format!(
                    "{name}, {regime}: {}",
                    law(&scene, &terms, &state)?
                ))
            });
            faults.collect::<Vec<_>>()
        })
        .collect();
    assert!(broken.is_empty(), "{}", broken.join("\n"));
}

#[test]
fn the_keyframe_posterior_is_linearized_right_with_every_likelihood() {
    check_all(|scene, terms, state| {
        let problem = KeyframePosterior {
            model: &scene.model,
            shape_prior: &ShapePrior::of(&scene.model),
            pose_prior: &PosePrior::of(&scene.model),
            terms,
        };
        let checked = check_linearization(&problem, state, STEP, TOLERANCE);
        checked.err().map(|fault| fault.to_string())
    });
}

#[test]
fn the_frame_posterior_is_linearized_right_with_every_likelihood() {
    check_all(|scene, terms, state| {
        let step = StepPrior::new(&scene.model, 0.02);
        let problem = FramePosterior {
            model: &scene.model,
            shape: &state.shape,
            pose_prior: &PosePrior::of(&scene.model),
            step: Some((&step, &scene.truth.motion)),
            terms,
        };
        let checked = check_linearization(&problem, &state.motion, STEP, TOLERANCE);
        checked.err().map(|fault| fault.to_string())
    });
}

#[test]
fn a_likelihood_alone_has_no_other_gradient_in_the_motion_when_the_shape_is_free() {
    let scene = Scene::new();
    let layout = Layout::of(&scene.model);
    for (_, options) in likelihoods() {
        let state = scene.moved(0.05, 42);
        let body = Posed::new(&scene.model, &state.shape, &state.motion);
        let terms = scene.terms(options);
        let mut all = NormalEquations::zeros(layout.total());
        let mut motion = NormalEquations::zeros(layout.motion());
        terms[0].linearize(&body, &mut all);
        terms[0].linearize(&body, &mut motion);
        let m = layout.motion();
        assert_eq!(all.gradient.rows(0, m), motion.gradient.rows(0, m));
        assert_eq!(all.hessian.view((0, 0), (m, m)), motion.hessian);
    }
}

// --- priors --------------------------------------------------------------------------------------

/// A prior by itself.
struct Prior<'a, C, L> {
    model: &'a BodyModel,
    cost: C,
    linearize: L,
}

impl<C, L> Problem for Prior<'_, C, L>
where
    C: Fn(&State) -> f64,
    L: Fn(&State, &mut NormalEquations) -> f64,
{
    type State = State;
    fn dimension(&self) -> usize {
        Layout::of(self.model).total()
    }
    fn cost(&self, x: &State) -> f64 {
        (self.cost)(x)
    }
    fn linearize(&self, x: &State, equations: &mut NormalEquations) -> f64 {
        (self.linearize)(x, equations)
    }
    fn retract(&self, x: &State, delta: &DVector<f64>) -> State {
        Layout::of(self.model).retract(x, delta)
    }
}

fn shipped() -> Vec<BodyModel> {
    let load = |(name, _): &(&str, &str)| {
        model::load(name, Path::new("")).expect("shipped models are right")
    };
    model::SHIPPED.iter().map(load).collect()
}

/// Rest, 1e-8 from it, and random states up to far beyond every limit.
fn states(model: &BodyModel, sizes: &[f64]) -> Vec<State> {
    let mut rng = ChaCha8Rng::seed_from_u64(43);
    let rest = State {
        motion: Motion::rest(model),
        shape: Shape(model.statistics.mean.clone()),
    };
    let layout = Layout::of(model);
    let mut random = |size: f64| {
        let delta = DVector::from_fn(layout.total(), |_, _| size * rng.random_range(-1.0..1.0));
        layout.retract(&rest, &delta)
    };
    sizes.iter().map(|size| random(*size)).collect()
}

#[test]
fn the_shape_prior_is_linearized_right() {
    for model in shipped() {
        let prior = ShapePrior::of(&model);
        let first = Layout::of(&model).motion();
        let problem = Prior {
            model: &model,
            cost: |x: &State| prior.cost(&x.shape),
            linearize: |x: &State, e: &mut NormalEquations| prior.linearize(&x.shape, first, e),
        };
        for state in states(&model, &[0.0, 1e-8, 0.1, 1.0]) {
            check_linearization(&problem, &state, 1e-3, 1e-8).unwrap();
        }
    }
}

#[test]
fn the_pose_prior_is_linearized_right_within_and_beyond_the_limits() {
    for model in shipped() {
        let prior = PosePrior::of(&model);
        let problem = Prior {
            model: &model,
            cost: |x: &State| prior.cost(&x.motion),
            linearize: |x: &State, e: &mut NormalEquations| prior.linearize(&x.motion, e),
        };
        for state in states(&model, &[0.0, 1e-8, 0.1, 1.0, 4.0]) {
            check_linearization(&problem, &state, 1e-5, 1e-6).unwrap();
        }
        // on a limit, where the barrier begins
        let mut state = states(&model, &[0.0]).remove(0);
        let limits = model.joints.iter().map(|j| j.limits.1);
        state.motion.angles = DVector::from_iterator(model.joints.len(), limits);
        check_linearization(&problem, &state, 1e-7, 1e-4).unwrap();
    }
}

#[test]
fn the_step_prior_is_linearized_right_for_rotations_up_to_nearly_half_a_turn() {
    for model in shipped() {
        let prior = StepPrior::new(&model, 0.02);
        for mean in states(&model, &[0.0, 1.0]) {
            let problem = Prior {
                model: &model,
                cost: |x: &State| prior.cost(&mean.motion, &x.motion),
                linearize: |x: &State, e: &mut NormalEquations| {
                    prior.linearize(&mean.motion, &x.motion, e)
                },
            };
            let layout = Layout::of(&model);
            for angle in [0.0, 1e-8, 0.3, 1.5, 3.0] {
                let mut delta = DVector::zeros(layout.total());
                delta.rows_mut(0, layout.motion()).fill(0.1 * angle);
                if layout.root() == 6 {
                    let axis = Unit::new_normalize(Vector3::new(1.0, -2.0, 0.5));
                    delta.fixed_rows_mut::<3>(3).copy_from(&(*axis * angle));
                }
                let state = layout.retract(&mean, &delta);
                check_linearization(&problem, &state, 1e-4, 1e-6).unwrap();
            }
        }
    }
}
