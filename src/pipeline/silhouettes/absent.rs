//! Limbs that are not where a body has them: depth shows what stands behind.
//!
//! A contour can be drawn around nobody. An arm that a fit holds away from the trunk, while it swings behind the trunk, is drawn to the
//! edges of the furniture there, and nothing draws it back. But depth tells: a centre of a metaball lies within the flesh,
//! so no camera sees anything farther there. Of the centres of a part and of those that hang on it, over all views in which a
//! depth is known there, let a be the share at which the depth is farther than the centre by more than a limb is thick. A part
//! with a > ½ is absent. So are those that hang on it, and the one on which it hangs, but for the trunk: an upper arm that
//! leads to no forearm is not where it is thought to be, though its centres lie before the trunk. Where a nearer thing hides a
//! centre, nothing speaks against the part. What a was of limbs that were right and lost is in docs/decisions, 0050.

use nalgebra::Point3;

use super::filter::rounded;
use crate::body::{PartId, Posed, towards_root};
use crate::stereo::DepthMap;

/// A limb is no thicker than this, m: so much behind a centre is not the limb's own skin.
const BEHIND_M: f64 = 0.15;
/// Above this share more depths speak against a part than for it.
const MOSTLY: f64 = 0.5;
/// Fewer centres with a depth do not tell.
const LEAST_KNOWN: usize = 4;

/// The parts of a body that depth sees through, in the order of the body's parts.
pub(super) fn absent_parts<'m>(
    maps: impl Iterator<Item = &'m DepthMap>,
    body: &Posed<'_>,
) -> Vec<PartId> {
    let maps: Vec<&DepthMap> = maps.collect();
    let parents = body.model.part_parents();
    let mut known = vec![(0_usize, 0_usize); parents.len()];
    for ball in &body.model.metaballs {
        let centre = Point3::from(body.primitive(ball).centre);
        for is_behind in maps.iter().filter_map(|map| shows_behind(map, &centre)) {
            for part in towards_root(&parents, ball.part.0) {
                let (behind, all) = &mut known[part];
                (*behind, *all) = (*behind + usize::from(is_behind), *all + 1);
            }
        }
    }
    let is_seen_through = |part: usize| {
        let (behind, all) = known[part];
        all >= LEAST_KNOWN && behind as f64 > MOSTLY * all as f64
    };

    // and what hangs together with them
    let is_branch =
        |part: usize| parents.iter().filter(|parent| **parent == Some(part)).count() > 1;
    let is_absent = |part: usize| {
        let carries = (0..parents.len()).any(|p| parents[p] == Some(part) && is_seen_through(p));
        towards_root(&parents, part).any(is_seen_through) || carries && !is_branch(part)
    };
    (0..parents.len()).filter(|part| is_absent(*part)).map(PartId).collect()
}

/// Whether a camera sees something behind a place; `None` where it sees no depth.
fn shows_behind(map: &DepthMap, place: &Point3<f64>) -> Option<bool> {
    let camera = &map.pair.left.camera;
    let (x, y) = rounded(&camera.project_undistorted(place)?)?;
    let disparity = map.disparities.get(x, y).filter(|d| d.is_finite())?;
    Some(map.pair.depth_m(disparity) > (camera.camera_from_world * place).z + BEHIND_M)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_2;
    use std::path::Path;

    use nalgebra::{Point2, Rotation3, Vector3};

    use super::*;
    use crate::body::{BodyModel, Motion, Shape};
    use crate::camera::{Camera, Distortion, Intrinsics};
    use crate::image::Plane;
    use crate::io::model;
    use crate::math::Rigid3;
    use crate::stereo::{RectifiedPair, StereoView};

    const SIZE: usize = 100;

    /// What a camera at the origin that looks along y, and another 20 cm to its right, see: how far it is in each pixel, m.
    fn map(depth_m: impl Fn(usize, usize) -> f64) -> DepthMap {
        let view = |x_m: f64| StereoView {
            camera: Camera {
                name: "camera".into(),
                width_px: SIZE as u32,
                height_px: SIZE as u32,
                intrinsics: Intrinsics {
                    fx_px: 150.0,
                    fy_px: 150.0,
                    cx_px: 49.5,
                    cy_px: 49.5,
                    skew_px: 0.0,
                },
                distortion: Distortion::None,
                camera_from_world: Rigid3::translation(-x_m, 0.0, 0.0)
                    * Rigid3::rotation(Vector3::new(FRAC_PI_2, 0.0, 0.0)),
            },
            image: Plane::filled(SIZE, SIZE, 0.0),
        };
        let pixels = (0..SIZE).flat_map(|y| (0..SIZE).map(move |x| (x, y)));
        let disparities = pixels.map(|(x, y)| (150.0 * 0.2 / depth_m(x, y)) as f32);
        DepthMap {
            pair: RectifiedPair { left: view(0.0), right: view(0.2) },
            disparities: Plane::from_values(SIZE, SIZE, disparities.collect()).unwrap(),
            points: Vec::new(),
        }
    }

    /// Four metres before the camera and turned to it, an arm away from the trunk.
    fn standing(model: &BodyModel) -> Motion {
        let mut motion = Motion::rest(model);
        motion.position_world.y = 4.0;
        motion.world_from_root = Rotation3::from_axis_angle(&Vector3::z_axis(), -FRAC_PI_2);
        motion.angles[model.joint("shoulder_abduction_l").unwrap().0] = 1.2;
        motion
    }

    #[test]
    fn a_forearm_before_which_the_room_is_seen_is_absent_and_what_is_hidden_or_unknown_is_not() {
        let model = model::load("human-metaballs", Path::new("")).unwrap();
        let shape = Shape(model.statistics.mean.clone());
        let body = Posed::new(&model, &shape, &standing(&model));
        let absent = |map: &DepthMap| -> Vec<String> {
            let parts = absent_parts([map].into_iter(), &body);
            parts.iter().map(|part| model.parts[part.0].name.clone()).collect()
        };
        let nobody: Vec<String> = Vec::new();

        // the body itself, a curtain before it, and a picture without texture
        assert_eq!(absent(&map(|_, _| 4.0)), nobody);
        assert_eq!(absent(&map(|_, _| 2.0)), nobody);
        assert_eq!(absent(&map(|_, _| f64::NAN)), nobody);
        assert_eq!(absent(&map(|_, _| 9.0)).len(), model.parts.len());

        // the wall where the forearm should be
        let camera = map(|_, _| 4.0).pair.left.camera;
        let named = |name: &str| {
            let place = model.points.iter().position(|p| p.name == name).unwrap();
            camera.project_undistorted(&body.points()[place]).unwrap()
        };
        let (elbow, wrist) = (named("LElbow"), named("LWrist"));
        let away = (wrist - elbow).try_normalize(0.0).unwrap();
        let is_forearm = |x: usize, y: usize| {
            let from_elbow = Point2::new(x as f64, y as f64) - elbow;
            let along = from_elbow.dot(&away);
            along > 0.0 && (from_elbow - along * away).norm() < 6.0
        };
        let found = absent(&map(|x, y| if is_forearm(x, y) { 9.0 } else { 4.0 }));
        assert_eq!(found, ["upper_arm_l", "forearm_l", "hand_l"]);
    }
}
