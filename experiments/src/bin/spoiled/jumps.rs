//! Cameras that are late, or touched, from some frame on.

use experiments::recorded::Recorded;
use maquette::camera::Camera;
use maquette::image::Mask;
use maquette::math::Rigid3;
use nalgebra::{Point2, Vector3};

/// From a frame on, a camera's files hold what it saw so many frames before; negative: later, for frames are lost there.
pub(crate) fn late_from(r: &Recorded, camera: usize, frames: isize, from: usize) -> Recorded {
    let mut spoiled = r.clone();
    for (i, masks) in spoiled.masks.iter_mut().enumerate().skip(from) {
        let shown = i.checked_add_signed(-frames).and_then(|i| r.masks.get(i));
        masks[camera] = shown.and_then(|masks| masks[camera].clone());
    }
    spoiled
}

/// From the middle on, a camera is turned about its centre, by an axis times an angle in its own frame.
pub(crate) fn touched_while(r: &Recorded, camera: usize, turn: Vector3<f64>) -> Recorded {
    let calibrated = &r.rig.cameras[camera];
    let camera_from_world = Rigid3::rotation(turn) * calibrated.camera_from_world;
    let turned = Camera { camera_from_world, ..calibrated.clone() };
    let middle = r.masks.len() / 2;
    r.with_masks(move |f, c, m| {
        let is_turned = f >= middle && c == camera;
        Some(if is_turned { seen_by(&turned, calibrated, m) } else { m.clone() })
    })
}

/// What a camera shows of a mask of another one with the same centre.
fn seen_by(turned: &Camera, other: &Camera, mask: &Mask) -> Mask {
    let centre = turned.centre_world();
    Mask::from_fn(mask.width(), mask.height(), |x, y| {
        let pixel = turned.undistort(&Point2::new(x as f64, y as f64));
        let sight = pixel.map(|pixel| centre + *turned.ray(&pixel).direction_world);
        let there = sight.and_then(|sight| other.project(&sight));
        there.is_some_and(|there| {
            let [x, y] = [there.x, there.y].map(|at| at.round() as usize);
            other.contains(&there) && mask.is_foreground(x, y)
        })
    })
}
