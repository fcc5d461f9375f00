//! The sequence posterior, ZS06 eq. 1, of all motions and the shape at once.
//!
//! E(s, m₁..ₙ, c) = −log p(s) − log p(c) + Σᵢ \[−w log p(Zᵢ | mᵢ, s, c) + E_d\] − ω log p(m₁..ₙ)
//!
//! A frame's terms touch its own motion and the shape, a motion's factor touches its neighbours: g and H are a
//! [`BorderedChain`] with the shape as border, and after it the cameras c where they are unknowns. w is how often the data count
//! ([`super::noise`]), ω how often what is known of motions does ([`super::motion_prior`]), and E_d what the differences between cameras side by
//! side say beyond that ([`super::contrasts`]).
//!
//! What one camera shows is a [`Look`] at a body that is moved by the camera's offset and its clock: `look_sum.rs`.

use nalgebra::DVector;
use rayon::prelude::*;

use super::camera_offset::CameraOffset;
use super::camera_prior::CameraPrior;
use super::contrasts::Contrasts;
use super::frame::{FrameFit, data_cost, linearize_data, observations};
use super::instant::{Instant, times_s, trials};
use super::look_sum::{LookSum, Placed, REACH, Unknown};
use super::motion_prior::MotionPrior;
use super::noise::DataWeights;
use super::prior::ShapePrior;
use super::sequence_state::SequenceState;
use super::{Kind, Look};
use crate::body::{BodyModel, Layout, Motion, Posed, Shape};
use crate::camera::Rig;
use crate::solver::{BorderedChain, NormalEquations, Problem};

/// −log p(s, m₁..ₙ, c | Z₁..ₙ) (eq. 1).
pub struct SequencePosterior<'a> {
    /// The body.
    pub model: &'a BodyModel,
    /// The cameras, as they are calibrated.
    pub rig: &'a Rig,
    /// p(c).
    pub camera_prior: &'a CameraPrior,
    /// p(s).
    pub shape_prior: &'a ShapePrior,
    /// p(m₁..ₙ), with ω.
    pub motion_prior: &'a MotionPrior,
    /// Seconds from the frame before, infinitely many where another trial begins; the first is not read: p(m₁) counts whole.
    pub seconds: &'a [f64],
    /// p(Zᵢ | mᵢ, s, c), frame by frame.
    pub looks: &'a [Vec<&'a Look<'a>>],
    /// How many times the data's cost counts: observations that err more, or more together, count less.
    pub weights: DataWeights,
    /// E_d.
    pub contrasts: &'a Contrasts,
}

/// Frames that are summed one after the other, so that sums do not depend on the number of threads.
const CHUNK: usize = 8;

impl SequencePosterior<'_> {
    /// The camera of a look, where it is an unknown.
    fn camera(&self, x: &SequenceState, look: &Look<'_>) -> Option<Unknown<'_>> {
        let index = look.camera?;
        Some(Unknown {
            offset: *x.cameras.get(index)?,
            rows: self.camera_prior.rows(index),
            free: self.camera_prior.free(index),
            calibrated: &self.rig.cameras[index],
        })
    }

    /// Every look, frame by frame.
    fn in_frames(&self, x: &SequenceState) -> Vec<Placed<'_>> {
        let layout = Layout::new(self.model);
        let (times_s, trials) = (times_s(self.seconds), trials(self.seconds));
        let place = |(recorded, look): (usize, _)| {
            let camera = self.camera(x, look);
            let instant = match &camera {
                Some(camera) if camera.free.clock => {
                    let time_s = times_s[recorded] + camera.offset.ahead_s;
                    let trial = trials[recorded].clone();
                    let (motions, times_s) = (&x.motions[trial.clone()], &times_s[trial.clone()]);
                    Instant::at(layout, motions, times_s, time_s).after(trial.start)
                }
                _ => Instant::of_frame(&x.motions, recorded),
            };
            let seen = match &camera {
                Some(camera) if camera.free.pose => {
                    camera.offset.seen(camera.calibrated, &instant.motion)
                }
                _ => instant.motion.clone(),
            };
            Placed { recorded, look, camera, instant, seen }
        };
        let looks = self.looks.iter().enumerate();
        let looks = looks.flat_map(|(i, looks)| looks.iter().map(move |look| (i, *look)));
        looks.map(place).collect()
    }

    /// Every look, by the frames about which it is.
    fn placed(&self, x: &SequenceState) -> Vec<Placed<'_>> {
        let mut placed = self.in_frames(x);
        placed.sort_by_key(Placed::middle);
        placed
    }

    /// The body as every look sees it, frame by frame.
    pub(super) fn bodies<'s>(&'s self, x: &'s SequenceState) -> Vec<Posed<'s>> {
        let posed = |placed: Placed<'_>| Posed::new(self.model, &x.shape, &placed.seen);
        self.in_frames(x).into_iter().map(posed).collect()
    }

    /// −log p of what a look shows, with E_d.
    fn look_cost(&self, x: &SequenceState, placed: &Placed<'_>) -> f64 {
        let body = Posed::new(self.model, &x.shape, &placed.seen);
        self.weight(placed) * data_cost(&placed.look.terms, &body)
            + self.contrast_cost(placed, &body)
    }

    fn contrast_cost(&self, placed: &Placed<'_>, body: &Posed<'_>) -> f64 {
        match self.has_contrasts(placed) {
            true => self.contrasts.cost(placed.recorded, body),
            false => 0.0,
        }
    }

    /// What cameras side by side see differently is told of the outlines of all.
    fn has_contrasts(&self, placed: &Placed<'_>) -> bool {
        let Look { camera, kind, .. } = placed.look;
        camera.is_none() && *kind == Kind::Outlines && self.contrasts.has(placed.recorded)
    }

    /// w of what a look shows.
    fn weight(&self, placed: &Placed<'_>) -> f64 {
        self.weights.of(placed.look.kind)
    }

    /// Sums the looks about a run of frames.
    fn linearize_chunk(&self, x: &SequenceState, placed: &[Placed<'_>]) -> LookSum {
        let layout = Layout::new(self.model);
        let (m, n) = (layout.motion(), layout.total());
        let shared = n - m + self.camera_prior.components();
        let mut sum = LookSum::new(placed, m, shared);

        // blocks of the motion and of motion and shape look by look, of the shape all of one weight together
        let [mut outlines, mut points, mut keypoints, mut of_contrasts] =
            [0; 4].map(|_| NormalEquations::zeros(n));
        for look in placed {
            let body = Posed::new(self.model, &x.shape, &look.seen);
            let (weight, equations) = (
                self.weight(look),
                match look.look.kind {
                    Kind::Outlines => &mut outlines,
                    Kind::Points => &mut points,
                    Kind::Keypoints => &mut keypoints,
                },
            );
            clear_motion(equations, m);
            sum.cost += weight * linearize_data(&look.look.terms, &body, equations);
            sum.carry(look, equations, weight);
            if self.has_contrasts(look) {
                clear_motion(&mut of_contrasts, m);
                sum.cost += self.contrasts.linearize(look.recorded, &body, &mut of_contrasts);
                sum.carry(look, &of_contrasts, 1.0);
            }
        }
        sum.add_shape(&outlines, self.weights.outlines);
        sum.add_shape(&points, self.weights.points);
        sum.add_shape(&keypoints, self.weights.keypoints);
        sum.add_shape(&of_contrasts, 1.0);
        sum
    }

    /// The fit of every frame; the data's cost has weight 1.
    pub(super) fn frame_fits(&self, x: &SequenceState) -> Vec<FrameFit> {
        let placed = self.placed(x);
        let cost = |look: &Placed<'_>| {
            let body = Posed::new(self.model, &x.shape, &look.seen);
            (look.recorded, data_cost(&look.look.terms, &body))
        };
        let costs: Vec<(usize, f64)> = placed.par_iter().map(cost).collect();
        let mut data = vec![0.0; x.motions.len()];
        costs.into_iter().for_each(|(i, cost)| data[i] += cost);

        let one = |(i, motion): (usize, &Motion)| {
            let (pose, step) = self.motion_prior.costs(&x.motions, self.seconds, i);
            FrameFit {
                motion: motion.clone(),
                data: data[i],
                pose,
                step,
                observations: self.looks[i].iter().map(|look| observations(&look.terms)).sum(),
                recovered: false,
            }
        };
        x.motions.iter().enumerate().map(one).collect()
    }

    /// The priors' part of E but for the shape's: of each motion, of the steps and of the cameras.
    fn prior_cost(&self, x: &SequenceState) -> f64 {
        self.motion_prior.cost(&x.motions, self.seconds) + self.camera_prior.cost(&x.cameras)
    }

    /// The priors' part of g and H, added to the chain: of each motion, of what they share and of the steps.
    pub(super) fn linearize_priors(&self, x: &SequenceState, model: &mut BorderedChain) -> f64 {
        let mut cost = self.motion_prior.linearize(&x.motions, self.seconds, &mut model.links);

        // what they share: the shape and the cameras
        let mut corner = NormalEquations::zeros(model.corner_gradient.len());
        cost += self.shape_prior.linearize(&x.shape, 0, &mut corner);
        cost += self.camera_prior.linearize(&x.cameras, x.shape.0.len(), &mut corner);
        model.corner += corner.hessian;
        model.corner_gradient += corner.gradient;
        cost
    }
}

/// Clears all but the block of the shape.
fn clear_motion(equations: &mut NormalEquations, m: usize) {
    equations.hessian.columns_mut(0, m).fill(0.0);
    equations.gradient.rows_mut(0, m).fill(0.0);
}

impl Problem for SequencePosterior<'_> {
    type State = SequenceState;
    type Model = BorderedChain;

    fn empty_model(&self) -> BorderedChain {
        let layout = Layout::new(self.model);
        let shared = layout.total() - layout.motion() + self.camera_prior.components();
        let of_clocks = if self.camera_prior.has_clocks() { REACH } else { 0 };
        let reach = self.motion_prior.reach().max(of_clocks);
        BorderedChain::zeros(self.looks.len(), layout.motion(), shared, reach)
    }

    fn cost(&self, x: &SequenceState) -> f64 {
        let placed = self.placed(x);
        let looks: Vec<f64> = placed.par_iter().map(|look| self.look_cost(x, look)).collect();
        looks.into_iter().sum::<f64>() + self.prior_cost(x) + self.shape_prior.cost(&x.shape)
    }

    fn linearize(&self, x: &SequenceState, model: &mut BorderedChain) -> f64 {
        let placed = self.placed(x);
        let chunks: Vec<_> =
            placed.chunk_by(|a, b| a.middle() / CHUNK == b.middle() / CHUNK).collect();
        let sums: Vec<LookSum> =
            chunks.into_par_iter().map(|chunk| self.linearize_chunk(x, chunk)).collect();
        let mut cost = 0.0;
        for sum in sums {
            cost += sum.cost;
            sum.add_to(model);
        }
        cost + self.linearize_priors(x, model)
    }

    fn retract(&self, x: &SequenceState, delta: &DVector<f64>) -> SequenceState {
        let layout = Layout::new(self.model);
        let (m, p) = (layout.motion(), x.shape.0.len());
        let motion = |(i, motion): (usize, &Motion)| {
            layout.retract_motion(motion, &delta.rows(i * m, m).into_owned())
        };
        let shared = delta.rows_range(x.motions.len() * m..);
        let camera = |(c, camera): (usize, &CameraOffset)| {
            camera.retract(&self.camera_prior.rows(c).of(&shared.rows_range(p..)))
        };
        SequenceState {
            shape: Shape(&x.shape.0 + shared.rows(0, p)),
            motions: x.motions.iter().enumerate().map(motion).collect(),
            cameras: x.cameras.iter().enumerate().map(camera).collect(),
        }
    }
}

impl std::fmt::Debug for SequencePosterior<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "SequencePosterior({}, {} frames)", self.model.name, self.looks.len())
    }
}
