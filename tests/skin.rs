//! The skin of whole bodies: closed, outward, and where the field is T.

use std::path::Path;

use maquette::body::metaball::{Field, THRESHOLD};
use maquette::body::{BodyModel, Motion, Posed, Shape};
use maquette::io::model;
use maquette::skin::{Finish, Mesh, SkinError, SkinOptions, check_watertight, skin};

/// Name of a pose, angles in degrees (of a joint with sides, on both), the least share of vertices within 3 mm of the skin
/// of the whole body, and the largest share of normals along which F does not fall.
type Pose = (&'static str, &'static [(&'static str, f64)], f64, f64);

/// Where limbs lie against each other, vertices lie in the other's flesh: rest (arms and flanks), squat (thighs and belly).
const POSES: &[Pose] = &[
    ("rest", &[], 0.95, 0.02),
    ("arms out", &[("shoulder_abduction", 88.0)], 0.985, 0.01),
    ("arms half out", &[("shoulder_abduction", 45.0)], 0.985, 0.01),
    ("arms up", &[("shoulder_abduction", 160.0)], 0.98, 0.01),
    ("arms up in front", &[("shoulder_flexion", 170.0), ("elbow_flexion", 100.0)], 0.98, 0.01),
    (
        "walking",
        &[
            ("hip_flexion_r", 30.0),
            ("hip_flexion_l", -15.0),
            ("knee_flexion_l", 40.0),
            ("shoulder_flexion_r", -20.0),
            ("shoulder_flexion_l", 25.0),
            ("elbow_flexion", 30.0),
        ],
        0.96,
        0.02,
    ),
    (
        "sitting",
        &[
            ("hip_flexion", 90.0),
            ("knee_flexion", 90.0),
            ("shoulder_flexion", 30.0),
            ("elbow_flexion", 60.0),
        ],
        0.96,
        0.02,
    ),
    (
        "kicking",
        &[
            ("hip_abduction_r", 50.0),
            ("hip_flexion_l", -30.0),
            ("thorax_rotation", 35.0),
            ("neck_rotation", 60.0),
        ],
        0.95,
        0.02,
    ),
    (
        "squatting",
        &[
            ("hip_flexion", 120.0),
            ("knee_flexion", 135.0),
            ("lumbar_flexion", 30.0),
            ("shoulder_flexion", 90.0),
        ],
        0.88,
        0.06,
    ),
];

fn walker() -> BodyModel {
    model::load("walker-metaballs", Path::new("")).expect("a shipped model")
}

fn motion(model: &BodyModel, angles: &[(&str, f64)]) -> Motion {
    let mut motion = Motion::rest(model);
    for (joint, angle) in model.joints.iter().zip(motion.angles.iter_mut()) {
        for (name, degrees) in angles {
            let sided = [format!("{name}_r"), format!("{name}_l")];
            if joint.name == *name || sided.contains(&joint.name) {
                *angle = degrees.to_radians();
            }
        }
    }
    motion
}

fn shape(model: &BodyModel) -> Shape {
    Shape(model.statistics.mean.clone())
}

/// Checks what holds for every skin.
fn check(name: &str, mesh: &Mesh) {
    assert_eq!(check_watertight(mesh), Ok(()), "{name}");
    assert_eq!(mesh.euler_characteristic(), 2, "{name}");
    let is_finite = |v: &nalgebra::Vector3<f64>| v.iter().all(|x| x.is_finite());
    assert!(mesh.vertices.iter().all(is_finite), "{name}");
}

/// First-order distance from F = T, metres; F far inside is far.
fn distance(field: &Field, point: &nalgebra::Vector3<f64>) -> f64 {
    let (value, gradient) = field.value_and_gradient(point);
    (value - THRESHOLD).abs() / gradient.norm().max(1e-9)
}

fn check_poses(model: &BodyModel, slack: f64) {
    let shape = shape(model);
    for (name, angles, near, against) in POSES {
        let motion = motion(model, angles);
        let body = Posed::new(model, &shape, &motion);
        let mesh = skin(&body, &SkinOptions::default()).expect("a skin");
        check(name, &mesh);
        // 64 to 70 litres, as these two bodies have it
        let volume = mesh.volume();
        assert!((0.055..0.075).contains(&volume), "{name}: {volume} m³");
        let field = Field::from_body(&body);
        let count = mesh.vertices.len() as f64;
        let is_near = |v: &&nalgebra::Vector3<f64>| distance(&field, v) < 0.003;
        let share = mesh.vertices.iter().filter(is_near).count() as f64 / count;
        assert!(share > *near - slack, "{name}: {share} within 3 mm");
        let falls = |(v, n): (&nalgebra::Vector3<f64>, &nalgebra::Vector3<f64>)| {
            field.value_and_gradient(v).1.dot(n) < 0.0
        };
        let each = mesh.vertices.iter().zip(&mesh.normals);
        let share = each.filter(|pair| !falls(*pair)).count() as f64 / count;
        assert!(share < *against + slack, "{name}: {share} of the normals point inwards");
    }
}

#[test]
fn the_skin_is_closed_outward_and_on_the_field_in_every_pose() {
    check_poses(&walker(), 0.0);
}

#[test]
fn so_is_that_of_another_body() {
    let model = model::load("human-metaballs", Path::new("")).expect("a shipped model");
    check_poses(&model, 0.03);
}

#[test]
fn every_vertex_of_an_arm_is_on_the_field() {
    let model = model::load("arm", Path::new("")).expect("a shipped model");
    let (shape, motion) = (shape(&model), motion(&model, &[("elbow_flexion", 100.0)]));
    let body = Posed::new(&model, &shape, &motion);
    let mesh = skin(&body, &SkinOptions::default()).expect("a skin");
    check("arm", &mesh);
    let field = Field::from_body(&body);
    let farthest = mesh.vertices.iter().map(|v| distance(&field, v));
    let farthest = farthest.fold(0.0, f64::max);
    assert!(farthest < 1e-4, "{farthest} m");
}

#[test]
fn the_counts_that_the_user_chooses_are_the_counts_there_are() {
    let model = walker();
    let (shape, motion) = (shape(&model), Motion::rest(&model));
    let body = Posed::new(&model, &shape, &motion);
    let mut before = 0;
    for around in [16, 24, 48, 96] {
        let mesh = skin(&body, &SkinOptions::with_around(around)).expect("a skin");
        check(&format!("{around} around"), &mesh);
        assert!(mesh.vertices.len() > 2 * before, "{around}");
        before = mesh.vertices.len();
    }
    let sparse = SkinOptions { along_per_m: 30.0, ..SkinOptions::default() };
    let (sparse, usual) = (skin(&body, &sparse), skin(&body, &SkinOptions::default()));
    let counts = [sparse, usual].map(|mesh| mesh.expect("a skin").vertices.len());
    assert!(2 * counts[0] < counts[1] + counts[1] / 4, "{counts:?}");
}

#[test]
fn the_papers_patches_stay_within_millimetres_of_the_field_and_the_finish_puts_them_on_it() {
    let model = walker();
    let (shape, motion) = (shape(&model), motion(&model, &[("shoulder_abduction", 88.0)]));
    let body = Posed::new(&model, &shape, &motion);
    let field = Field::from_body(&body);
    let median = |finish| {
        let options = SkinOptions { finish, ..SkinOptions::default() };
        let mesh = skin(&body, &options).expect("a skin");
        let mut all: Vec<f64> = mesh.vertices.iter().map(|v| distance(&field, v)).collect();
        all.sort_by(f64::total_cmp);
        [all[all.len() / 2], all[all.len() * 95 / 100]]
    };
    let [middle, most] = median(Finish::Spline);
    assert!((1e-5..1e-3).contains(&middle) && most < 4e-3, "{middle} {most}");
    let [middle, most] = median(Finish::Field);
    assert!(middle < 1e-7 && most < 1e-5, "{middle} {most}");
}

/// A model of three capsules in a chain, and one that branches in its middle.
fn worm(branch: &str) -> BodyModel {
    let mut text = String::from("name = \"worm\"\nroot = { fixed = true }\n");
    for (name, parent) in [("a", ""), ("b", "parent = \"a\"\n"), ("c", "parent = \"b\"\n")] {
        text += &format!("[[part]]\nname = \"{name}\"\n{parent}");
        if !parent.is_empty() {
            text += &format!(
                "at = [0.0, 0.0, 0.3]\n[[part.joint]]\nname = \"bend_{name}\"\naxis = \"y\"\nlimits_deg = [-150.0, 150.0]\n"
            );
            text += "spread_deg = 30.0\nspeed_deg = 60.0\n";
        }
        for height in [0.05, 0.15, 0.25] {
            text += &format!(
                "[[part.metaball]]\ncentre = [0.0, 0.0, {height}]\nradii = [0.08, 0.08, 0.1]\n"
            );
        }
    }
    let path = Path::new("worm.toml");
    model::parse(&(text + branch), path).expect("a model")
}

#[test]
fn a_single_chain_is_a_closed_tube_also_when_it_bends_far() {
    let model = worm("");
    let shape = shape(&model);
    for degrees in [0.0, 45.0, 90.0, 130.0] {
        let motion = motion(&model, &[("bend_b", degrees), ("bend_c", -degrees)]);
        let body = Posed::new(&model, &shape, &motion);
        let mesh = skin(&body, &SkinOptions::default()).expect("a skin");
        check(&format!("{degrees}°"), &mesh);
        let field = Field::from_body(&body);
        let far = mesh.vertices.iter().filter(|v| distance(&field, v) > 0.003);
        let share = far.count() as f64 / mesh.vertices.len() as f64;
        assert!(share < 0.02, "{degrees}°: {share} of the vertices");
        assert!((0.007..0.012).contains(&mesh.volume()), "{}", mesh.volume());
    }
}

const BRANCH: &str = r#"
[[part]]
name = "twig"
parent = "b"
at = [0.0, 0.03, 0.15]
[[part.joint]]
name = "twig_angle"
axis = "x"
limits_deg = [-150.0, 150.0]
spread_deg = 30.0
speed_deg = 60.0
[[part.metaball]]
centre = [0.0, 0.1, 0.0]
radii = [0.04, 0.15, 0.04]
[[part.metaball]]
centre = [0.0, 0.2, 0.0]
radii = [0.04, 0.15, 0.04]
"#;

#[test]
fn a_limb_grows_out_of_any_part() {
    let model = worm(BRANCH);
    let shape = shape(&model);
    for degrees in [-40.0, 0.0, 60.0] {
        let motion = motion(&model, &[("twig_angle", degrees)]);
        let body = Posed::new(&model, &shape, &motion);
        let mesh = skin(&body, &SkinOptions::default()).expect("a skin");
        check(&format!("{degrees}°"), &mesh);
        let tip = body.point(
            model_part(&model, "twig"),
            &maquette::body::ScaledVector::fixed(nalgebra::Vector3::new(0.0, 0.28, 0.0)),
        );
        let nearest = mesh.vertices.iter().map(|v| (v - tip.coords).norm());
        assert!(nearest.fold(f64::MAX, f64::min) < 0.03);
    }
}

fn model_part(model: &BodyModel, name: &str) -> maquette::body::PartId {
    let at = model.parts.iter().position(|p| p.name == name);
    maquette::body::PartId(at.expect("a part"))
}

#[test]
fn what_cannot_have_a_skin_is_told_why() {
    let fault = |model: &BodyModel, motion: &Motion, options: &SkinOptions| {
        let shape = shape(model);
        let body = Posed::new(model, &shape, motion);
        skin(&body, options).map(|_| ()).expect_err("a fault")
    };
    let usual = SkinOptions::default();
    let solid = model::load("human-ellipsoids", Path::new("")).expect("a shipped model");
    let message = fault(&solid, &Motion::rest(&solid), &usual).to_string();
    assert!(message.contains("human-ellipsoids has no metaballs"), "{message}");
    // two balls so far apart that the field between them is no flesh
    let gap = BRANCH.replace("centre = [0.0, 0.2, 0.0]", "centre = [0.0, 2.2, 0.0]");
    let model = worm(&gap);
    let message = fault(&model, &Motion::rest(&model), &usual).to_string();
    assert!(message.starts_with("part twig: the sum"), "{message}");
    // a pose that is none
    let model = walker();
    let mut motion = Motion::rest(&model);
    motion.angles[3] = f64::NAN;
    let found = fault(&model, &motion, &usual);
    assert!(matches!(found, SkinError::NotFinite { .. }), "{found}");
    // counts that make no surface
    for around in [0, 15, 17, 2000] {
        let options = SkinOptions { around, ..usual };
        let found = fault(&model, &Motion::rest(&model), &options);
        assert_eq!(found, SkinError::Around { found: around });
    }
    let options = SkinOptions { along_per_m: f64::NAN, ..usual };
    let found = fault(&model, &Motion::rest(&model), &options);
    assert!(matches!(found, SkinError::Along { .. }));
    // two limbs in one place
    let twins = format!("{BRANCH}{}", BRANCH.replace("twig", "twin"));
    let model = worm(&twins);
    let found = fault(&model, &Motion::rest(&model), &usual);
    assert!(matches!(found, SkinError::NoRoom { .. }), "{found}");
}
