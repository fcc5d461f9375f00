//! What a joint elsewhere in the flesh does to the optimum: foretold, and by fitting again.

use maquette::body::{BodyModel, Layout};
use maquette::inference::Terms;
use maquette::inference::chain::ChainPrior;
use maquette::inference::considered::Considered;
use maquette::inference::joint::{JointOptions, joint_optimum};
use maquette::inference::noise::Noise;
use maquette::inference::sequence_posterior::{SequencePosterior, SequenceState};
use maquette::likelihood::Measure;
use maquette::solver::{BorderedChain, Options, Problem, QuadraticModel, levenberg_marquardt};
use maquette::synth::move_centres;
use nalgebra::DVector;

use crate::scene::Scene;

/// The optimum of a body and H there, as the joint optimum seeks it.
fn optimum(
    scene: &Scene,
    model: &BodyModel,
    terms: &[Terms<'_>],
    start: &SequenceState,
) -> (SequenceState, BorderedChain) {
    let evidence = scene.evidence(Measure::Metaballs);
    let chain_prior = ChainPrior::new(model, JointOptions::default().motion_model);
    let posterior = SequencePosterior {
        model,
        shape_prior: &evidence.shape_prior,
        shape_weight: Noise::stated(terms.len()).over_time,
        pose_prior: &evidence.pose_prior,
        chain_prior: &chain_prior,
        seconds: &scene.sequence().intervals_s(),
        terms,
        data_weight: 1.0,
    };
    let options = Options { relative_decrease: 1e-9, ..Options::default() };
    let found = levenberg_marquardt(&posterior, start.clone(), &options);
    let mut chain = found.model;
    chain.clear();
    posterior.linearize(&found.state, &mut chain);
    (found.state, chain)
}

#[test]
fn an_optimum_moves_as_foretold_when_a_knee_lies_elsewhere_in_the_flesh() {
    let scene = Scene::person("human-metaballs", 4);
    let terms = scene.evidence(Measure::Metaballs).sequence_terms(scene.sequence());
    let (state, chain) = optimum(&scene, &scene.model, &terms, &scene.truth);
    let considered = Considered::new(&scene.model, &terms, &state, &chain).expect("priors hold it");
    // the places of the shank's joint, forwards and along, half a standard deviation off
    let shank = scene.model.parts.iter().position(|p| p.name == "shank_r");
    let knee = scene.model.parts[shank.expect("it has shanks")].joint;
    let knee = Layout::new(&scene.model).angle(knee.expect("and knees"));
    let sensitivity = &considered.sensitivity.frames;
    let greatest = sensitivity[0].row(knee).transpose().icamax();
    let mut c = DVector::zeros(considered.placed.count());
    c[greatest] = 0.5;
    let elsewhere = move_centres(&scene.model, &state.shape, &c);
    let (again, _) = optimum(&scene, &elsewhere, &terms, &state);
    for (i, foretold) in sensitivity.iter().enumerate() {
        let foretold = (foretold * &c)[knee];
        let found = again.motions[i].angles[knee - 6] - state.motions[i].angles[knee - 6];
        assert!(foretold.abs() > 0.005, "frame {i}: {foretold} says something");
        approx::assert_relative_eq!(found, foretold, max_relative = 0.2);
    }
}

#[test]
fn lengths_and_angles_of_a_person_are_less_sure_than_if_the_joints_were_known() {
    let scene = Scene::person("human-metaballs", 2);
    let evidence = scene.evidence(Measure::Metaballs);
    let found = |evidence| {
        let options = JointOptions::default();
        let joint = joint_optimum(evidence, scene.sequence(), scene.truth.clone(), &options);
        joint.uncertainty.expect("priors hold it")
    };
    let unsure = found(&evidence);
    let frame = &unsure.frames[0];
    let pairs = frame.angles_sd.iter().zip(&frame.seen_angles_sd);
    assert!(pairs.clone().all(|(all, seen)| all >= seen));
    assert!(pairs.clone().any(|(all, seen)| *all > 1.2 * seen));
    let mut known = scene.model.clone();
    known.parts.iter_mut().for_each(|p| p.sd_m.fill(0.0));
    known.points.iter_mut().for_each(|p| p.sd_m.fill(0.0));
    let mut sure = evidence.clone();
    sure.model = &known;
    let sure = found(&sure);
    let lengths = unsure.shape.lengths_sd_m.iter().zip(&sure.shape.lengths_sd_m);
    assert!(lengths.clone().all(|(all, seen)| *all >= 0.999 * seen));
    assert!(lengths.clone().any(|(all, seen)| *all > 1.2 * seen));
}
