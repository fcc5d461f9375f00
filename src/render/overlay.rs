//! A mask with the fitted body over it, to see at a glance whether the fit is right.

use std::f64::consts::TAU;

use nalgebra::{Matrix2, Point2, Point3, Vector2};

use super::{Canvas, Pen, Rgb};
use crate::body::metaball::Field;
use crate::body::{BodyModel, Posed};
use crate::camera::Camera;
use crate::image::{Mask, Runs, trace};
use crate::math::quadric::{Ellipse, project};

const BACKGROUND: Rgb = [26, 28, 33];
const PERSON: Rgb = [124, 128, 135];
const OUTLINE: Rgb = [255, 190, 40];
const SHADE: Rgb = [12, 13, 16];
/// Right, left and middle: told apart by every kind of colour vision (IBM's palette).
const SIDES: [Rgb; 3] = [[240, 60, 140], [110, 165, 255], [245, 245, 245]];

/// Width of an image for which the lines' widths are meant, px.
const USUAL_PX: f64 = 800.0;
/// Pieces in which a bone is drawn, for the bend that the lens gives it.
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
/// The outline is that of the skin of a body of metaballs; of one of ellipsoids it is that of their ellipses, with
/// thinly those within. Everything stands where the recorded, distorted image has it. Right limbs are red, left ones blue.
pub fn overlay(camera: &Camera, mask: &Mask, body: &Posed<'_>) -> Canvas {
    let mut canvas = Canvas::from_mask(mask, BACKGROUND, PERSON);
    let unit = (f64::from(camera.width_px.max(camera.height_px)) / USUAL_PX).max(0.4);
    let pen = |color, opacity, width| Pen {
        color,
        opacity,
        width_px: width * unit,
    };
    // the body's outline, and fainter its parts'
    let (outer, inner) = if body.model.metaballs.is_empty() {
        outlines(camera, body)
    } else {
        (outline_of_skin(camera, body), Vec::new())
    };
    canvas.draw(&inner, pen(OUTLINE, 0.45, 0.8));
    canvas.draw(&outer, pen(SHADE, 0.45, 3.0));
    canvas.draw(&outer, pen(OUTLINE, 1.0, 1.4));
    // the bones, side by side in their colours
    let points = body.points();
    let (bones, joints) = (bones(body.model), used_points(body.model));
    let drawn: Vec<(usize, Segments)> = bones
        .iter()
        .map(|(from, to)| {
            let side = side_of(&body.model.points[*to].name);
            (side, bone(camera, &points[*from], &points[*to]))
        })
        .collect();
    let all: Segments = drawn.iter().flat_map(|(_, s)| s.clone()).collect();
    canvas.draw(&all, pen(SHADE, 0.6, 4.0));
    for (side, color) in SIDES.into_iter().enumerate() {
        let of_side = drawn.iter().filter(|(s, _)| *s == side);
        let segments: Segments = of_side.flat_map(|(_, s)| s.clone()).collect();
        canvas.draw(&segments, pen(color, 1.0, 2.0));
        let dots = joints
            .iter()
            .filter(|i| side_of(&body.model.points[**i].name) == side);
        let dots: Segments = dots
            .filter_map(|i| camera.project(&points[*i]))
            .map(|p| [p, p])
            .collect();
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

/// What of the parts' outlines bounds the whole body, and what lies within it.
fn outlines(camera: &Camera, body: &Posed<'_>) -> (Segments, Segments) {
    let projection = camera.projection();
    let ellipses: Vec<Outlined> = body
        .ellipsoids()
        .iter()
        .filter_map(|e| Outlined::new(&project(&projection, e)?))
        .collect();
    let (mut outer, mut inner) = (Vec::new(), Vec::new());
    for (i, ellipse) in ellipses.iter().enumerate() {
        for (middle, segment) in ellipse.segments() {
            let mut others = ellipses.iter().enumerate().filter(|(j, _)| *j != i);
            let is_within = others.any(|(_, other)| other.contains(&middle));
            let [a, b] = segment.map(|p| recorded(camera, &p));
            if let (Some(a), Some(b)) = (a, b) {
                if is_within { &mut inner } else { &mut outer }.push([a, b]);
            }
        }
    }
    (outer, inner)
}

/// An ellipse to be sampled and asked what it contains.
struct Outlined {
    centre: Vector2<f64>,
    /// L with Σ = L·Lᵀ.
    root: Matrix2<f64>,
    inverse: Matrix2<f64>,
}

impl Outlined {
    fn new(ellipse: &Ellipse) -> Option<Self> {
        let cholesky = ellipse.shape.cholesky()?;
        Some(Self {
            centre: ellipse.centre,
            root: cholesky.l(),
            inverse: cholesky.inverse(),
        })
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

fn bone(camera: &Camera, from: &Point3<f64>, to: &Point3<f64>) -> Segments {
    let at = |k: usize| camera.project(&(from + (to - from) * (k as f64 / PIECES as f64)));
    (0..PIECES)
        .filter_map(|k| Some([at(k)?, at(k + 1)?]))
        .collect()
}

/// The bones of a model; of one that has other points, the lines of its lengths.
fn bones(model: &BodyModel) -> Vec<(usize, usize)> {
    let known = BONES
        .iter()
        .filter_map(|(from, to)| Some((model.point(from)?, model.point(to)?)));
    let known: Vec<_> = known.collect();
    if known.is_empty() {
        model
            .lengths
            .iter()
            .map(|(_, from, to)| (*from, *to))
            .collect()
    } else {
        known
    }
}

/// The ends of the bones; all points of a model without bones.
fn used_points(model: &BodyModel) -> Vec<usize> {
    let bones = bones(model);
    let is_used = |i: &usize| bones.iter().any(|(a, b)| a == i || b == i) || bones.is_empty();
    (0..model.points.len()).filter(is_used).collect()
}

/// Index into [`SIDES`] by the first letter of a joint centre's name, as in `RKnee`.
fn side_of(name: &str) -> usize {
    let mut letters = name.chars();
    let (first, second) = (letters.next(), letters.next());
    match (first, second.is_some_and(char::is_uppercase)) {
        (Some('R'), true) => 0,
        (Some('L'), true) => 1,
        _ => 2,
    }
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
        assert_eq!(
            at(elbow.x.round() as usize, elbow.y.round() as usize),
            SIDES[2]
        );
        let (outer, inner) = outlines(&camera, &body);
        // the two ellipsoids touch in one point; seen in perspective their ends overlap by a hair
        assert!(inner.len() <= 4 && outer.len() >= 92);
        let [top, _] = outer[24];
        assert_ne!(
            at(top.x.round() as usize, top.y.round() as usize),
            BACKGROUND
        );
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
    fn the_side_is_read_from_the_name() {
        assert_eq!(["RKnee", "LHip", "Hip", "Rib"].map(side_of), [0, 1, 2, 2]);
    }
}
