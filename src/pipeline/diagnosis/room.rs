//! Parts of the masks that never move and that the body does not cover: pieces of the room.

use nalgebra::{Matrix2, Point2, Vector2};
use rayon::prelude::*;

use crate::body::Posed;
use crate::camera::{Camera, CameraId, Rig};
use crate::math::quadric::project;
use crate::math::stats::median;
use crate::silhouette::{FrameObservations, Silhouette};

/// Frames that are looked at.
const SAMPLED_FRAMES: usize = 24;
/// Pixels across a picture that are looked at.
const ACROSS: f64 = 120.0;
/// What is foreground in this share of the frames stands still, and is not the body if that covers it in less than half of them.
const STILL: f64 = 0.9;

/// For each camera the area that stands still and is not the body, over the median area of its silhouettes.
pub(super) fn still_shares<'a>(
    rig: &Rig,
    frames: &[FrameObservations],
    body: impl Fn(usize) -> Posed<'a> + Sync,
) -> Vec<(CameraId, f64)> {
    let count = frames.len().min(SAMPLED_FRAMES);
    let sampled: Vec<usize> =
        (0..count).map(|i| (2 * i + 1) * frames.len() / (2 * count)).collect();

    let cameras: Vec<(CameraId, &Camera)> = rig.iter().collect();
    let share = |(id, camera): (CameraId, &Camera)| {
        let of_camera = |frame: &usize| {
            let (_, silhouette) = frames[*frame].views.iter().find(|(c, _)| *c == id)?;
            Some((silhouette, outlines(camera, &body(*frame))))
        };
        let views: Vec<(&Silhouette, Vec<Outline>)> =
            sampled.iter().filter_map(of_camera).collect();
        (id, still_share(camera, &views))
    };
    cameras.into_par_iter().map(share).collect()
}

/// An ellipse: its centre and Σ⁻¹.
type Outline = (Vector2<f64>, Matrix2<f64>);

fn outlines(camera: &Camera, body: &Posed<'_>) -> Vec<Outline> {
    let projection = camera.projection();
    let ellipses = body.ellipsoids().into_iter().filter_map(|e| project(&projection, &e));
    ellipses.filter_map(|e| Some((e.centre, e.shape.cholesky()?.inverse()))).collect()
}

fn still_share(camera: &Camera, views: &[(&Silhouette, Vec<Outline>)]) -> f64 {
    let Some(area_px) = median(&mut views.iter().map(|(s, _)| s.area_px).collect()) else {
        return 0.0;
    };
    let step = f64::from(camera.width_px) / ACROSS;
    let rows = (f64::from(camera.height_px) / step) as usize;

    let is_still = |cell: &usize| {
        let (x, y) = (cell % ACROSS as usize, cell / ACROSS as usize);
        let pixel = Point2::new((x as f64 + 0.5) * step, (y as f64 + 0.5) * step);
        let shown = views.iter().filter(|(s, _)| s.contains(&pixel)).count();
        let covers = |(centre, inverse): &Outline| {
            let offset = pixel.coords - centre;
            offset.dot(&(inverse * offset)) < 1.0
        };
        let covered = || views.iter().filter(|(_, body)| body.iter().any(covers)).count();
        shown as f64 >= STILL * views.len() as f64 && 2 * covered() < views.len()
    };
    let still = (0..rows * ACROSS as usize).filter(is_still).count();
    still as f64 * step * step / area_px
}
