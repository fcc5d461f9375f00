//! The outline of a soft body that a camera is expected to see.
//!
//! *Outer* contours bound the body against the background; *inner* ones bound a limb against another limb behind it, as an
//! arm in front of the trunk. They are kept apart, for the outer ones alone are the silhouette: PF02 Fig. 3's frame 100 has a
//! "circular silhouette curve at the inside of the model's arm" that "corresponds to nothing".
//!
//! The skin is that of the limb whose sum is largest, so the body is the union of its limbs' skins. The outer contours are
//! those of the union's mask (by casting rays, see [`super::silhouette`]). An inner contour is a piece of a limb's own contour
//! within the union, where the limb is the nearest that the line of sight meets and another lies behind it. Folds of one
//! limb in front of itself (a forearm in front of its upper arm) are not found.
//!
//! Depth and part of a point are those of the largest F on the line of sight one pixel inwards. Of a body whose surface lies b outside
//! the model's, an outer point lies b f/z farther out.

use nalgebra::{Point2, Point3, Vector2, Vector3};

use super::profile::{Bump, RayProfile};
use super::raycast::limb_silhouettes;
use crate::body::metaball::{Field, THRESHOLD};
use crate::body::{PartId, Posed};
use crate::camera::{Camera, Distortion};
use crate::image::{Mask, Runs, resample, trace};

/// How far inside the contour a point's line of sight is taken, px.
const INWARDS_PX: f64 = 1.0;
/// How far outside it a limb behind is looked for, px.
const OUTWARDS_PX: f64 = 1.5;
/// A limb is in front of another if its middle is nearer by this, m. Half a forearm and half a trunk touch at about 0.15.
const BEFORE_M: f64 = 0.08;
/// Metaballs that add no more than this to F on a line of sight are left out.
const NEGLIGIBLE: f64 = 1e-4;
/// Inner contours of fewer points are left out.
const SHORTEST: usize = 8;

/// A point of the expected outline. Undistorted pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OutlinePoint {
    /// Where.
    pub pixel: Point2<f64>,
    /// The part that is seen there.
    pub part: PartId,
    /// Its depth in front of the camera, m.
    pub depth_m: f64,
}

/// What a camera is expected to see of a body's outline.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ModelOutline {
    /// Closed, with the body on the left as seen on the screen; also around holes.
    pub outer: Vec<Vec<OutlinePoint>>,
    /// Open, with the nearer limb on the left.
    pub inner: Vec<Vec<OutlinePoint>>,
}

/// The outline of a posed body in the camera without its lens, a point about every `spacing_px`.
///
/// Where the image cuts the body, its contour runs along the image's edge.
pub fn outline(camera: &Camera, body: &Posed<'_>, spacing_px: f64) -> ModelOutline {
    let camera = &Camera { distortion: Distortion::None, ..camera.clone() };
    let field = Field::from_body(body);
    let sight = LinesOfSight { camera, field: &field, body };

    // 1. the union's contours
    let limbs = limb_silhouettes(camera, &field);
    let (width, height) = (camera.width_px as usize, camera.height_px as usize);
    let is_body = |x: usize, y: usize| limbs.iter().any(|limb| limb.is_foreground(x, y));
    let contours = trace(&Runs::from_mask(&Mask::from_fn(width, height, is_body)));
    let outer = contours.iter().map(|closed| {
        let points = resample(closed, spacing_px);
        let point = |i: usize| {
            let outward = outward(&points, i);
            let mut point = sight.outer_point(&points[i], &(-outward * INWARDS_PX))?;
            point.pixel += outward * sight.offset_px(&point);
            Some(point)
        };
        (0..points.len()).filter_map(point).collect()
    });
    let outer = outer.filter(|curve: &Vec<_>| !curve.is_empty()).collect();

    // 2. each limb's, where it lies in front of another limb
    let mut inner = Vec::new();
    for (limb, mask) in limbs.iter().enumerate() {
        for closed in trace(&Runs::from_mask(mask)) {
            sight.inner_pieces(limb, &resample(&closed, spacing_px), &mut inner);
        }
    }
    ModelOutline { outer, inner }
}

/// Unit normal of a closed polyline, away from what is on its left as seen on the screen; 0 where it turns back.
fn outward(points: &[Point2<f64>], i: usize) -> Vector2<f64> {
    let n = points.len();
    let along = points[(i + 1) % n] - points[(i + n - 1) % n];
    let normal = Vector2::new(-along.y, along.x).try_normalize(f64::EPSILON);
    normal.unwrap_or_else(Vector2::zeros)
}

/// The lines of sight of a camera through the field of a body.
struct LinesOfSight<'a> {
    camera: &'a Camera,
    field: &'a Field,
    body: &'a Posed<'a>,
}

/// Where F of a limb is largest on a line of sight.
struct Summit {
    limb: usize,
    depth_m: f64,
    value: f64,
    /// The metaball with the largest share there.
    metaball: usize,
}

impl LinesOfSight<'_> {
    /// Where F of a limb is largest on the line of sight of a pixel; `None` if it is negligible.
    fn summit(&self, pixel: &Point2<f64>, limb: usize) -> Option<Summit> {
        let origin = self.camera.centre_world().coords;
        let normalized = self.camera.intrinsics.normalized(pixel);
        let turn = self.camera.camera_from_world.rotation.inverse();
        // its length in depth is 1
        let direction: Vector3<f64> = turn * normalized.push(1.0);

        let balls = self.field.limbs[limb].iter().copied();
        let bumps = balls.map(|i| {
            let bump = Bump::on_ray(&self.field.metaballs[i], &origin, &direction);
            (i, bump)
        });
        let near = bumps.filter(|(_, bump)| bump.peak > NEGLIGIBLE);
        let (near, bumps): (Vec<usize>, Vec<Bump>) = near.unzip();

        let profile = RayProfile { bumps };
        let (depth_m, value) = profile.summit()?;
        let share = |k: &usize| profile.bumps[*k].value(depth_m);
        let heaviest = (0..near.len()).max_by(|a, b| share(a).total_cmp(&share(b)))?;

        Some(Summit { limb, depth_m, value, metaball: near[heaviest] })
    }

    /// The limbs that the line of sight of a pixel meets.
    fn limbs_met(&self, pixel: &Point2<f64>) -> Vec<Summit> {
        (0..self.field.limbs.len())
            .filter_map(|limb| self.summit(pixel, limb))
            .filter(|s| s.value >= THRESHOLD)
            .collect()
    }

    /// A point of the outer contour, on the limb that its line of sight meets or else comes nearest to.
    fn outer_point(&self, pixel: &Point2<f64>, inwards: &Vector2<f64>) -> Option<OutlinePoint> {
        let all = (0..self.field.limbs.len()).filter_map(|l| self.summit(&(pixel + inwards), l));
        let largest = all.max_by(|a, b| a.value.total_cmp(&b.value))?;
        self.placed(pixel, &largest)
    }

    /// How far the person's surface lies outside the model's at a point of its outline, px.
    fn offset_px(&self, point: &OutlinePoint) -> f64 {
        let sight = self.camera.intrinsics.normalized(&point.pixel).push(1.0);
        let place = self.camera.camera_from_world.inverse() * Point3::from(sight * point.depth_m);
        let offset = self.body.surface_offset_at(point.part, &place);
        let focal_px = self.camera.intrinsics.focal_px();
        offset.map_or(0.0, |offset| offset.value_m * focal_px / point.depth_m)
    }

    /// A point with depth and part of a summit.
    fn placed(&self, pixel: &Point2<f64>, summit: &Summit) -> Option<OutlinePoint> {
        let source = self.field.source(summit.metaball)?;
        Some(OutlinePoint {
            pixel: *pixel,
            part: self.body.model.metaballs[source].part,
            depth_m: summit.depth_m,
        })
    }

    /// The pieces of a limb's contour where it lies in front of another limb.
    fn inner_pieces(
        &self,
        limb: usize,
        points: &[Point2<f64>],
        pieces: &mut Vec<Vec<OutlinePoint>>,
    ) {
        let mut piece = Vec::new();
        for i in 0..points.len() {
            match self.inner_point(limb, &points[i], &outward(points, i)) {
                Some(point) => piece.push(point),
                None if piece.len() >= SHORTEST => pieces.push(std::mem::take(&mut piece)),
                None => piece.clear(),
            }
        }
        if piece.len() >= SHORTEST {
            pieces.push(piece);
        }
    }

    /// A point of a limb's contour; `None` unless it lies in front of another limb, and no other hides it.
    fn inner_point(
        &self,
        limb: usize,
        pixel: &Point2<f64>,
        outward: &Vector2<f64>,
    ) -> Option<OutlinePoint> {
        let is_other = |s: &Summit| s.limb != limb;

        // another limb just outside the contour
        let behind = self.limbs_met(&(pixel + outward * OUTWARDS_PX));
        let others = behind.iter().filter(|s| is_other(s));
        let nearest = others.map(|s| s.depth_m).reduce(f64::min)?;

        // and none in front of it, just inside
        let inwards = pixel - outward * INWARDS_PX;
        let own = self.summit(&inwards, limb)?;
        let mut met = self.limbs_met(&inwards).into_iter();
        let is_hidden = met.any(|s| is_other(&s) && s.depth_m < own.depth_m);
        let is_before = nearest - own.depth_m > BEFORE_M;
        match is_before && !is_hidden {
            true => self.placed(pixel, &own),
            false => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::body::{BodyModel, Motion};
    use crate::camera::Intrinsics;
    use crate::math::Rigid3;

    /// Looks at the body from 4 m before it, against the world's x axis.
    fn camera() -> Camera {
        let towards = nalgebra::Rotation3::from_matrix_unchecked(nalgebra::Matrix3::new(
            0.0, 1.0, 0.0, 0.0, 0.0, -1.0, -1.0, 0.0, 0.0,
        ));
        Camera {
            name: "front".into(),
            width_px: 300,
            height_px: 400,
            intrinsics: Intrinsics {
                fx_px: 600.0,
                fy_px: 600.0,
                cx_px: 150.0,
                cy_px: 200.0,
                skew_px: 0.0,
            },
            distortion: Distortion::None,
            camera_from_world: Rigid3::from_parts(
                Vector3::new(0.0, 0.0, 4.0).into(),
                nalgebra::UnitQuaternion::from_rotation_matrix(&towards),
            ),
        }
    }

    fn human() -> BodyModel {
        crate::io::model::load("human-metaballs", Path::new("")).unwrap()
    }

    fn seen(change: impl Fn(&BodyModel, &mut Motion)) -> (BodyModel, ModelOutline) {
        let model = human();
        let mut motion = Motion::rest(&model);
        change(&model, &mut motion);
        let shape = crate::body::Shape(model.statistics.mean.clone());
        let found = outline(&camera(), &Posed::new(&model, &shape, &motion), 2.0);
        (model, found)
    }

    #[test]
    fn the_outline_of_a_standing_person_is_seen_at_their_depth_and_names_head_and_feet() {
        let (model, found) = seen(|_, _| ());
        let outer: Vec<_> = found.outer.iter().flatten().collect();
        assert!(outer.len() > 200, "{}", outer.len());
        assert!(outer.iter().all(|p| (p.depth_m - 4.0).abs() < 0.5));
        let highest = outer.iter().min_by(|a, b| a.pixel.y.total_cmp(&b.pixel.y)).unwrap();
        assert!(model.parts[highest.part.0].name.to_lowercase().contains("head"));
    }

    #[test]
    fn of_a_body_in_thick_clothes_the_outline_lies_as_far_out_as_the_clothes_are_thick() {
        let model = human().detailed();
        let motion = Motion::rest(&model);
        let highest = |clothes_m: f64| {
            let mut shape = crate::body::Shape(model.statistics.mean.clone());
            let offsets = model.offsets.as_ref().unwrap();
            shape.0.rows_mut(offsets.first().0, offsets.count()).fill(clothes_m);
            let found = outline(&camera(), &Posed::new(&model, &shape, &motion), 2.0);
            let points = found.outer.into_iter().flatten();
            points.min_by(|a, b| a.pixel.y.total_cmp(&b.pixel.y)).unwrap()
        };
        let (bare, dressed) = (highest(0.0), highest(0.02));
        let out_px = 0.02 * 600.0 / bare.depth_m;
        approx::assert_abs_diff_eq!(bare.pixel.y - dressed.pixel.y, out_px, epsilon = 0.2);
    }

    #[test]
    fn the_limbs_masks_together_are_the_bodys() {
        let model = human();
        let shape = crate::body::Shape(model.statistics.mean.clone());
        let mut motion = Motion::rest(&model);
        for (i, angle) in motion.angles.iter_mut().enumerate() {
            *angle = [0.3, -0.2, 0.5][i % 3];
        }
        let field = Field::from_body(&Posed::new(&model, &shape, &motion));
        let lens = Distortion::Fisheye { k1: -0.05, k2: 0.01, k3: 0.0, k4: 0.0 };
        for distortion in [Distortion::None, lens] {
            let camera = Camera { distortion, ..camera() };
            let limbs = limb_silhouettes(&camera, &field);
            assert!(limbs.len() > 1);
            let whole = super::super::silhouette(&camera, &field);
            let together =
                Mask::from_fn(300, 400, |x, y| limbs.iter().any(|l| l.is_foreground(x, y)));
            assert_eq!(together, whole);
        }
    }

    #[test]
    fn a_forearm_before_the_trunk_has_an_inner_contour_and_arms_beside_it_have_none() {
        let turned = |by: &[(&str, f64)]| {
            let (model, found) = seen(|model, motion| {
                for (joint, angle) in model.joints.iter().zip(&mut motion.angles) {
                    let turn = by.iter().find(|(name, _)| joint.name.starts_with(name));
                    *angle = turn.map_or(*angle, |(_, to)| *to);
                }
            });
            let inner: Vec<_> = found.inner.iter().flatten().collect();
            let of_arm = |p: &&&OutlinePoint| {
                let name = &model.parts[p.part.0].name;
                name.contains("forearm") || name.contains("hand")
            };
            inner.iter().filter(of_arm).count()
        };
        assert!(turned(&[("shoulder_abduction", 0.8)]) < 10);
        // turned in, whichever way in is
        let before = [1.2, -1.2]
            .map(|rotation| turned(&[("elbow_flexion", 1.6), ("shoulder_rotation", rotation)]));
        assert!(before[0].max(before[1]) > 20, "{before:?}");
    }

    #[test]
    fn a_body_behind_the_camera_has_no_outline() {
        let (_, found) = seen(|_, motion| motion.position_world.x = 30.0);
        assert_eq!(found, ModelOutline::default());
    }
}
