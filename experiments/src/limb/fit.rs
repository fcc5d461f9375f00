//! Fitting an arm to one frame, with some of its components held.

use maquette::body::{BodyModel, Layout, Motion, Posed, Shape, State};
use maquette::inference::frame::KeyframePosterior;
use maquette::inference::prior::{PosePrior, ShapePrior};
use maquette::likelihood::Term;
use maquette::math::central_differences;
use maquette::solver::{NormalEquations, Options, Problem, Solution, levenberg_marquardt};
use nalgebra::{DVector, Point3};

use super::measure::joints;

/// Which components of the state are optimised.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Freedom {
    /// Pose and shape.
    All,
    /// Pose, and the coefficients that move joints: the skeleton.
    Skeleton,
    /// The coefficients that move no joint: the sizes of the primitives.
    Sizes,
}

/// The posterior of one frame.
pub struct LimbFit<'a> {
    /// Terms and priors.
    pub posterior: KeyframePosterior<'a>,
    /// Components that stay.
    held: Vec<bool>,
}

impl std::fmt::Debug for LimbFit<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "LimbFit({:?}, held {:?})", self.posterior, self.held)
    }
}

impl<'a> LimbFit<'a> {
    /// The posterior of a model given terms.
    pub fn new(
        model: &'a BodyModel,
        priors: (&'a ShapePrior, &'a PosePrior),
        terms: &'a [Box<dyn Term + 'a>],
    ) -> Self {
        Self {
            held: vec![false; Layout::new(model).total()],
            posterior: KeyframePosterior {
                model,
                shape_prior: priors.0,
                pose_prior: priors.1,
                terms,
            },
        }
    }

    /// Holds the other components.
    pub fn free(mut self, freedom: Freedom) -> Self {
        let model = self.posterior.model;
        let layout = Layout::new(model);
        let moving = coefficients_of_joints(model);
        for (component, held) in self.held.iter_mut().enumerate() {
            let is_size = component
                .checked_sub(layout.motion())
                .is_some_and(|coefficient| !moving[coefficient]);
            *held = match freedom {
                Freedom::All => false,
                Freedom::Skeleton => is_size,
                Freedom::Sizes => !is_size,
            };
        }
        self
    }

    /// Minimum from a start.
    pub fn solve(&self, start: State, max_iterations: usize) -> Solution<State, NormalEquations> {
        let options = Options { max_iterations, relative_decrease: 1e-6, ..Options::default() };
        levenberg_marquardt(self, start, &options)
    }
}

/// Whether each coefficient is read by a joint's translation.
fn coefficients_of_joints(model: &BodyModel) -> Vec<bool> {
    let mut moving = vec![false; model.coefficients.len()];
    let points = model.points.iter().flat_map(|p| &p.places);
    let translations = model.joints.iter().map(|joint| &joint.translation);
    for vector in translations.chain(points.map(|(_, place)| place)) {
        for coefficient in vector.coefficients() {
            moving[coefficient.0] = true;
        }
    }
    moving
}

impl Problem for LimbFit<'_> {
    type State = State;
    type Model = NormalEquations;

    fn empty_model(&self) -> NormalEquations {
        NormalEquations::zeros(self.held.len())
    }

    fn cost(&self, x: &State) -> f64 {
        self.posterior.cost(x)
    }

    fn linearize(&self, x: &State, equations: &mut NormalEquations) -> f64 {
        let cost = self.posterior.linearize(x, equations);
        for (i, _) in self.held.iter().enumerate().filter(|(_, held)| **held) {
            equations.gradient[i] = 0.0;
            equations.hessian.row_mut(i).fill(0.0);
            equations.hessian.column_mut(i).fill(0.0);
            equations.hessian[(i, i)] = 1.0;
        }
        cost
    }

    fn retract(&self, x: &State, delta: &DVector<f64>) -> State {
        self.posterior.retract(x, delta)
    }
}

/// p(s) with every standard deviation so many times as large.
pub fn widened(model: &BodyModel, factor: f64) -> ShapePrior {
    let mut wide = model.clone();
    wide.statistics.covariance *= factor * factor;
    ShapePrior::new(&wide)
}

/// The motion that brings a model's shoulder, elbow and wrist nearest to given ones.
pub fn aligned(model: &BodyModel, shape: &Shape, targets: &[Point3<f64>; 3]) -> Motion {
    let problem = Alignment { model, shape, targets, prior: PosePrior::new(model) };
    let options = Options { max_iterations: 200, relative_decrease: 1e-9, ..Options::default() };
    // from several turns: half a turn away the gradient vanishes
    let starts = (0..6).map(|k| {
        let mut motion = Motion::rest(model);
        motion.position_world = targets[0].coords;
        let axis = nalgebra::Vector3::ith(k % 3, if k < 3 { 1.5 } else { -1.5 });
        motion.world_from_root = nalgebra::Rotation3::from_scaled_axis(axis);
        levenberg_marquardt(&problem, motion, &options)
    });
    let best = starts.min_by(|a, b| a.cost.total_cmp(&b.cost));
    best.map_or_else(|| Motion::rest(model), |solution| solution.state)
}

struct Alignment<'a> {
    model: &'a BodyModel,
    shape: &'a Shape,
    targets: &'a [Point3<f64>; 3],
    prior: PosePrior,
}

/// Standard deviation of a joint in an alignment, metres.
const JOINT_SD: f64 = 0.002;

impl Alignment<'_> {
    fn offsets(&self, motion: &Motion) -> DVector<f64> {
        let found = joints(&Posed::new(self.model, self.shape, motion));
        let each = found.iter().zip(self.targets);
        let offsets = each.flat_map(|(a, b)| ((a - b) / JOINT_SD).data.0[0]);
        DVector::from_vec(offsets.collect())
    }
}

impl Problem for Alignment<'_> {
    type State = Motion;
    type Model = NormalEquations;

    fn empty_model(&self) -> NormalEquations {
        NormalEquations::zeros(Layout::new(self.model).motion())
    }

    fn cost(&self, x: &Motion) -> f64 {
        0.5 * self.offsets(x).norm_squared() + self.prior.cost(x)
    }

    fn linearize(&self, x: &Motion, equations: &mut NormalEquations) -> f64 {
        let offsets = self.offsets(x);
        let slopes = central_differences(equations.gradient.len(), 1e-4, |d| {
            self.offsets(&self.retract(x, d))
        });
        equations.gradient += slopes.transpose() * &offsets;
        equations.hessian += slopes.transpose() * &slopes;
        0.5 * offsets.norm_squared() + self.prior.linearize(x, equations)
    }

    fn retract(&self, x: &Motion, delta: &DVector<f64>) -> Motion {
        Layout::new(self.model).retract_motion(x, delta)
    }
}
