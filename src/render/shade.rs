//! A shaded picture of a metaball body.

use nalgebra::{Point2, Point3, SVector, UnitQuaternion, Vector3};

use super::profile::{Bump, RayProfile};
use super::{Canvas, Rgb};
use crate::body::metaball::{Field, Metaball, THRESHOLD};
use crate::camera::{Camera, Distortion, Intrinsics};
use crate::image::Plane;
use crate::math::Rigid3;
use crate::math::quadric::{Ellipsoid, project};

const BACKGROUND: Rgb = [255, 255, 255];
/// Colour of the skin in full light.
const SKIN: [f64; 3] = [236.0, 188.0, 160.0];
/// Share of the light that comes from everywhere, and from the lamp.
const LIGHT: [f64; 2] = [0.3, 0.7];
/// Towards the lamp, in the camera frame: over the left shoulder of the viewer.
const LAMP: [f64; 3] = [-0.4, -0.6, -0.75];
/// A metaball is left out of rays on which its d is never less than this.
const FARTHEST: f64 = 6.0;
/// Step along a ray, over the width of the narrowest bump on it.
const STEP: f64 = 0.25;
/// Share of a portrait's width or height that the body fills.
const FILLED: f64 = 0.86;
/// Rays across a pixel, and down it.
const RAYS: usize = 2;

/// The skin F = T of a body, lit from above the camera, on white.
///
/// A ray is cast through four places of each pixel of the recorded, distorted image to the first place where F = T; there
/// the normal is −∇F/‖∇F‖ (Lambert's law, with some light from everywhere).
pub fn shade(camera: &Camera, field: &Field) -> Canvas {
    let (width, height) = (camera.width_px as usize, camera.height_px as usize);
    let mut pixels = Plane::filled(width, height, BACKGROUND);
    let scene = Scene::new(camera, field);

    for y in 0..height {
        for (x, pixel) in pixels.row_mut(y).iter_mut().enumerate() {
            *pixel = scene.pixel(x, y);
        }
    }
    Canvas::from_pixels(pixels)
}

/// A body in front of a camera, and the lamp above it.
struct Scene<'a> {
    camera: &'a Camera,
    field: &'a Field,
    centre: Vector3<f64>,
    lamp: Vector3<f64>,
}

impl<'a> Scene<'a> {
    fn new(camera: &'a Camera, field: &'a Field) -> Self {
        let lamp = camera.camera_from_world.inverse().rotation * Vector3::from(LAMP);
        Self {
            camera,
            field,
            centre: camera.centre_world().coords,
            lamp: lamp.try_normalize(0.0).unwrap_or(lamp),
        }
    }

    /// The mean colour that the rays of one pixel see.
    fn pixel(&self, x: usize, y: usize) -> Rgb {
        let within = |k: usize| (k as f64 + 0.5) / RAYS as f64 - 0.5;
        let places = (0..RAYS * RAYS).map(|k| (within(k % RAYS), within(k / RAYS)));
        let mut sum = [0.0; 3];
        for (right, down) in places {
            let place = Point2::new(x as f64 + right, y as f64 + down);
            let light = self.camera.undistort(&place).and_then(|p| self.light(&p));
            for (k, sum) in sum.iter_mut().enumerate() {
                *sum += light.map_or(f64::from(BACKGROUND[k]), |light| SKIN[k] * light);
            }
        }
        sum.map(|s| (s / (RAYS * RAYS) as f64).round() as u8)
    }

    /// How bright the skin is where a line of sight first meets it, 0 to 1.
    fn light(&self, undistorted_px: &Point2<f64>) -> Option<f64> {
        let direction = self.camera.ray(undistorted_px).direction_world.into_inner();
        let limbs = self.field.limbs.iter();
        let hits = limbs.filter_map(|limb| self.first_hit(limb, &direction));
        let nearest = hits.min_by(f64::total_cmp)?;

        let place = self.centre + direction * nearest;
        let (_, gradient) = self.field.value_and_gradient(&place);
        let normal = -gradient.try_normalize(1e-12)?;
        let [everywhere, lamp] = LIGHT;
        Some(everywhere + lamp * normal.dot(&self.lamp).max(0.0))
    }

    /// Where a ray first meets the skin of a limb, metres from the camera.
    fn first_hit(&self, limb: &[usize], direction: &Vector3<f64>) -> Option<f64> {
        let balls = limb.iter().map(|&i| &self.field.metaballs[i]);
        let bumps = balls.filter_map(|ball| self.bump(ball, direction));
        let profile = RayProfile { bumps: bumps.collect() };
        if !profile.reaches(THRESHOLD) {
            return None;
        }

        // from before the first bump to behind the last
        let width = |b: &Bump| (4.0 * FARTHEST / b.sharpness).sqrt();
        let begin = profile.bumps.iter().map(|b| b.at - width(b));
        let end = profile.bumps.iter().map(|b| b.at + width(b));
        let (begin, end) = (begin.fold(f64::MAX, f64::min), end.fold(0.0, f64::max));

        let narrow = profile.bumps.iter().map(|b| b.sharpness.sqrt().recip());
        let step = STEP * narrow.fold(f64::MAX, f64::min);
        let mut outside = begin.max(0.0);
        while outside < end {
            let next = outside + step;
            if profile.value(next) >= THRESHOLD {
                return Some(crossing(&profile, outside, next));
            }
            outside = next;
        }
        None
    }

    fn bump(&self, ball: &Metaball, direction: &Vector3<f64>) -> Option<Bump> {
        let bump = Bump::on_ray(ball, &self.centre, direction);
        (bump.peak > (-2.0 * FARTHEST).exp()).then_some(bump)
    }
}

/// F = T between a place outside and one inside, by halving.
fn crossing(profile: &RayProfile, mut outside: f64, mut inside: f64) -> f64 {
    while inside - outside > 1e-5 {
        let middle = 0.5 * (outside + inside);
        if profile.value(middle) < THRESHOLD {
            outside = middle;
        } else {
            inside = middle;
        }
    }
    inside
}

/// A camera that sees the whole of a body from the front and its left, a little from above; the front is the world's x.
///
/// `None` if there is nothing to see.
pub fn portrait_camera(field: &Field, width_px: u32, height_px: u32) -> Option<Camera> {
    let (low, high) = bounds(field.metaballs.iter().map(|ball| {
        // half the extent of the ball's own skin along each axis
        let shape = ball.ellipsoid.shape;
        let half = shape.diagonal().map(|a| 0.59 * a.max(0.0).sqrt());
        (ball.ellipsoid.centre - half, ball.ellipsoid.centre + half)
    }))?;
    let middle = Point3::from((low + high) * 0.5);
    let radius = 0.5 * (high - low).norm();
    let towards = Vector3::new(0.80, 0.52, 0.30);
    let eye = middle + towards * (4.0 * radius);

    // looks at the middle with the world's z up: x right, y down, z forward
    let turn = UnitQuaternion::look_at_rh(&(middle - eye), &Vector3::z());
    let flip = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI);
    let rotation = flip * turn;
    let translation = -(rotation * eye.coords);

    let mut camera = Camera {
        name: "portrait".into(),
        width_px,
        height_px,
        intrinsics: Intrinsics { fx_px: 1.0, fy_px: 1.0, cx_px: 0.0, cy_px: 0.0, skew_px: 0.0 },
        distortion: Distortion::None,
        camera_from_world: Rigid3::from_parts(translation.into(), rotation),
    };
    camera.intrinsics = framed(&camera, field)?;
    Some(camera)
}

/// The intrinsics with which a body fills the image but for a margin; `camera` has a focal length of 1.
fn framed(camera: &Camera, field: &Field) -> Option<Intrinsics> {
    let boxes = field.metaballs.iter().map(|ball| {
        let own_skin = Ellipsoid {
            centre: ball.ellipsoid.centre,
            shape: ball.ellipsoid.shape * (0.5 * std::f64::consts::LN_2),
        };
        let ellipse = project(&camera.projection(), &own_skin)?;
        let half = ellipse.shape.diagonal().map(f64::sqrt);
        Some((ellipse.centre - half, ellipse.centre + half))
    });
    let (low, high) = bounds(boxes.collect::<Option<Vec<_>>>()?)?;

    let (width, height) = (f64::from(camera.width_px), f64::from(camera.height_px));
    let extent = high - low;
    let focal_px = FILLED * (width / extent.x).min(height / extent.y);
    let middle = (low + high) * (0.5 * focal_px);
    Some(Intrinsics {
        fx_px: focal_px,
        fy_px: focal_px,
        cx_px: 0.5 * (width - 1.0) - middle.x,
        cy_px: 0.5 * (height - 1.0) - middle.y,
        skew_px: 0.0,
    })
}

/// The corners of the box around boxes, each given by its corners; `None` without any.
fn bounds<const N: usize>(
    boxes: impl IntoIterator<Item = (SVector<f64, N>, SVector<f64, N>)>,
) -> Option<(SVector<f64, N>, SVector<f64, N>)> {
    let boxes = boxes.into_iter();
    boxes.reduce(|a, b| (a.0.inf(&b.0), a.1.sup(&b.1)))
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::body::{Motion, Posed, Shape};

    fn walker() -> Field {
        let model = crate::io::model::load("walker-metaballs", Path::new("")).unwrap();
        let shape = Shape(model.statistics.mean.clone());
        Field::from_body(&Posed::new(&model, &shape, &Motion::rest(&model)))
    }

    #[test]
    fn the_portrait_shows_the_whole_body_and_the_skin_where_the_silhouette_is() {
        let field = walker();
        let camera = portrait_camera(&field, 60, 90).unwrap();
        let picture = shade(&camera, &field);
        let mask = super::super::silhouette(&camera, &field);
        let (mut body, mut differing) = (0, 0);
        for y in 0..90 {
            for x in 0..60 {
                let is_body = mask.is_foreground(x, y);
                let is_drawn = picture.pixels().get(x, y) != Some(BACKGROUND);
                body += usize::from(is_body);
                // a pixel is drawn if any of its four rays hits
                differing += usize::from(is_body && !is_drawn);
                let is_edge = x == 0 || y == 0 || x == 59 || y == 89;
                assert!(!(is_edge && is_drawn), "{x} {y}");
            }
        }
        assert!(body > 300, "{body}");
        assert!(differing * 100 < body, "{differing} of {body}");
    }

    #[test]
    fn what_faces_the_lamp_is_brighter() {
        let ball = Ellipsoid { centre: Vector3::zeros(), shape: nalgebra::Matrix3::identity() };
        let field = Field::new([ball]);
        let camera = portrait_camera(&field, 41, 41).unwrap();
        let picture = shade(&camera, &field);
        let at = |x, y| picture.pixels().get(x, y).unwrap()[0];
        assert!(at(14, 12) > at(20, 20) && at(20, 20) > at(26, 29));
        assert_eq!(at(0, 0), 255);
    }

    #[test]
    fn nothing_has_no_portrait() {
        assert!(portrait_camera(&Field::new([]), 10, 10).is_none());
    }
}
