//! Parts of the masks that never move and that the body does not cover: pieces of the room.

use nalgebra::Point2;
use rayon::prelude::*;

use super::evenly;
use crate::body::Posed;
use crate::camera::{Camera, CameraId, Rig};
use crate::math::stats::median;
use crate::pipeline::overlap::{Covering, coverings};
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
    let sampled: Vec<usize> = evenly(frames.len(), SAMPLED_FRAMES).collect();
    let cameras: Vec<(CameraId, &Camera)> = rig.iter().collect();
    let share = |(id, camera): (CameraId, &Camera)| {
        let of_camera = |frame: &usize| {
            let (_, silhouette) = frames[*frame].views.iter().find(|(c, _)| *c == id)?;
            Some((silhouette, coverings(camera, &body(*frame))))
        };
        let views: Vec<(&Silhouette, Vec<Covering>)> =
            sampled.iter().filter_map(of_camera).collect();
        (id, still_share(camera, &views))
    };
    cameras.into_par_iter().map(share).collect()
}

fn still_share(camera: &Camera, views: &[(&Silhouette, Vec<Covering>)]) -> f64 {
    let Some(area_px) = median(&mut views.iter().map(|(s, _)| s.area_px).collect()) else {
        return 0.0;
    };
    let step = f64::from(camera.width_px) / ACROSS;
    let rows = (f64::from(camera.height_px) / step) as usize;

    let is_still = |cell: &usize| {
        let (x, y) = (cell % ACROSS as usize, cell / ACROSS as usize);
        let pixel = Point2::new((x as f64 + 0.5) * step, (y as f64 + 0.5) * step);
        let shown = views.iter().filter(|(s, _)| s.contains(&pixel)).count();
        let covered = || {
            views.iter().filter(|(_, body)| body.iter().any(|part| part.contains(&pixel))).count()
        };
        shown as f64 >= STILL * views.len() as f64 && 2 * covered() < views.len()
    };
    let still = (0..rows * ACROSS as usize).filter(is_still).count();
    still as f64 * step * step / area_px
}
