//! Flesh near a joint that turns by a share of its angles.

use std::path::Path;

use maquette::body::{BodyModel, EllipsoidJacobians, Layout, Motion, Posed, Shape, State};
use maquette::body::{check_kinematics, metaball::check_field};
use maquette::io::model::{self, ModelFileError};
use nalgebra::{Point3, Vector3};

/// An upper and a lower part, two angles between them, with an ellipsoid and a metaball at the lower part's top.
fn elbow(follows: &str) -> Result<BodyModel, ModelFileError> {
    let text = format!(
        r#"
name = "elbow"
root = {{ fixed = true }}
[[coefficient]]
name = "length"
sd = 0.1
[[part]]
name = "upper"
scale = ["", "", "length"]
[[part.metaball]]
centre = [0.0, 0.0, -0.1]
radii = [0.06, 0.07, 0.1]
[[part]]
name = "lower"
parent = "upper"
at = [0.0, 0.0, -0.3]
[[part.joint]]
name = "flexion"
axis = "-y"
limits_deg = [-10.0, 150.0]
spread_deg = 40.0
speed_deg = 200.0
[[part.joint]]
name = "twist"
axis = "z"
limits_deg = [-90.0, 90.0]
spread_deg = 40.0
speed_deg = 200.0
[[part.ellipsoid]]
centre = [0.0, 0.0, -0.1]
radii = [0.04, 0.05, 0.1]
{follows}
[[part.metaball]]
centre = [0.01, 0.0, -0.05]
radii = [0.06, 0.07, 0.1]
{follows}
[[part.metaball]]
centre = [0.0, 0.0, -0.2]
radii = [0.05, 0.06, 0.1]
"#
    );
    model::parse(&text, Path::new("elbow.toml"))
}

fn bent(model: &BodyModel, flexion: f64, twist: f64) -> State {
    let mut motion = Motion::rest(model);
    (motion.angles[0], motion.angles[1]) = (flexion, twist);
    State { shape: Shape(model.statistics.mean.clone()), motion }
}

fn centre(model: &BodyModel, state: &State) -> Vector3<f64> {
    Posed::new(model, &state.shape, &state.motion).ellipsoids()[0].centre
}

#[test]
fn it_lies_where_a_part_lies_that_is_bent_by_its_share() {
    let (soft, rigid) = (elbow("follows = 0.4").unwrap(), elbow("").unwrap());
    let half_way = centre(&rigid, &bent(&rigid, 0.4 * 1.5, 0.4 * 0.3));
    let soft = centre(&soft, &bent(&soft, 1.5, 0.3));
    approx::assert_relative_eq!(soft, half_way, epsilon = 1e-12);
}

#[test]
fn primitives_of_one_share_have_one_frame() {
    let model = elbow("follows = 0.4").unwrap();
    assert_eq!(model.followers.len(), 2);
    assert_eq!(model.ellipsoids[0].frame, model.metaballs[1].frame);
    assert!(elbow("follows = 1.0").unwrap().followers.is_empty());
}

#[test]
fn its_derivatives_are_those_of_its_place() {
    let model = elbow("follows = 0.4").unwrap();
    for (flexion, twist) in [(0.0, 0.0), (1e-8, 0.0), (1.2, -0.7)] {
        let state = bent(&model, flexion, twist);
        check_kinematics(&model, &state, 1e-7).unwrap();
        for x in [[0.02, 0.01, -0.33], [0.2, 0.1, -0.3]] {
            check_field(&model, &state, &Point3::from(x), 1e-6).unwrap();
        }
    }
    let components = &EllipsoidJacobians::new(&model).components[0];
    let layout = Layout::new(&model);
    assert_eq!(components.len(), 3, "{components:?} of {}", layout.total());
}

#[test]
fn a_share_that_is_none_is_refused() {
    let complaint = elbow("follows = 1.5").unwrap_err().to_string();
    assert!(complaint.contains("follows of part lower"), "{complaint}");
    assert!(complaint.contains("1.5"), "{complaint}");
}
