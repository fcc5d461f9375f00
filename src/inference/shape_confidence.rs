//! How far the keyframes agree about the shape: p_ε,σ(K) of every coefficient and length (ZS06, after Algorithm 1).

use nalgebra::DVector;
use serde::{Deserialize, Serialize};

use super::confidence::{Confidence, confidence, joint_confidence};
use super::hypothesis::{Hypothesis, Origin, Trial};
use crate::body::{BodyModel, Shape};

/// How near an estimate must be to count as right: ε of p_ε,σ(K) (ZS06).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ConfidenceOptions {
    /// ε of a length, m (default 0.02).
    pub epsilon_m: f64,
    /// ε of a shape coefficient (default 0.05): 5 % of a width or length, 0.05 m of a shift.
    pub epsilon_coefficient: f64,
}

impl Default for ConfidenceOptions {
    fn default() -> Self {
        Self { epsilon_m: 0.02, epsilon_coefficient: 0.05 }
    }
}

/// The confidence of a shape, from the K estimates s*ₖ of the keyframes.
///
/// Each keyframe counts once, with its most probable reading; its error is that from the reported shape s̄. What the confidence
/// is *of*: the model's optimum. An error that all keyframes and s̄ share does not show in it.
#[derive(Debug, Clone, PartialEq)]
pub struct ShapeConfidence {
    /// Of each shape coefficient, ε and σ in the coefficient's unit.
    pub coefficients: Vec<Confidence>,
    /// Of each length of the model, ε and σ in metres.
    pub lengths: Vec<Confidence>,
    /// Of all coefficients at once.
    pub all_coefficients: Confidence,
    /// Of all lengths at once.
    pub all_lengths: Confidence,
}

impl ShapeConfidence {
    /// The confidence that these trials' keyframes give in a reported shape and its lengths, metres.
    pub fn from_trials(
        model: &BodyModel,
        trials: &[Trial],
        reported: &Shape,
        reported_m: &[f64],
        options: &ConfidenceOptions,
    ) -> Self {
        let shapes = keyframe_shapes(trials.iter().map(|trial| &trial.hypothesis));
        Self::from_shapes(model, &shapes, reported, reported_m, options)
    }

    /// The same, of the shapes s*ₖ themselves: of several recordings of one person, all that their keyframes found.
    pub fn from_shapes(
        model: &BodyModel,
        shapes: &[&Shape],
        reported: &Shape,
        reported_m: &[f64],
        options: &ConfidenceOptions,
    ) -> Self {
        let coefficients: Vec<DVector<f64>> = shapes.iter().map(|s| s.0.clone()).collect();
        let lengths: Vec<DVector<f64>> =
            shapes.iter().map(|s| DVector::from_vec(model.rest_lengths_m(s))).collect();
        let reported_lengths = DVector::from_column_slice(reported_m);
        let (epsilon, epsilon_m) = (options.epsilon_coefficient, options.epsilon_m);
        Self {
            coefficients: each(&coefficients, &reported.0, epsilon),
            lengths: each(&lengths, &reported_lengths, epsilon_m),
            all_coefficients: joint_confidence(&coefficients, &reported.0, epsilon),
            all_lengths: joint_confidence(&lengths, &reported_lengths, epsilon_m),
        }
    }

    /// K.
    pub fn keyframes(&self) -> usize {
        self.all_coefficients.keyframes
    }

    /// Takes back σ and p_ε,σ(K) of a shape that is not the person's: that keyframes agree about it says nothing.
    pub(crate) fn withhold(&mut self) {
        let each = self.coefficients.iter_mut().chain(&mut self.lengths);
        for confidence in each.chain([&mut self.all_coefficients, &mut self.all_lengths]) {
            (confidence.sigma, confidence.p_within) = (None, None);
        }
    }
}

/// s*ₖ of hypotheses: of each keyframe its most probable reading.
pub(crate) fn keyframe_shapes<'a>(
    hypotheses: impl Iterator<Item = &'a Hypothesis>,
) -> Vec<&'a Shape> {
    let of_keyframes = hypotheses.filter(|h| matches!(h.origin, Origin::Keyframe(_)));
    let best = best_readings(of_keyframes, |h| (h.keyframe, h.keyframe_cost));
    best.into_iter().map(|h| &h.shape).collect()
}

/// The most probable reading of each keyframe, in the order of the keyframes; `of` tells its keyframe and its cost.
pub(crate) fn best_readings<T>(
    readings: impl Iterator<Item = T>,
    of: impl Fn(&T) -> (usize, f64),
) -> Vec<T> {
    let mut best: Vec<T> = Vec::new();
    for reading in readings {
        let (keyframe, cost) = of(&reading);
        match best.iter_mut().find(|other| of(other).0 == keyframe) {
            Some(other) if cost < of(other).1 => *other = reading,
            Some(_) => {}
            None => best.push(reading),
        }
    }
    best
}

fn each(estimates: &[DVector<f64>], reported: &DVector<f64>, epsilon: f64) -> Vec<Confidence> {
    let of = |i: usize| estimates.iter().map(|e| e[i]).collect::<Vec<f64>>();
    reported.iter().enumerate().map(|(i, s)| confidence(&of(i), *s, epsilon)).collect()
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::body::Motion;

    fn trial(model: &BodyModel, origin: Origin, keyframe: usize, (a, cost): (f64, f64)) -> Trial {
        Trial {
            hypothesis: Hypothesis {
                origin,
                keyframe,
                shape: Shape(DVector::from_vec(vec![a])),
                motion: Motion::rest(model),
                keyframe_cost: cost,
            },
            shape_cost: 0.0,
            frames: Vec::new(),
        }
    }

    #[test]
    fn each_keyframe_counts_once_with_its_best_reading() {
        let model = crate::io::model::load("arm-2d", Path::new("")).unwrap();
        let trials = [
            trial(&model, Origin::Prior, 0, (9.0, 0.0)),
            trial(&model, Origin::Keyframe(0), 0, (0.1, 5.0)),
            trial(&model, Origin::Keyframe(1), 0, (7.0, 6.0)),
            trial(&model, Origin::Keyframe(0), 20, (0.3, 4.0)),
        ];
        let reported = Shape(DVector::from_vec(vec![0.2]));
        let options = ConfidenceOptions::default();
        let found = ShapeConfidence::from_trials(&model, &trials, &reported, &[1.0, 1.0], &options);
        assert_eq!(found.keyframes(), 2);
        approx::assert_relative_eq!(found.coefficients[0].sigma.unwrap(), 0.1, epsilon = 1e-12);
    }

    #[test]
    fn the_lengths_of_the_arm_add_up_to_one_metre_in_every_shape() {
        let model = crate::io::model::load("arm-2d", Path::new("")).unwrap();
        for a in [-1.0, 0.0, 0.7] {
            let lengths = model.rest_lengths_m(&Shape(DVector::from_vec(vec![a])));
            approx::assert_relative_eq!(lengths[0] + lengths[1], 2.0, epsilon = 1e-12);
        }
    }
}
