//! What a person wears or carries, drawn into masks: balls that move with the joints.

use experiments::recorded::Recorded;
use maquette::camera::Camera;
use maquette::image::Mask;
use nalgebra::{Point2, Point3, Vector3};

/// Centre and radius, metres.
type Ball = (Point3<f64>, f64);
/// Where a joint is.
type Joints<'a> = &'a dyn Fn(&str) -> Option<Point3<f64>>;

/// How far cloth hangs beyond the axis of a thigh, and below the knee.
const CLOTH_M: f64 = 0.13;
const WIDER_M: f64 = 0.04;
const BELOW_KNEE: f64 = 0.4;
/// Half the length, the middle and the depth of a bag below the wrist that holds it.
const BAG_M: [f64; 3] = [0.15, 0.3, 0.09];
/// Balls from one side to the other, and down.
const ACROSS: usize = 7;
const DOWN: usize = 12;

/// A skirt to below the knees.
pub(crate) fn skirt(joint: Joints<'_>) -> Option<Vec<Ball>> {
    let leg = |side: &str| {
        let of = |name: &str| joint(&format!("{side}{name}"));
        Some([of("Hip")?, of("Knee")?, of("Ankle")?])
    };
    let (right, left) = (leg("R")?, leg("L")?);
    let balls = (0..DOWN).flat_map(|row| {
        let t = (1.0 + BELOW_KNEE) * row as f64 / (DOWN - 1) as f64;
        let along = |[hip, knee, ankle]: [Point3<f64>; 3]| match t <= 1.0 {
            true => hip + (knee - hip) * t,
            false => knee + (ankle - knee) * (t - 1.0),
        };
        let (from, to) = (along(right), along(left));
        between(from, to).map(move |place| (place, CLOTH_M + WIDER_M * t)).collect::<Vec<_>>()
    });
    Some(balls.collect())
}

/// A bag in the right hand.
pub(crate) fn bag(joint: Joints<'_>) -> Option<Vec<Ball>> {
    let [half, below, radius] = BAG_M;
    let across = joint("LHip")? - joint("RHip")?;
    let ahead = Vector3::z().cross(&across).try_normalize(0.0)? * half;
    let middle = joint("RWrist")? - Vector3::z() * below;
    Some(between(middle - ahead, middle + ahead).map(|place| (place, radius)).collect())
}

fn between(from: Point3<f64>, to: Point3<f64>) -> impl Iterator<Item = Point3<f64>> {
    (0..ACROSS).map(move |i| from + (to - from) * (i as f64 / (ACROSS - 1) as f64))
}

/// A recording with what a frame's joints carry in all masks.
pub(crate) fn carried(r: &Recorded, things: fn(Joints<'_>) -> Option<Vec<Ball>>) -> Recorded {
    let of_frame = |frame: usize| {
        let joints = r.truth.frames.get(r.numbers[frame].0)?;
        let place = |name: &str| joints[r.truth.names.iter().position(|n| n == name)?];
        things(&place)
    };
    let balls: Vec<Vec<Ball>> =
        (0..r.masks.len()).map(|frame| of_frame(frame).unwrap_or_default()).collect();
    r.with_masks(|frame, camera, mask| {
        let camera = &r.rig.cameras[camera];
        let disks: Vec<_> = balls[frame].iter().filter_map(|ball| shown(camera, ball)).collect();
        Some(Mask::from_fn(mask.width(), mask.height(), |x, y| {
            let pixel = Point2::new(x as f64, y as f64);
            let is_in = |(middle, radius_px): &(Point2<f64>, f64)| {
                nalgebra::distance(middle, &pixel) < *radius_px
            };
            mask.is_foreground(x, y) || disks.iter().any(is_in)
        }))
    })
}

/// The disk as which a camera shows a ball.
fn shown(camera: &Camera, (middle, radius_m): &Ball) -> Option<(Point2<f64>, f64)> {
    let depth_m = (camera.camera_from_world * middle).z;
    Some((camera.project(middle)?, radius_m * camera.intrinsics.focal_px() / depth_m))
}
