//! Joints elsewhere in the flesh, and surfaces outside the model's, are found and keep the intervals honest.

use maquette::body::{BodyModel, Posed, Shape};
use maquette::inference::camera_prior::CameraPrior;
use maquette::inference::joint::{JointOptimum, JointOptions, joint_optimum};
use maquette::inference::{Evidence, Sequence};
use maquette::likelihood::{LikelihoodOptions, Measure};

use crate::scene::Scene;

/// The joint optimum of a body, from the truth of the scene's.
fn fitted(scene: &Scene, model: &BodyModel, measure: Measure) -> JointOptimum {
    let evidence = Evidence::new(model, &scene.rig, LikelihoodOptions::default(), measure);
    let sequence: Sequence<'_> = scene.sequence();
    joint_optimum(&evidence, sequence, scene.truth.clone(), &JointOptions::default())
}

#[test]
fn lengths_of_a_person_are_less_sure_than_if_the_joints_were_known() {
    let scene = Scene::person("human-metaballs", 6);
    let mut known = scene.model.clone();
    known.parts.iter_mut().for_each(|p| p.sd_m.fill(0.0));
    known.points.iter_mut().for_each(|p| p.sd_m.fill(0.0));
    let sds = |model: &BodyModel| {
        let joint = fitted(&scene, &model.detailed(), Measure::Metaballs);
        joint.uncertainty.expect("priors hold it").shape.lengths_sd_m
    };
    let (unsure, sure) = (sds(&scene.model), sds(&known));
    let pairs = unsure.iter().zip(&sure);
    assert!(pairs.clone().all(|(unsure, sure)| *unsure > 0.9 * sure), "{unsure:?} {sure:?}");
    assert!(pairs.clone().any(|(unsure, sure)| *unsure > 1.2 * sure), "{unsure:?} {sure:?}");
}

/// Shanks in cloth, 8 mm thick all around: it is found as an offset of the shank, outwards, and of nothing else so much.
#[test]
fn cloth_on_a_shank_is_an_offset_and_not_a_longer_shank() {
    let mut scene = Scene::person("human-ellipsoids", 6);
    let bare = scene.model.clone();
    let mut dressed = bare.clone();
    for e in &mut dressed.ellipsoids {
        if dressed.parts[e.part.0].name.starts_with("shank") {
            e.radii.value += nalgebra::Vector3::new(0.008, 0.008, 0.0);
        }
    }
    scene.film(&dressed);

    let detailed = bare.detailed();
    let joint = fitted(&scene, &detailed, Measure::Ellipses);
    let mean_mm = |part: &str| {
        let names = detailed.coefficients.iter().zip(joint.shape.0.iter());
        let own: Vec<f64> = names
            .filter(|(name, _)| name.starts_with(&format!("{part} offset")))
            .map(|(_, b)| 1e3 * b)
            .collect();
        own.iter().sum::<f64>() / own.len() as f64
    };
    assert!(mean_mm("shank") > 1.0, "{}", mean_mm("shank"));
    assert!(mean_mm("thigh").abs() < 0.5 * mean_mm("shank"), "{}", mean_mm("thigh"));

    let length = |model: &BodyModel, shape: &Shape| {
        let lengths = model.rest_lengths_m(shape);
        lengths[model.lengths.iter().position(|l| l.0 == "shank").expect("it has one")]
    };
    let (found, truth) = (length(&detailed, &joint.shape), length(&bare, &scene.truth.shape));
    assert!((-0.05..0.02).contains(&(found / truth - 1.0)), "{found} {truth}");
}

/// b is where the surface lies: a body whose offsets are those of a dressed one costs less before its silhouettes.
#[test]
fn a_residual_is_less_by_the_offset() {
    let scene = Scene::person("human-ellipsoids", 1);
    let detailed = scene.model.detailed();
    let evidence =
        Evidence::new(&detailed, &scene.rig, LikelihoodOptions::default(), Measure::Ellipses);
    let terms = evidence.sequence_terms(scene.sequence(), CameraPrior::trusting());
    let state = scene.truth.clone().detailed(&detailed);
    let offsets = detailed.offsets.as_ref().expect("it is detailed");
    let mut outside = state.shape.clone();
    outside.0.rows_mut(offsets.first().0, offsets.count()).fill(0.01);

    let residuals = |shape: &Shape| {
        terms.all[0][0].terms[0].placed_residuals(&Posed::new(&detailed, shape, &state.motions[0]))
    };
    let (bare, dressed) = (residuals(&state.shape), residuals(&outside));
    let mut seen = 0;
    for (bare, dressed) in bare.iter().zip(&dressed) {
        let less_px = (bare.value - dressed.value) * bare.sigma;
        assert!(less_px > 0.0);
        seen += 1;
    }
    assert!(seen > 50);
}
