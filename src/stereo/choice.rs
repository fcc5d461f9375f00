//! Which cameras stand side by side.

use crate::camera::{Camera, CameraId, Rig};

/// Images are matched between cameras whose axes differ by this at most, degrees: beyond, patches look too different.
const MOST_ANGLE_DEG: f64 = 25.0;
/// Most images beside the template.
const MOST_OTHERS: usize = 2;
/// Cameras nearer to each other than this stand in one place, m.
const LEAST_DISTANCE: f64 = 1e-6;

/// The cameras whose images are matched: one in the middle, and its neighbours.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SideBySide {
    /// The camera whose image is the template.
    pub template: CameraId,
    /// The cameras beside it, nearest first; at least one.
    pub others: Vec<CameraId>,
}

/// No two cameras stand side by side.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error(
    "no two of the {cameras} cameras stand side by side: expected two in different places whose axes differ by at most 25°"
)]
pub struct NoneSideBySide {
    cameras: usize,
}

impl SideBySide {
    /// The camera with the most neighbours (two at most), among equals the one nearest to them.
    ///
    /// # Errors
    /// [`NoneSideBySide`] if no two cameras stand side by side.
    pub fn choose(rig: &Rig) -> Result<Self, NoneSideBySide> {
        let rated = rig.iter().filter_map(|(template, camera)| {
            let others = rig.iter().filter(|(id, _)| *id != template);
            let near = others.filter_map(|(id, other)| Some((distance(camera, other)?, id)));
            let mut near: Vec<(f64, CameraId)> = near.collect();
            near.sort_by(|a, b| a.0.total_cmp(&b.0));
            near.truncate(MOST_OTHERS);

            let far: f64 = near.iter().map(|(distance, _)| distance).sum();
            let others: Vec<CameraId> = near.into_iter().map(|(_, id)| id).collect();
            (!others.is_empty()).then_some((others.len(), far, Self { template, others }))
        });
        let best = rated.min_by(|a, b| b.0.cmp(&a.0).then(a.1.total_cmp(&b.1)));
        let cameras = rig.cameras.len();
        best.map(|best| best.2).ok_or(NoneSideBySide { cameras })
    }
}

/// The nearest of the cameras that stand beside another; `None` if none does.
pub fn neighbour(rig: &Rig, camera: CameraId) -> Option<CameraId> {
    let here = rig.camera(camera)?;
    let others = rig.iter().filter(|(id, _)| *id != camera);
    let near = others.filter_map(|(id, other)| Some((distance(here, other)?, id)));
    near.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, id)| id)
}

/// Distance between two cameras, m; `None` if they do not stand side by side.
fn distance(a: &Camera, b: &Camera) -> Option<f64> {
    let distance = (a.centre_world() - b.centre_world()).norm();
    let axes = [a, b].map(|camera| camera.optical_axis().direction_world);
    let angle = axes[0].angle(&axes[1]).to_degrees();
    (angle <= MOST_ANGLE_DEG && distance > LEAST_DISTANCE).then_some(distance)
}
