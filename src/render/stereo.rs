//! Pictures of disparities in colour, of a cloud from the side, and of the motion of the surface.

use nalgebra::{Point2, Point3, Unit, UnitQuaternion, Vector3};

use super::canvas::{Canvas, Pen, Rgb};
use crate::camera::Camera;
use crate::image::Plane;
use crate::math::Rigid3;
use crate::stereo::CloudPoint;
use crate::stereo::tracking::TrackPoint;

/// Turn of the side view about the vertical, rad.
const SIDE_TURN: f64 = 0.7;
/// Side of the squares that have one arrow each, px.
const ARROW_CELL_PX: f64 = 9.0;
/// Time whose motion an arrow shows, s.
const ARROW_S: f64 = 0.15;
/// Speed of the reddest arrow, m/s.
const FASTEST: f64 = 2.5;

/// Values in colour from blue (the least of the middle 98 %) over green to red; black where there are none.
pub fn in_colour(values: &Plane<f32>) -> Canvas {
    let (low, high) = middle_98_percent(values.values().to_vec());
    Canvas::from_pixels(
        values.map(|v| if v.is_finite() { rainbow((v - low) / (high - low)) } else { [0; 3] }),
    )
}

/// The least and the largest but for a hundredth at either end.
fn middle_98_percent(mut values: Vec<f32>) -> (f32, f32) {
    values.retain(|v| v.is_finite());
    values.sort_by(f32::total_cmp);
    let last = values.len().saturating_sub(1);
    let at = |share: f64| values.get((share * last as f64) as usize).copied().unwrap_or(0.0);
    (at(0.01), at(0.99).max(at(0.01) + 1e-3))
}

/// Blue at 0, red at 1.
fn rainbow(share: f32) -> Rgb {
    let share = share.clamp(0.0, 1.0);
    let ramp = |middle: f32| (1.5 - (4.0 * share - middle).abs()).clamp(0.0, 1.0);
    [3.0, 2.0, 1.0].map(|middle| (255.0 * ramp(middle)) as u8)
}

/// The points of a cloud as a camera to the side sees them, coloured by their depth for `camera`.
pub fn cloud_from_the_side(camera: &Camera, points: &[CloudPoint]) -> Canvas {
    let points = || points.iter().map(|point| point.position_world);
    let count = points().len().max(1) as f64;
    let middle: Vector3<f64> = points().map(|p| p.coords / count).sum();
    let side = turned_about(camera, &middle.into());
    let depths = points().map(|p| (camera.camera_from_world * p).z as f32);
    let (low, high) = middle_98_percent(depths.collect());

    // far ones first, near ones over them
    let order = points().map(|p| ((side.camera_from_world * p).z, p));
    let mut order: Vec<(f64, Point3<f64>)> = order.collect();
    order.sort_by(|a, b| b.0.total_cmp(&a.0));

    let (width, height) = (camera.width_px as usize, camera.height_px as usize);
    let mut pixels = Plane::filled(width, height, [24u8; 3]);
    for (_, point) in order {
        let Some(pixel) = side.project_undistorted(&point) else {
            continue;
        };

        let share = ((camera.camera_from_world * point).z as f32 - low) / (high - low);
        let (x, y) = (pixel.x.round(), pixel.y.round());
        let inside = x >= 0.0 && y >= 0.0;
        let row = pixels.row_mut(y as usize);
        if let Some(pixel) = row.get_mut(x as usize).filter(|_| inside) {
            *pixel = rainbow(1.0 - share);
        }
    }
    Canvas::from_pixels(pixels)
}

/// The camera moved around a point, about its own vertical.
fn turned_about(camera: &Camera, point: &Point3<f64>) -> Camera {
    let down = camera.camera_from_world.rotation.inverse() * Vector3::y();
    let turn = UnitQuaternion::from_axis_angle(&Unit::new_normalize(down), SIDE_TURN);
    let about = Rigid3::from_parts((point.coords - turn * point.coords).into(), turn);
    Camera { camera_from_world: camera.camera_from_world * about, ..camera.clone() }
}

/// The motion of points as arrows over an image, from yellow (at rest) to red (PFD99 Fig. 5).
pub fn vector_field(camera: &Camera, image: &Plane<f32>, points: &[TrackPoint]) -> Canvas {
    // arrows of four classes of speed, one in each cell
    let mut by_speed = [const { Vec::new() }; 4];
    let mut taken = std::collections::BTreeSet::new();
    for point in points {
        let to = point.position_world + point.velocity * ARROW_S;
        let ends = [point.position_world, to].map(|p| camera.project_undistorted(&p));
        let [Some(from), Some(to)] = ends else {
            continue;
        };

        let cell = [from.x, from.y].map(|x| (x / ARROW_CELL_PX).floor() as i64);
        if !taken.insert(cell) {
            continue;
        }

        let class = (3.99 * (point.velocity.norm() / FASTEST).clamp(0.0, 1.0)) as usize;
        by_speed[class].extend(arrow(from, to));
    }

    let grey = image.map(|v| [(0.6 * v) as u8; 3]);
    let mut canvas = Canvas::from_pixels(grey);
    for (class, segments) in by_speed.iter().enumerate() {
        let pen = Pen { color: [255, 240 - 78 * class as u8, 30], opacity: 0.9, width_px: 1.0 };
        canvas.draw(segments, pen);
    }
    canvas
}

fn arrow(from: Point2<f64>, to: Point2<f64>) -> [[Point2<f64>; 2]; 3] {
    let back = (from - to) * 0.3;
    let side = nalgebra::Vector2::new(-back.y, back.x) * 0.6;
    [[from, to], [to, to + back + side], [to, to + back - side]]
}
