//! A walking person who is exactly the model: masks of the model's own ellipsoids, before a ring of cameras.

use std::path::Path;

use maquette::body::{BodyModel, Motion, Posed, Shape};
use maquette::camera::{Camera, Rig};
use maquette::image::Mask;
use maquette::io::model;
use maquette::math::quadric::project;
use maquette::silhouette::{FrameIndex, FrameObservations, SilhouetteOptions, extract};
use maquette::synth::{Ground, Ring, Walk, WalkingStyle};
use nalgebra::Vector2;

/// The shipped human.
pub(crate) fn human() -> BodyModel {
    model::load("human-ellipsoids", Path::new("")).expect("the shipped model is right")
}

/// Evenly spaced cameras of 480 × 360.
pub(crate) fn rig(cameras: usize) -> Rig {
    let ring = Ring { cameras, focal_px: 490.0, width_px: 480, height_px: 360, ..Ring::default() };
    ring.regular()
}

/// A normative walk that heads a little left of x.
pub(crate) fn walk(model: &BodyModel, shape: &Shape, fps: f64, frames: usize) -> Vec<Motion> {
    let walk = Walk {
        style: WalkingStyle::normative(),
        heading: 0.2,
        middle_world: Vector2::new(0.05, -0.1),
        start_phase: 0.1,
        ground: Ground::Floor,
    };
    walk.motions(model, shape, fps, frames).expect("the human has feet")
}

/// What every camera sees of a body.
pub(crate) fn observe(body: &Posed<'_>, rig: &Rig, frame: usize) -> FrameObservations {
    let silhouette = |camera: &Camera| {
        extract(&mask(camera, body), camera, &SilhouetteOptions::default())
            .expect("the person is in the image")
    };
    FrameObservations {
        views: rig.iter().map(|(id, c)| (id, silhouette(c))).collect(),
        ..FrameObservations::nothing(FrameIndex(frame))
    }
}

/// The pixels whose centre lies in the outline of any ellipsoid.
fn mask(camera: &Camera, body: &Posed<'_>) -> Mask {
    let projection = camera.projection();
    let ellipses: Vec<_> = body
        .ellipsoids()
        .iter()
        .filter_map(|e| project(&projection, e))
        .filter_map(|e| Some((e.centre, e.shape, e.shape.cholesky()?.inverse())))
        .collect();
    Mask::from_fn(camera.width_px as usize, camera.height_px as usize, |x, y| {
        let pixel = Vector2::new(x as f64, y as f64);
        ellipses.iter().any(|(centre, shape, inverse)| {
            let d = pixel - centre;
            d.x * d.x <= shape[(0, 0)] && d.dot(&(inverse * d)) <= 1.0
        })
    })
}
