//! Borders that a limb shares with another part say nothing in the joint optimum.

use maquette::body::{BodyModel, Motion, Posed};
use maquette::inference::Detail;
use maquette::likelihood::{Measure, PlacedResidual, Source};

use crate::scene::Scene;

/// Folds of the skin reach no further from the elbow, m.
const FOLD_M: f64 = 0.12;

/// Border points of the right forearm outside the fold: all, and those that tell what they show.
fn of_forearm(scene: &Scene, measure: Measure) -> (usize, usize) {
    let evidence = scene.evidence(measure);
    let terms = evidence.terms(&scene.frames[0], Detail::Fine);
    let body = Posed::new(&scene.model, &scene.truth.shape, &scene.truth.motions[0]);
    let forearm = scene.model.parts.iter().position(|p| p.name == "forearm_r").expect("it has one");
    let count = |residuals: Vec<PlacedResidual>| {
        let is_asked = |r: &&PlacedResidual| {
            let is_border = matches!(r.source, Source::View(_));
            is_border && r.part.0 == forearm && r.place_part.norm() > FOLD_M
        };
        residuals.iter().filter(is_asked).count()
    };
    let all = terms.iter().map(|term| count(term.placed_residuals(&body)));
    let clear = terms.iter().map(|term| count(term.clear(&body).residuals));
    (all.sum(), clear.sum())
}

/// Standing, the right arm raised by so many degrees to the front and to the side, with a straight elbow.
fn standing(model: &BodyModel, flexion_deg: f64, abduction_deg: f64) -> Motion {
    let mut motion = Motion::rest(model);
    motion.position_world.z = 0.95;
    for (name, degrees) in
        [("shoulder_flexion_r", flexion_deg), ("shoulder_abduction_r", abduction_deg)]
    {
        let joint = model.joints.iter().position(|joint| joint.name == name).expect("it has one");
        motion.angles[joint] = f64::to_radians(degrees);
    }
    motion
}

#[test]
fn a_forearm_on_the_border_of_the_body_is_not_told_from_it_and_one_beside_the_body_is() {
    for (name, measure) in
        [("human-ellipsoids", Measure::Ellipses), ("human-metaballs", Measure::Metaballs)]
    {
        let from = |heading_deg: f64, flexion_deg: f64, abduction_deg: f64| {
            let pose = |model: &BodyModel| standing(model, flexion_deg, abduction_deg);
            of_forearm(&Scene::standing(name, heading_deg, pose), measure)
        };
        // from the side: a little before the trunk's border, and far before it
        let (all, clear) = from(90.0, 7.0, 8.0);
        assert!(all > 0 && clear == 0, "{name}: {clear} of {all}");
        let (all, clear) = from(90.0, 70.0, 8.0);
        assert!(all > 5 && clear == all, "{name}: {clear} of {all}");
        // from the front: beside the trunk
        let (all, clear) = from(0.0, 0.0, 40.0);
        assert!(all > 5 && clear == all, "{name}: {clear} of {all}");
    }
}
