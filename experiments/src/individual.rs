//! Whom a recording shows: somebody of `walker-metaballs`, so of other flesh than the fitted body, with joints where
//! publications have them and leave them open, and habits of their own (docs/anthropometry.md; the habits: E).

use maquette::body::{BodyModel, Shape};
use maquette::synth::{Recipe, draw_centres, move_centres};
use nalgebra::DVector;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// Random stream of joints' centres and habits; the recipe's own are others.
const OWN: u64 = 4;

/// Where publications have joints and points in the flesh, from where the walker was drawn, forwards, inwards or upwards, metres
/// (docs/anthropometry.md, sections 6 and 8; the walker's in brackets): elbow .38 of its depth from the back (.50); C7/T1 66 mm ahead of the
/// skin behind it (59); C0/C1 15 mm behind the middle of the head (27) and, at his stature, 161 below its top (168); vertex above the middle of the head
/// (28 behind it); tip of the big toe half the toes' height, 11 mm, behind the front of the foot (25), half a toe's breadth, 15, from
/// its inner border (22), 18 above the sole (28). The shoulder lies where section 12 has it.
const PLACES_M: [(&str, Axis, f64); 8] = [
    ("forearm_r", FORWARDS, -0.010),
    ("neck", FORWARDS, 0.0075),
    ("head", FORWARDS, 0.013),
    ("head", UPWARDS, 0.007),
    ("Head", FORWARDS, 0.028),
    ("RBigToe", FORWARDS, 0.014),
    ("RBigToe", INWARDS, 0.007),
    ("RBigToe", UPWARDS, -0.010),
];

/// Of the part.
type Axis = usize;
const FORWARDS: Axis = 0;
const INWARDS: Axis = 1;
const UPWARDS: Axis = 2;

/// What persons differ by in a joint that the walk leaves at rest, of the spread that a body model expects over all motions (E):
/// 5° at wrist and head, 3° of inversion, 8° of the forearm's twist.
const HABITS: f64 = 1.0 / 3.0;

/// The person of this recipe: one draw for all frames and trials. `body` holds the standard deviations; its places are not the person's.
pub fn individual(recipe: &Recipe, body: &BodyModel, walker: &BodyModel) -> Option<BodyModel> {
    let shape = recipe.walker(walker).ok()?.shape;
    let published = PLACES_M.iter().fold(walker.clone(), |person, (name, axis, by_m)| {
        moved(person, &shape, name, *axis, *by_m)
    });
    let mut rng = ChaCha8Rng::seed_from_u64(recipe.seed);
    rng.set_stream(OWN);
    let mut person = draw_centres(&published, &shape, body, &mut rng);
    for joint in &mut person.joints {
        let drawn: f64 = StandardNormal.sample(&mut rng);
        let (low, high) = joint.limits;
        joint.rest = (joint.rest + HABITS * joint.spread * drawn).clamp(low, high);
    }
    Some(person)
}

/// The person with one part's joint, or one point, elsewhere in the flesh, and its mirror image's.
fn moved(mut person: BodyModel, shape: &Shape, name: &str, axis: Axis, by_m: f64) -> BodyModel {
    let parts = person.parts.iter_mut().map(|p| (&p.name, &mut p.sd_m));
    let points = person.points.iter_mut().map(|p| (&p.name, &mut p.sd_m));
    for (one, sd_m) in parts.chain(points) {
        sd_m.fill(0.0);
        if one == name {
            sd_m[axis] = by_m.abs();
        }
    }
    move_centres(&person, shape, &DVector::from_element(1, by_m.signum()))
}
