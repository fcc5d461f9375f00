//! How far the keyframes agree about the shape: p_ε,σ(K) of every coefficient and length (ZS06).

use nalgebra::DVector;

use super::ConfidenceOptions;
use crate::body::{BodyModel, Motion, Posed, Shape};
use crate::inference::confidence::{Confidence, confidence, joint_confidence};
use crate::inference::search::{Hypothesis, Origin, Trial};

/// The confidence of a shape, from the K estimates s*ₖ of the keyframes.
///
/// Each keyframe counts once, with its most probable reading. What the confidence is *of*: the model's
/// optimum. An error that all keyframes share does not show in it.
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
    /// The confidence that these trials' keyframes give.
    pub(super) fn from_trials(
        model: &BodyModel,
        trials: &[Trial],
        options: &ConfidenceOptions,
    ) -> Self {
        let shapes: Vec<&Shape> = best_readings(trials).iter().map(|h| &h.shape).collect();
        let coefficients: Vec<DVector<f64>> = shapes.iter().map(|s| s.0.clone()).collect();
        let lengths: Vec<DVector<f64>> =
            shapes.iter().map(|s| DVector::from_vec(rest_lengths_m(model, s))).collect();
        let (epsilon, epsilon_m) = (options.epsilon_coefficient, options.epsilon_m);
        Self {
            coefficients: each(&coefficients, model.coefficients.len(), epsilon),
            lengths: each(&lengths, model.lengths.len(), epsilon_m),
            all_coefficients: joint_confidence(&coefficients, epsilon),
            all_lengths: joint_confidence(&lengths, epsilon_m),
        }
    }

    /// K.
    pub fn keyframes(&self) -> usize {
        self.all_coefficients.keyframes
    }
}

/// The lengths of a body, metres, in the order of [`BodyModel::lengths`], measured at rest.
///
/// A length within a part is the same in every pose; one across a joint is stated at the joints' rest angles.
pub fn rest_lengths_m(model: &BodyModel, shape: &Shape) -> Vec<f64> {
    let points = Posed::new(model, shape, &Motion::rest(model)).points();
    let length = |(_, from, to): &(String, usize, usize)| (points[*to] - points[*from]).norm();
    model.lengths.iter().map(length).collect()
}

/// The most probable reading of each keyframe, in the order of the keyframes.
fn best_readings(trials: &[Trial]) -> Vec<&Hypothesis> {
    let mut best: Vec<&Hypothesis> = Vec::new();
    for hypothesis in trials.iter().map(|trial| &trial.hypothesis) {
        if !matches!(hypothesis.origin, Origin::Keyframe(_)) {
            continue;
        }
        match best.iter_mut().find(|h| h.keyframe == hypothesis.keyframe) {
            Some(other) if hypothesis.keyframe_cost < other.keyframe_cost => *other = hypothesis,
            Some(_) => {}
            None => best.push(hypothesis),
        }
    }
    best
}

fn each(estimates: &[DVector<f64>], components: usize, epsilon: f64) -> Vec<Confidence> {
    let of = |i: usize| estimates.iter().map(|e| e[i]).collect::<Vec<f64>>();
    (0..components).map(|i| confidence(&of(i), epsilon)).collect()
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

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
        let found = ShapeConfidence::from_trials(&model, &trials, &ConfidenceOptions::default());
        assert_eq!(found.keyframes(), 2);
        approx::assert_relative_eq!(found.coefficients[0].sigma.unwrap(), 0.1, epsilon = 1e-12);
    }

    #[test]
    fn the_lengths_of_the_arm_add_up_to_one_metre_in_every_shape() {
        let model = crate::io::model::load("arm-2d", Path::new("")).unwrap();
        for a in [-1.0, 0.0, 0.7] {
            let lengths = rest_lengths_m(&model, &Shape(DVector::from_vec(vec![a])));
            approx::assert_relative_eq!(lengths[0] + lengths[1], 2.0, epsilon = 1e-12);
        }
    }
}
