//! Body model files: what is right is read as written, what is wrong is named in one line.

use std::path::Path;

use maquette::body::{BodyModel, Layout, Posed, Root, Shape};
use maquette::body::{JointId, Motion, PartId};
use maquette::io::model::{self, ModelFileError};

const ARM: &str = r#"
name = "test-arm"
root = { fixed = true }
factors = ["size"]

[[coefficient]]
name = "length"
sd = 0.05
loadings = { size = 0.1 }

[[coefficient]]
name = "place"
sd = 0.01

[[part]]
name = "upper"
scale = ["", "", "length"]
[[part.ellipsoid]]
centre = [0.0, 0.0, -0.15]
radii = [0.04, 0.05, 0.16]

[[part]]
name = "lower"
parent = "upper"
sides = true
at = [0.0, -0.02, -0.3]
at_scale = ["", "shift:place", "length"]
[[part.joint]]
name = "elbow"
axis = "-y"
limits_deg = [0.0, 150.0]
spread_deg = 40.0
speed_deg = 200.0
[[part.ellipsoid]]
centre = [0.0, 0.0, -0.12]
radii = [0.03, 0.03, 0.14]

[[point]]
name = "Elbow"
part = "lower"
"#;

fn parse(text: &str) -> Result<BodyModel, ModelFileError> {
    model::parse(text, Path::new("arm.toml"))
}

fn complaint(from: &str, to: &str) -> String {
    assert!(ARM.contains(from), "the fault is planted in text that is there");
    let message = parse(&ARM.replacen(from, to, 1)).expect_err("the fault is noticed").to_string();
    assert!(!message.contains('\n'), "{message}");
    message
}

/// Each of these replacements is answered by a message that begins so.
fn each_is_answered(faults: &[(&str, &str, &str)]) {
    for (from, to, said) in faults {
        let message = complaint(from, to);
        assert!(message.starts_with(said), "{message}");
    }
}

#[test]
fn the_left_side_is_the_mirror_image_of_the_right() {
    let model = parse(ARM).unwrap();
    let mut motion = Motion::rest(&model);
    motion.angles.fill(0.7);
    let mut shape = Shape(model.statistics.mean.clone());
    shape.0[1] = 0.005;
    let points = Posed::new(&model, &shape, &motion).points();
    let [right, left] = ["RElbow", "LElbow"].map(|name| points[model.point(name).unwrap()]);
    approx::assert_relative_eq!(right.y, -0.015, epsilon = 1e-12);
    approx::assert_relative_eq!(left.y, 0.015, epsilon = 1e-12);
    approx::assert_relative_eq!(right.z, left.z, epsilon = 1e-12);
    assert_eq!(model.root, Root::Fixed);
    assert_eq!(Layout::new(&model).total(), 4);
}

#[test]
fn a_pivot_moves_the_joint_in_flesh_that_stays_and_lies_otherwise_only_when_bent() {
    let text = ARM.replace("limits_deg = [0.0, 150.0]", "limits_deg = [-150.0, 150.0]");
    let text = text.replace("sides = true", "sides = true\nturn_deg = [0.0, 0.0, 90.0]");
    let text = text.replace(
        "\"shift:place\", \"length\"]",
        "\"\", \"length\"]\npivot = [\"place\", \"\", \"\"]",
    ) + "[[point]]\nname = \"Tip\"\npart = \"lower\"\nat = [0.0, 0.0, -0.3]\n";
    let model = parse(&text).unwrap();
    let shape = |place: f64| {
        let mut shape = Shape(model.statistics.mean.clone());
        shape.0[model.coefficients.iter().position(|c| c == "place").unwrap()] = place;
        shape
    };
    let point = |body: &Posed<'_>, name: &str| body.points()[model.point(name).unwrap()];
    let mut motion = Motion::rest(&model);
    let (here, there) = (shape(0.0), shape(0.01));
    // straight: the part's x axis is the parent's y, on the left its −y
    let bodies = [&here, &there].map(|s| Posed::new(&model, s, &motion));
    for (name, to) in [("RElbow", 0.01), ("LElbow", -0.01), ("RTip", 0.0), ("LTip", 0.0)] {
        let [old, new] = [0, 1].map(|i| point(&bodies[i], name));
        let moved = nalgebra::Vector3::new(0.0, to, 0.0);
        approx::assert_relative_eq!(new - old, moved, epsilon = 1e-12);
    }
    let flesh = |s: &Shape, m: &Motion| Posed::new(&model, s, m).ellipsoids().swap_remove(1);
    approx::assert_relative_eq!(
        flesh(&here, &motion).centre,
        flesh(&there, &motion).centre,
        epsilon = 1e-12
    );
    // bent: flesh turns about the joint where it is now
    motion.angles.fill(0.7);
    let body = Posed::new(&model, &there, &motion);
    let straight = &bodies[1];
    for name in ["RTip", "LTip"] {
        let elbow = name.replace("Tip", "Elbow");
        let arm = |body: &Posed<'_>| point(body, name) - point(body, &elbow);
        approx::assert_relative_eq!(arm(&body).norm(), arm(straight).norm(), epsilon = 1e-12);
        approx::assert_relative_eq!(arm(&body).angle(&arm(straight)), 0.7, epsilon = 1e-9);
    }
    approx::assert_relative_eq!(model.scatter_m(PartId(1)).x, 0.01, epsilon = 1e-12);
}

#[test]
fn coefficients_that_share_a_factor_are_correlated() {
    let covariance = parse(ARM).unwrap().statistics.covariance;
    approx::assert_relative_eq!(
        covariance[(0, 0)],
        0.05_f64.powi(2) + 0.1_f64.powi(2),
        epsilon = 1e-15
    );
    approx::assert_relative_eq!(covariance[(0, 1)], 0.0);
}

#[test]
fn denavit_hartenberg_parameters_are_one_way_to_write_the_static_transform() {
    // a planar two-link arm in modified DH: joint 2 lies a = 0.3 along x of joint 1, both turn about z
    let text = r#"
name = "planar"
root = { fixed = true }
[[part]]
name = "base"
[[part.joint]]
name = "q1"
dh = {}
limits_deg = [-180.0, 180.0]
spread_deg = 90.0
speed_deg = 90.0
[[part.ellipsoid]]
centre = [0.15, 0.0, 0.0]
radii = [0.15, 0.05, 0.05]
[[part]]
name = "link"
parent = "base"
[[part.joint]]
name = "q2"
dh = { a = 0.3 }
limits_deg = [-180.0, 180.0]
spread_deg = 90.0
speed_deg = 90.0
[[point]]
name = "Tip"
part = "link"
at = [0.2, 0.0, 0.0]
"#;
    let model = parse(text).unwrap();
    let shape = Shape(model.statistics.mean.clone());
    let mut motion = Motion::rest(&model);
    (motion.angles[0], motion.angles[1]) = (0.4, 0.5);
    let tip = Posed::new(&model, &shape, &motion).points()[0];
    approx::assert_relative_eq!(tip.x, 0.3 * 0.4_f64.cos() + 0.2 * 0.9_f64.cos(), epsilon = 1e-12);
    approx::assert_relative_eq!(tip.y, 0.3 * 0.4_f64.sin() + 0.2 * 0.9_f64.sin(), epsilon = 1e-12);
}

#[test]
fn the_human_is_as_tall_and_as_long_as_its_sources_say() {
    let model = model::load("human-ellipsoids", Path::new("")).unwrap();
    let shape = Shape(model.statistics.mean.clone());
    let mut motion = Motion::rest(&model);
    motion.angles.fill(0.0);
    let body = Posed::new(&model, &shape, &motion);
    let points = body.points();
    let length = |a: &str, b: &str| {
        (points[model.point(a).unwrap()] - points[model.point(b).unwrap()]).norm() / 1.70
    };
    // fractions of stature, docs/anthropometry.md sections 2, 10 and 12
    for (a, b, fraction) in [
        ("RHip", "RKnee", 0.2426),
        ("RKnee", "RAnkle", 0.245),
        ("RShoulder", "RElbow", 0.156),
        ("RElbow", "RWrist", 0.153),
        ("RHip", "LHip", 0.100),
        ("RShoulder", "LShoulder", 0.201),
    ] {
        approx::assert_relative_eq!(length(a, b), fraction, epsilon = 0.001);
    }
    let heights =
        |z: f64, e: &maquette::math::quadric::Ellipsoid| e.centre.z + z * e.shape[(2, 2)].sqrt();
    let ellipsoids = body.ellipsoids();
    let top = ellipsoids.iter().map(|e| heights(1.0, e)).fold(f64::MIN, f64::max);
    let sole = ellipsoids.iter().map(|e| heights(-1.0, e)).fold(f64::MAX, f64::min);
    approx::assert_relative_eq!(top - sole, 1.70, epsilon = 0.025);
    assert!(model.parts.len() >= 15);
}

#[test]
fn a_knee_bends_backwards_and_a_hip_forwards() {
    let model = model::load("human-ellipsoids", Path::new("")).unwrap();
    let shape = Shape(model.statistics.mean.clone());
    for (joint, point, forwards) in
        [("hip_flexion_l", "LKnee", true), ("knee_flexion_r", "RAnkle", false)]
    {
        let mut motion = Motion::rest(&model);
        let JointId(index) = model.joint(joint).unwrap();
        let ahead = |motion: &Motion| {
            Posed::new(&model, &shape, motion).points()[model.point(point).unwrap()].x
        };
        let before = ahead(&motion);
        motion.angles[index] += 0.5;
        assert_eq!(ahead(&motion) > before, forwards, "{joint}");
    }
}

#[test]
fn a_cycle_of_parents_is_named() {
    let message = complaint("name = \"upper\"\n", "name = \"upper\"\nparent = \"lower\"\n");
    assert_eq!(message, "arm.toml: expected one part without a parent, found 0");
    let cycle = ARM.to_owned()
        + "[[part]]\nname = \"a\"\nparent = \"b\"\n[[part]]\nname = \"b\"\nparent = \"a\"\n";
    let message = parse(&cycle).unwrap_err().to_string();
    assert_eq!(message, "arm.toml: part \"a\" is its own ancestor: break the cycle of `parent`");
}

#[test]
fn a_missing_parent_is_named() {
    let message = complaint("parent = \"upper\"", "parent = \"uper\"");
    assert_eq!(
        message,
        "arm.toml: part lower names the part \"uper\", which the file does not define"
    );
}

#[test]
fn a_negative_radius_is_named() {
    let message = complaint("radii = [0.04, 0.05, 0.16]", "radii = [0.04, -0.05, 0.16]");
    assert_eq!(message, "arm.toml: part upper: radius -0.05 m is not positive");
}

#[test]
fn an_unknown_key_is_named_with_its_line() {
    let message = complaint("sides = true", "side = true");
    assert!(message.starts_with("arm.toml:25: unknown field `side`"), "{message}");
}

#[test]
fn other_faults_are_named_too() {
    each_is_answered(&[
        ("shift:place", "shift:plaice", "arm.toml: part lower_r names the coefficient \"plaice\""),
        (
            "{ size = 0.1 }",
            "{ sise = 0.1 }",
            "arm.toml: coefficient length names the factor \"sise\"",
        ),
        ("[0.0, 150.0]", "[150.0, 0.0]", "arm.toml: joint elbow_r: limits"),
        ("axis = \"-y\"", "axis = \"w\"", "arm.toml: joint elbow: the axis"),
        (
            "name = \"place\"\nsd = 0.01",
            "name = \"place\"\nsd = 0.0",
            "arm.toml: the shape coefficients' covariance",
        ),
        (
            "[[point]]",
            "[[point]]
name = \"Elbow\"
part = \"lower\"
[[point]]",
            "arm.toml: two points are named \"LElbow\"",
        ),
        ("spread_deg = 40.0", "spread_deg = nan", "arm.toml: spread or speed of joint elbow_r"),
        (
            "name = \"upper\"",
            "name = \"upper\"\nat = [0.0, 0.0, 0.1]",
            "arm.toml: part upper: `at` says where its first joint is, and it has none",
        ),
        (
            "name = \"upper\"",
            "name = \"upper\"\nat_scale = [\"\", \"\", \"length\"]",
            "arm.toml: part upper: `at_scale`",
        ),
        (
            "name = \"upper\"",
            "name = \"upper\"\nturn_deg = [0.0, 20.0, 0.0]",
            "arm.toml: part upper: `turn_deg`",
        ),
        ("name = \"test-arm\"", "name = ", "arm.toml:2:"),
    ]);
}

#[test]
fn two_keys_for_one_thing_and_none_are_named() {
    each_is_answered(&[
        (
            "axis = \"-y\"",
            "axis = \"-y\"\ndh = {}",
            "arm.toml: joint elbow: expected one of `axis`, `dh`, found 2",
        ),
        ("axis = \"-y\"\n", "", "arm.toml: joint elbow: expected one of `axis`, `dh`, found 0"),
        (
            "part = \"lower\"\n",
            "part = \"lower\"\nmidpoint = [\"RElbow\", \"LElbow\"]\n",
            "arm.toml: point Elbow: expected one of `part`, `midpoint`, found 2",
        ),
        (
            "part = \"lower\"\n",
            "",
            "arm.toml: point Elbow: expected one of `part`, `midpoint`, found 0",
        ),
    ]);
}

#[test]
fn faults_of_a_pivot_are_named() {
    each_is_answered(&[
        (
            "name = \"upper\"",
            "name = \"upper\"\npivot = [\"\", \"\", \"place\"]",
            "arm.toml: part upper: `pivot`",
        ),
        (
            "sides = true",
            "sides = true\npivot = [\"\", \"\", \"plaice\"]",
            "arm.toml: part lower_r names the coefficient \"plaice\"",
        ),
    ]);
}

#[test]
fn a_model_that_is_not_shipped_is_answered_with_those_that_are() {
    let message = model::load("humen", Path::new("")).unwrap_err().to_string();
    assert!(message.contains("human-ellipsoids"), "{message}");
    let message = model::load("none.toml", Path::new("nowhere")).unwrap_err().to_string();
    assert!(message.starts_with("cannot read body model"), "{message}");
}

/// A folder with `arm.toml` and files that extend it or each other.
fn folder_of(files: &[(&str, &str)]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    for (name, text) in [("arm.toml", ARM)].iter().chain(files) {
        std::fs::write(folder.path().join(name), text).expect("it can be written");
    }
    folder
}

const FLESH: &str = r#"
name = "flesh"
extends = "arm.toml"
factors = ["size", "girth"]
[[coefficient]]
name = "thickness"
sd = 0.02
loadings = { girth = 0.05 }
[[coefficient]]
name = "length"
sd = 0.03
loadings = { size = 0.1, girth = 0.01 }
[[part]]
name = "lower"
[[part.metaball]]
centre = [0.0, 0.01, -0.1]
radii = [0.05, 0.05, 0.1]
radii_scale = ["thickness", "thickness", "length"]
"#;

#[test]
fn an_extension_has_the_others_skeleton_and_flesh_of_its_own() {
    let folder = folder_of(&[("flesh.toml", FLESH)]);
    let model = model::load("flesh.toml", folder.path()).unwrap();
    let other = parse(ARM).unwrap();
    assert_eq!(model.name, "flesh");
    assert_eq!((&model.joints, &model.points), (&other.joints, &other.points));
    assert_eq!(model.ellipsoids, other.ellipsoids);
    assert_eq!(model.metaballs.len(), 2, "one a side");
    approx::assert_relative_eq!(model.metaballs[1].centre.value.y, -0.01);
    // a coefficient of the other's name takes its place, a new one comes last
    assert_eq!(model.coefficients, ["length", "place", "thickness"]);
    let covariance = &model.statistics.covariance;
    approx::assert_relative_eq!(
        covariance[(0, 0)],
        0.03_f64.powi(2) + 0.1_f64.powi(2) + 0.01_f64.powi(2),
        epsilon = 1e-15
    );
    approx::assert_relative_eq!(covariance[(0, 2)], 0.05 * 0.01, epsilon = 1e-15);
}

#[test]
fn faults_of_an_extension_are_named() {
    for (from, to, said) in [
        (
            "extends = \"arm.toml\"",
            "extends = \"amr.toml\"",
            "what it extends: cannot read body model",
        ),
        ("extends = \"arm.toml\"", "extends = \"amr\"", "what it extends: no body model \"amr\""),
        (
            "name = \"lower\"",
            "name = \"lowr\"",
            "the extension of arm.toml names the part \"lowr\"",
        ),
        ("girth = 0.05", "grith = 0.05", "coefficient thickness names the factor \"grith\""),
        (
            "[[part.metaball]]",
            "parent = \"upper\"\n[[part.metaball]]",
            "flesh.toml:15: unknown field `parent`",
        ),
        ("extends = \"arm.toml\"", "extends = \"flesh.toml\"", "flesh.toml extends itself"),
        ("extends = \"arm.toml\"", "extends = \"round.toml\"", "flesh.toml extends itself"),
        (
            "extends = \"arm.toml\"",
            "extends = \"broken.toml\"",
            "broken.toml: joint elbow: the axis",
        ),
    ] {
        assert!(FLESH.contains(from), "{from}");
        let text = FLESH.replacen(from, to, 1);
        let broken = ARM.replacen("axis = \"-y\"", "axis = \"w\"", 1);
        let round = "name = \"round\"\nextends = \"./flesh.toml\"\n";
        let folder =
            folder_of(&[("flesh.toml", &text), ("broken.toml", &broken), ("round.toml", round)]);
        let message = model::load("flesh.toml", folder.path()).unwrap_err().to_string();
        assert!(message.contains(said), "{message}");
        assert!(!message.contains('\n'), "{message}");
    }
}

#[test]
fn points_of_both_sides_are_pairs_right_and_left() {
    let model = model::load("human-ellipsoids", Path::new("")).unwrap();
    let named = |i: usize| model.points[i].name.as_str();
    let pairs = model.point_pairs();
    assert!(pairs.iter().any(|(r, l)| (named(*r), named(*l)) == ("RAnkle", "LAnkle")));
    assert!(pairs.iter().all(|(r, l)| named(*r)[1..] == named(*l)[1..]));
}
