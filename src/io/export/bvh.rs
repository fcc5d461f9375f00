//! BVH: a skeleton in T-pose, and the rotations that move it as the body moved.
//!
//! Centimetres, Y up, facing +Z, left towards +X. Every bone's axes are the file's in T-pose (upright, legs straight, arms
//! held out sideways), so its OFFSET is its bone in T-pose and a rotation of 0 leaves it there. One translation, at the
//! root; no scale. Rotations are Z X Y, intrinsic, degrees. With W a part's orientation in the world, T that in T-pose
//! and F the file's axes: G = F·W·(F·T)ᵀ, and a bone's channels are those of G_parentᵀ·G.

use std::fmt::Write;

use nalgebra::{Matrix3, Rotation3, Vector3};

use crate::body::{BodyModel, Motion, PartId, Posed, Shape};
use crate::camera::UpAxis;
use crate::gait::cardan_zxy;

/// Why there is no file.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum BvhError {
    /// Not one root.
    #[error("the body {body} has {roots} parts at its root: BVH needs one")]
    Roots {
        /// The model.
        body: String,
        /// Found.
        roots: usize,
    },
    /// No fit in any frame.
    #[error("nobody was seen in any frame")]
    Empty,
}

const CM: f64 = 100.0;
/// Length of the last bone where the model names no point on it, metres.
const LAST_BONE: f64 = 0.1;

/// A bone in the order in which the file lists them.
struct Bone {
    part: PartId,
    /// Place in the list.
    parent: Option<usize>,
    /// From the parent, in T-pose, the file's axes, metres.
    offset: Vector3<f64>,
    /// F·T.
    file_from_part_in_t_pose: Matrix3<f64>,
}

/// The text of a file. A frame without a fit repeats the one before it.
///
/// # Errors
/// [`BvhError`].
pub fn bvh(
    model: &BodyModel,
    shape: &Shape,
    motions: &[Option<Motion>],
    rate_hz: f64,
) -> Result<String, BvhError> {
    let bones = bones(model, shape)?;
    let first = motions.iter().flatten().next().ok_or(BvhError::Empty)?;
    let mut text = "HIERARCHY\n".to_owned();
    joint(&mut text, model, shape, &bones, 0, 0);
    let (frames, step) = (motions.len(), 1.0 / rate_hz);
    let _ = writeln!(text, "MOTION\nFrames: {frames}\nFrame Time: {step:.8}");
    let mut last = first;
    for motion in motions {
        last = motion.as_ref().unwrap_or(last);
        row(&mut text, &Posed::new(model, shape, last), &bones);
    }
    Ok(text)
}

/// All bones, depth first, each after its parent.
fn bones(model: &BodyModel, shape: &Shape) -> Result<Vec<Bone>, BvhError> {
    let roots: Vec<usize> =
        (0..model.parts.len()).filter(|p| model.parts[*p].joint.is_none()).collect();
    let &[root] = roots.as_slice() else {
        let (body, roots) = (model.name.clone(), roots.len());
        return Err(BvhError::Roots { body, roots });
    };

    let straight = Motion::straight(model);
    let body = Posed::new(model, shape, &straight);

    // in the T pose the arms stretch sideways
    let t_pose = |part: usize| {
        let name = &model.parts[part].name;
        let is_arm = ["upper_arm", "forearm", "hand"].iter().any(|n| name.starts_with(n));
        let out = match (is_arm, name.ends_with("_l")) {
            (false, _) => 0.0,
            (true, true) => std::f64::consts::FRAC_PI_2,
            (true, false) => -std::f64::consts::FRAC_PI_2,
        };
        let arm_out = Rotation3::from_axis_angle(&Vector3::x_axis(), out);
        UpAxis::Y.export_from_world() * arm_out.matrix() * body.world_from_part(PartId(part))
    };

    let mut bones = Vec::new();
    let mut waiting = vec![(root, None)];
    while let Some((part, parent)) = waiting.pop() {
        let place = bones.len();
        let offset = match parent {
            None => Vector3::zeros(),
            Some(p) => {
                let parent: &Bone = &bones[p];
                let origin = body.origin_of_part(PartId(part));
                parent.file_from_part_in_t_pose * body.in_part(parent.part, &origin)
            }
        };

        bones.push(Bone {
            part: PartId(part),
            parent,
            offset,
            file_from_part_in_t_pose: t_pose(part),
        });

        let children = (0..model.parts.len()).filter(|c| parent_part(model, *c) == Some(part));
        waiting.extend(children.map(|child| (child, Some(place))));
    }
    Ok(bones)
}

/// The part whose joint is the nearest above this part's.
fn parent_part(model: &BodyModel, part: usize) -> Option<usize> {
    let mut joint = model.joints[model.parts[part].joint?.0].parent;
    loop {
        let found = model.parts.iter().position(|p| p.joint == joint);
        match (found, joint) {
            (Some(found), _) if found != part => return Some(found),
            (_, Some(above)) => joint = model.joints[above.0].parent,
            (_, None) => return None,
        }
    }
}

/// One bone and all below it.
fn joint(
    text: &mut String,
    model: &BodyModel,
    shape: &Shape,
    bones: &[Bone],
    at: usize,
    depth: usize,
) {
    let bone = &bones[at];
    let pad = "  ".repeat(depth);
    let (word, channels) = match bone.parent {
        None => ("ROOT", "6 Xposition Yposition Zposition Zrotation Xrotation Yrotation"),
        Some(_) => ("JOINT", "3 Zrotation Xrotation Yrotation"),
    };

    let name = common_name(&model.parts[bone.part.0].name);
    let _ = writeln!(text, "{pad}{word} {name}\n{pad}{{");
    let _ = writeln!(text, "{pad}  OFFSET {}", numbers(&bone.offset));
    let _ = writeln!(text, "{pad}  CHANNELS {channels}");

    let children = (at + 1..bones.len()).filter(|c| bones[*c].parent == Some(at));
    let mut has_child = false;
    for child in children {
        has_child = true;
        joint(text, model, shape, bones, child, depth + 1);
    }

    if !has_child {
        let end = bone.file_from_part_in_t_pose * tip(model, shape, bone.part);
        let _ = writeln!(
            text,
            "{pad}  End Site\n{pad}  {{\n{pad}    OFFSET {}\n{pad}  }}",
            numbers(&end)
        );
    }

    let _ = writeln!(text, "{pad}}}");
}

/// The point that the model names farthest out on a part, in the part's axes.
fn tip(model: &BodyModel, shape: &Shape, part: PartId) -> Vector3<f64> {
    let motion = Motion::rest(model);
    let body = Posed::new(model, shape, &motion);
    let on_part = model.points.iter().filter(|p| p.places.len() == 1 && p.places[0].0 == part);
    let places = on_part.map(|p| body.in_part(part, &body.point(part, &p.places[0].1)));
    let farthest = places.max_by(|a, b| a.norm().total_cmp(&b.norm()));
    farthest.filter(|p| p.norm() > 0.01).unwrap_or(Vector3::new(0.0, 0.0, -LAST_BONE))
}

fn row(text: &mut String, body: &Posed<'_>, bones: &[Bone]) {
    let turn = |bone: &Bone| {
        let file_from_part = UpAxis::Y.export_from_world() * body.world_from_part(bone.part);
        file_from_part * bone.file_from_part_in_t_pose.transpose()
    };
    let turns: Vec<Matrix3<f64>> = bones.iter().map(turn).collect();
    let root = UpAxis::Y.to_export(&body.origin_of_part(bones[0].part).coords);
    text.push_str(&numbers(&root));
    for (bone, own) in bones.iter().zip(&turns) {
        let local = bone.parent.map_or(*own, |p| turns[p].transpose() * own);
        for angle in cardan_zxy(&local) {
            let _ = write!(text, " {:.6}", angle.to_degrees());
        }
    }
    text.push('\n');
}

/// Centimetres.
fn numbers(place: &Vector3<f64>) -> String {
    let p = place * CM;
    format!("{:.6} {:.6} {:.6}", p.x, p.y, p.z)
}

/// The usual names of bones in motion capture; other parts keep their own.
fn common_name(part: &str) -> String {
    let (bare, side) = match (part.strip_suffix("_l"), part.strip_suffix("_r")) {
        (Some(bare), _) => (bare, "Left"),
        (_, Some(bare)) => (bare, "Right"),
        _ => (part, ""),
    };

    let name = match bare {
        "pelvis" => "Hips",
        "abdomen" => "Spine",
        "thorax" => "Chest",
        "neck" => "Neck",
        "head" => "Head",
        "upper_arm" => "Arm",
        "forearm" => "ForeArm",
        "hand" => "Hand",
        "thigh" => "UpLeg",
        "shank" => "Leg",
        "foot" => "Foot",
        other => other,
    };

    format!("{side}{name}")
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    /// Bones' places at each frame, read back from a text by forward kinematics.
    fn places(text: &str) -> Vec<(String, Vector3<f64>, Option<usize>)> {
        let mut bones = Vec::new();
        let mut open: Vec<Option<usize>> = Vec::new();
        let mut words = text.split_whitespace();
        while let Some(word) = words.next() {
            match word {
                "ROOT" | "JOINT" => {
                    let parent = open.iter().rev().flatten().next().copied();
                    bones.push((words.next().unwrap().to_owned(), Vector3::zeros(), parent));
                    open.push(Some(bones.len() - 1));
                }
                "End" => open.push(None),
                "}" => drop(open.pop()),
                "OFFSET" => {
                    let mut number = || words.next().unwrap().parse::<f64>().unwrap();
                    let offset = Vector3::new(number(), number(), number());
                    if let Some(Some(at)) = open.last() {
                        bones[*at].1 = offset;
                    }
                }
                "MOTION" => break,
                _ => {}
            }
        }
        bones
    }

    #[test]
    fn the_skeleton_stands_in_t_pose_and_moves_its_joints_to_where_the_body_has_them() {
        let model = crate::io::model::load("human-ellipsoids", Path::new("")).unwrap();
        let shape = Shape(model.statistics.mean.clone());
        let mut motion = Motion::rest(&model);
        motion.position_world = Vector3::new(0.3, -0.2, 0.9);
        motion.world_from_root = Rotation3::from_euler_angles(0.1, -0.2, 0.7);
        for (i, angle) in motion.angles.iter_mut().enumerate() {
            *angle += 0.3 * (i as f64).sin();
        }
        let text = bvh(&model, &shape, &[Some(motion.clone())], 50.0).unwrap();
        let bones = places(&text);
        let numbers: Vec<f64> =
            text.lines().last().unwrap().split(' ').map(|n| n.parse().unwrap()).collect();
        assert_eq!(numbers.len(), 3 + 3 * bones.len());
        // forward kinematics of the file: position, then Z X Y
        let mut global: Vec<(Matrix3<f64>, Vector3<f64>)> = Vec::new();
        for (i, (_, offset, parent)) in bones.iter().enumerate() {
            let [z, x, y] = [0, 1, 2].map(|k| numbers[3 + 3 * i + k].to_radians());
            let about = |axis, angle| *Rotation3::from_axis_angle(&axis, angle).matrix();
            let local = about(Vector3::z_axis(), z)
                * about(Vector3::x_axis(), x)
                * about(Vector3::y_axis(), y);
            global.push(match parent {
                None => (local, Vector3::new(numbers[0], numbers[1], numbers[2])),
                Some(p) => (global[*p].0 * local, global[*p].1 + global[*p].0 * offset),
            });
        }
        let body = Posed::new(&model, &shape, &motion);
        for (name, point) in [
            ("LeftForeArm", "LElbow"),
            ("RightFoot", "RAnkle"),
            ("LeftHand", "LWrist"),
            ("Head", ""),
        ] {
            let at = bones.iter().position(|b| b.0 == name).unwrap();
            if let Some(i) = model.point(point) {
                let expected = UpAxis::Y.to_export(&body.points()[i].coords) * CM;
                assert!((global[at].1 - expected).norm() < 1e-3, "{name}");
            }
        }
        // arms sideways, legs down
        let offset = |name: &str| bones.iter().find(|b| b.0 == name).unwrap().1;
        assert!(offset("LeftForeArm").x > 20.0 && offset("RightForeArm").x < -20.0);
        assert!(offset("LeftLeg").y < -35.0 && offset("LeftLeg").x.abs() < 1e-6);
    }
}
