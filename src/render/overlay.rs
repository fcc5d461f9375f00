//! A mask with the fitted body over it, to see at a glance whether the fit is right.

use std::f64::consts::TAU;

use nalgebra::{Matrix2, Point2, Point3, Vector2};

use super::{Canvas, Pen, Rgb};
use crate::body::metaball::Field;
use crate::body::{BodyModel, Posed, Side};
use crate::camera::Camera;
use crate::image::{Mask, Runs, trace};
use crate::math::quadric::{Ellipse, project};

const BACKGROUND: Rgb = [26, 28, 33];
const PERSON: Rgb = [124, 128, 135];
const OUTLINE: Rgb = [255, 190, 40];
const SHADE: Rgb = [12, 13, 16];
/// Joints and bones of neither side.
const MIDDLE: Rgb = [245, 245, 245];
/// Sides, and what belongs to neither.
const SIDES: [Option<Side>; 3] = [Some(Side::Left), Some(Side::Right), None];
/// Share of white in a side's colour, so that it shows before the dark background.
const LIGHTER: f64 = 0.25;

/// Longer side of an image in which lines have their widths as given; they grow with the image, px.
const USUAL_PX: f64 = 800.0;
/// Pieces in which a bone is drawn, as the lens bends it.
const PIECES: usize = 8;

/// The bones between the joint centres, from the middle outwards.
const BONES: [(&str, &str); 16] = [
    ("Hip", "RHip"),
    ("RHip", "RKnee"),
    ("RKnee", "RAnkle"),
    ("RAnkle", "RBigToe"),
    ("Hip", "LHip"),
    ("LHip", "LKnee"),
    ("LKnee", "LAnkle"),
    ("LAnkle", "LBigToe"),
    ("Hip", "Neck"),
    ("Neck", "Head"),
    ("Neck", "RShoulder"),
    ("RShoulder", "RElbow"),
    ("RElbow", "RWrist"),
    ("Neck", "LShoulder"),
    ("LShoulder", "LElbow"),
    ("LElbow", "LWrist"),
];

/// The mask in grey, the outline of the whole body, bones and joints.
///
/// A body of metaballs has the outline of its skin; one of ellipsoids has that of their ellipses, with thin lines where they
/// lie within the body. Everything is drawn where the recorded, distorted image shows it. Limbs
/// have the colours of their sides, lightened.
pub fn overlay(camera: &Camera, mask: &Mask, body: &Posed<'_>) -> Canvas {
    let mut canvas = Canvas::from_mask(mask, BACKGROUND, PERSON);
    let unit = (f64::from(camera.width_px.max(camera.height_px)) / USUAL_PX).max(0.4);
    let pen = |color, opacity, width| Pen { color, opacity, width_px: width * unit };

    // the body's outline, and fainter its parts'
    let (outer, inner) = if body.model.metaballs.is_empty() {
        outlines_of_ellipsoids(camera, body)
    } else {
        (outline_of_skin(camera, body), Vec::new())
    };
    canvas.draw(&inner, pen(OUTLINE, 0.45, 0.8));
    canvas.draw(&outer, pen(SHADE, 0.45, 3.0));
    canvas.draw(&outer, pen(OUTLINE, 1.0, 1.4));

    // a shade under all bones, and over it the bones and joints of each side in its colour
    let points = body.points();
    let side = |point: usize| Side::from_initial(&body.model.points[point].name);
    let bones = bones(body.model).into_iter();
    let bones = bones.map(|(from, to)| (side(to), bone(camera, &points[from], &points[to])));
    let bones: Vec<(Option<Side>, Segments)> = bones.collect();
    let all: Segments = bones.iter().flat_map(|(_, s)| s.clone()).collect();
    canvas.draw(&all, pen(SHADE, 0.6, 4.0));

    let joints = used_points(body.model);
    for of in SIDES {
        let color = colour(of);
        let coloured = bones.iter().filter(|(side, _)| *side == of);
        let segments: Segments = coloured.flat_map(|(_, s)| s.clone()).collect();
        canvas.draw(&segments, pen(color, 1.0, 2.0));

        let dots = joints.iter().filter(|i| side(**i) == of);
        let dots = dots.filter_map(|i| camera.project(&points[*i]));
        let dots: Segments = dots.map(|p| [p, p]).collect();
        canvas.draw(&dots, pen(SHADE, 0.8, 8.0));
        canvas.draw(&dots, pen(color, 1.0, 5.6));
    }
    canvas
}

type Segments = Vec<[Point2<f64>; 2]>;

/// The border of what the camera sees of the skin, in the recorded image.
fn outline_of_skin(camera: &Camera, body: &Posed<'_>) -> Segments {
    let mask = super::silhouette(camera, &Field::from_body(body));
    let borders = trace(&Runs::from_mask(&mask));
    let closed = borders.iter().flat_map(|border| {
        let next = border.iter().cycle().skip(1);
        border.iter().zip(next).map(|(a, b)| [*a, *b])
    });
    closed.collect()
}

/// The pieces of the ellipses' outlines that bound the whole body, and those that lie within it.
fn outlines_of_ellipsoids(camera: &Camera, body: &Posed<'_>) -> (Segments, Segments) {
    let projection = camera.projection();
    let ellipsoids = body.ellipsoids();
    let ellipses = ellipsoids.iter();
    let ellipses = ellipses.filter_map(|e| DrawnEllipse::new(&project(&projection, e)?));
    let ellipses: Vec<DrawnEllipse> = ellipses.collect();

    let (mut outer, mut inner) = (Vec::new(), Vec::new());
    for (i, ellipse) in ellipses.iter().enumerate() {
        for (middle, segment) in ellipse.segments() {
            let mut others = ellipses.iter().enumerate().filter(|(j, _)| *j != i);
            let is_within = others.any(|(_, other)| other.contains(&middle));
            if let [Some(a), Some(b)] = segment.map(|p| recorded(camera, &p)) {
                if is_within { &mut inner } else { &mut outer }.push([a, b]);
            }
        }
    }
    (outer, inner)
}

/// An ellipse whose outline is drawn where it lies in no other.
struct DrawnEllipse {
    centre: Vector2<f64>,
    /// L with Σ = L·Lᵀ.
    root: Matrix2<f64>,
    inverse: Matrix2<f64>,
}

impl DrawnEllipse {
    fn new(ellipse: &Ellipse) -> Option<Self> {
        let cholesky = ellipse.shape.cholesky()?;
        Some(Self { centre: ellipse.centre, root: cholesky.l(), inverse: cholesky.inverse() })
    }

    fn contains(&self, point: &Vector2<f64>) -> bool {
        let y = point - self.centre;
        y.dot(&(self.inverse * y)) < 1.0
    }

    /// Short chords of the outline, each with the middle of its arc.
    fn segments(&self) -> impl Iterator<Item = (Vector2<f64>, [Point2<f64>; 2])> + '_ {
        let count = (0.5 * TAU * self.root.norm()).clamp(48.0, 720.0) as usize;
        let at = move |k: f64| {
            let (sin, cos) = (TAU * k / count as f64).sin_cos();
            self.centre + self.root * Vector2::new(cos, sin)
        };
        (0..count).map(move |k| {
            let k = k as f64;
            (at(k + 0.5), [at(k).into(), at(k + 1.0).into()])
        })
    }
}

/// Where the recorded image has an undistorted pixel; `None` where the lens model has folded.
fn recorded(camera: &Camera, undistorted: &Point2<f64>) -> Option<Point2<f64>> {
    let pixel = camera.distort(undistorted);
    let back = camera.undistort(&pixel)?;
    ((back - undistorted).norm() < 1.0).then_some(pixel)
}

/// A bone in the recorded image, in pieces.
fn bone(camera: &Camera, from: &Point3<f64>, to: &Point3<f64>) -> Segments {
    let at = |k: usize| camera.project(&(from + (to - from) * (k as f64 / PIECES as f64)));
    (0..PIECES).filter_map(|k| Some([at(k)?, at(k + 1)?])).collect()
}

/// The bones of a model; of one that has other points, the lines of its lengths.
fn bones(model: &BodyModel) -> Vec<(usize, usize)> {
    let known = BONES.iter().filter_map(|(from, to)| Some((model.point(from)?, model.point(to)?)));
    let known: Vec<_> = known.collect();
    if !known.is_empty() {
        return known;
    }
    let lengths = model.lengths.iter();
    lengths.map(|(_, from, to)| (*from, *to)).collect()
}

/// The ends of the bones; all points of a model without bones.
fn used_points(model: &BodyModel) -> Vec<usize> {
    let bones = bones(model);
    let is_used = |i: &usize| bones.iter().any(|(a, b)| a == i || b == i) || bones.is_empty();
    (0..model.points.len()).filter(is_used).collect()
}

/// The colour of a side, lightened; white of neither.
fn colour(side: Option<Side>) -> Rgb {
    let lighter = |v: u8| (f64::from(v) + LIGHTER * (255.0 - f64::from(v))).round() as u8;
    side.map_or(MIDDLE, |side| side.colour().map(lighter))
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use nalgebra::DVector;

    use super::*;
    use crate::body::{Motion, Shape};
    use crate::camera::{Distortion, Intrinsics};
    use crate::math::Rigid3;

    /// Looks along the world's y axis at the arm from 4 m.
    fn camera() -> Camera {
        let turn = nalgebra::Vector3::x() * std::f64::consts::FRAC_PI_2;
        Camera {
            name: "front".into(),
            width_px: 200,
            height_px: 150,
            intrinsics: Intrinsics {
                fx_px: 200.0,
                fy_px: 200.0,
                cx_px: 50.0,
                cy_px: 75.0,
                skew_px: 0.0,
            },
            distortion: Distortion::None,
            camera_from_world: Rigid3::new(nalgebra::Vector3::new(0.0, 0.0, 4.0), turn),
        }
    }

    #[test]
    fn the_outline_bounds_the_whole_and_the_joint_is_where_the_camera_has_it() {
        let model = crate::io::model::load("arm-2d", Path::new("")).unwrap();
        let shape = Shape(DVector::zeros(1));
        let body = Posed::new(&model, &shape, &Motion::rest(&model));
        let camera = camera();
        let mask = Mask::from_fn(200, 150, |_, _| false);
        let canvas = overlay(&camera, &mask, &body);
        let at = |x: usize, y: usize| canvas.pixels().get(x, y).unwrap();
        let elbow = camera.project(&body.points()[0]).unwrap();
        assert_eq!(at(elbow.x.round() as usize, elbow.y.round() as usize), MIDDLE);
        let (outer, inner) = outlines_of_ellipsoids(&camera, &body);
        // the two ellipsoids touch in one point; seen in perspective their ends overlap by a hair
        assert!(inner.len() <= 4 && outer.len() >= 92);
        let [top, _] = outer[24];
        assert_ne!(at(top.x.round() as usize, top.y.round() as usize), BACKGROUND);
    }

    #[test]
    fn a_body_of_metaballs_has_the_outline_of_its_skin() {
        let model = crate::io::model::load("arm", Path::new("")).unwrap();
        let shape = Shape(model.statistics.mean.clone());
        let body = Posed::new(&model, &shape, &Motion::rest(&model));
        let camera = camera();
        let field = Field::from_body(&body);
        let outline = outline_of_skin(&camera, &body);
        assert!(outline.len() > 50, "{}", outline.len());
        for (k, [a, b]) in outline.iter().enumerate() {
            assert_eq!(*b, outline[(k + 1) % outline.len()][0]);
            // half a pixel, 1 cm, off the skin at most, seen along the line of sight
            let ray = camera.ray(a);
            let along = (0..400).map(|i| ray.point_at(3.0 + 0.005 * f64::from(i)).coords);
            let highest = along.map(|x| field.value(&x)).fold(0.0, f64::max);
            assert!((0.25..0.85).contains(&highest), "{a}: {highest}");
        }
    }

    #[test]
    fn a_right_knee_is_blue_and_a_left_one_red() {
        let model = crate::io::model::load("human-ellipsoids", Path::new("")).unwrap();
        let shape = Shape(model.statistics.mean.clone());
        let motion = Motion::rest(&model);
        let body = Posed::new(&model, &shape, &motion);
        let mut camera = camera();
        // in front of the body, which faces x
        let axes = nalgebra::Matrix3::new(0.0, 1.0, 0.0, 0.0, 0.0, -1.0, -1.0, 0.0, 0.0);
        let axes = nalgebra::Rotation3::from_matrix_unchecked(axes);
        let knees = ["LKnee", "RKnee"].map(|name| body.points()[model.point(name).unwrap()]);
        let middle = axes * nalgebra::center(&knees[0], &knees[1]).coords;
        let place = nalgebra::Vector3::new(0.0, 0.0, 3.0) - middle;
        camera.camera_from_world = Rigid3::from_parts(place.into(), axes.into());
        camera.intrinsics.cx_px = 100.0;
        let canvas = overlay(&camera, &Mask::from_fn(200, 150, |_, _| true), &body);

        let at = knees.map(|knee| camera.project(&knee).unwrap());
        let seen =
            at.map(|p| canvas.pixels().get(p.x.round() as usize, p.y.round() as usize).unwrap());
        let [[red, _, less_blue], [less_red, _, blue]] = seen;
        assert!(red > 2 * less_blue && blue > 2 * less_red, "{seen:?}");
    }
}
