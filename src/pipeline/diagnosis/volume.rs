//! The room that the silhouettes leave: voxels that lie in all of them, body or not.

use nalgebra::{Point3, Vector3};

use super::reading::Reading;
use super::shown_by_two;
use crate::body::Posed;
use crate::camera::{Ray, Rig, closest_point};
use crate::math::stats::median;
use crate::silhouette::{FrameObservations, Silhouette};

/// Edge of a voxel, and half the edge of the cube that is looked at, metres.
const VOXEL_M: f64 = 0.08;
const REACH_M: f64 = 2.0;
/// Frames that are looked at.
const SAMPLED_FRAMES: usize = 6;
/// A voxel must lie in so many silhouettes, or in all where there are fewer: two leave room for much that is not there.
const LEAST_VIEWS: usize = 4;
/// What is farther from the body than this is not its cloth, m.
const CLOTH_M: f64 = 0.15;

/// The voxels of one frame.
#[derive(Debug, Clone)]
pub(super) struct Volume {
    /// Position of the frame among the observations.
    pub(super) frame: usize,
    places: Vec<Point3<f64>>,
}

/// The volumes of some frames, of the cameras that are not left out.
pub(super) fn volumes(
    rig: &Rig,
    frames: &[FrameObservations],
    readings: &[Option<Reading>],
) -> Vec<Volume> {
    let volume =
        |frame: usize| Volume { frame, places: carve(rig, &views(&frames[frame], readings)) };
    shown_by_two(frames, SAMPLED_FRAMES).into_iter().map(volume).collect()
}

/// The silhouettes of the cameras that are not left out.
fn views<'a>(
    frame: &'a FrameObservations,
    readings: &[Option<Reading>],
) -> Vec<(usize, &'a Silhouette)> {
    let kept = frame.views.iter().filter(|(id, _)| readings[id.0].is_some());
    kept.map(|(id, silhouette)| (id.0, silhouette)).collect()
}

/// How much of the room that the silhouettes leave they leave in every one of the frames, over their median volume.
///
/// Of a person who walks it is nothing; of one in a picture of the room that was taken with the person in it, half.
pub(super) fn still_share(
    rig: &Rig,
    frames: &[FrameObservations],
    readings: &[Option<Reading>],
    volumes: &[Volume],
) -> f64 {
    let Some((first, others)) = volumes.split_first() else {
        return 0.0;
    };
    let others: Vec<_> = others.iter().map(|v| views(&frames[v.frame], readings)).collect();
    let is_still = |place: &&Point3<f64>| others.iter().all(|views| is_in_all(rig, views, place));
    let still = first.places.iter().filter(is_still).count() as f64;
    let usual = median(&mut volumes.iter().map(|v| v.places.len() as f64).collect());
    still / usual.unwrap_or(0.0).max(1.0)
}

fn carve(rig: &Rig, views: &[(usize, &Silhouette)]) -> Vec<Point3<f64>> {
    let sights = views.iter().map(|(id, s)| rig.cameras[*id].ray(&s.centroid));
    let Some(middle) = closest_point(&sights.collect::<Vec<Ray>>()) else {
        return Vec::new();
    };

    let n = (2.0 * REACH_M / VOXEL_M) as usize;
    let along = |i: usize| (i as f64 + 0.5) * VOXEL_M - REACH_M;
    let place =
        |v: usize| middle + Vector3::new(along(v % n), along(v / n % n), along(v / (n * n)));
    (0..n * n * n).map(place).filter(|place| is_in_all(rig, views, place)).collect()
}

fn is_in_all(rig: &Rig, views: &[(usize, &Silhouette)], place: &Point3<f64>) -> bool {
    let mut seen = 0;
    for (id, silhouette) in views {
        let pixel = rig.cameras[*id].project_undistorted(place);
        let Some(pixel) = pixel.filter(|pixel| silhouette.sees(pixel)) else {
            continue;
        };
        if !silhouette.contains(&pixel) {
            return false;
        }
        seen += 1;
    }
    seen >= LEAST_VIEWS.min(views.len())
}

/// How large what is seen is along each axis of the world: the median over the frames of the voxels' extent; `None` without any.
pub(super) fn size_m(volumes: &[Volume]) -> Option<Vector3<f64>> {
    let extent = |volume: &Volume, axis: usize| {
        let along = || volume.places.iter().map(|p| p[axis]);
        let (low, high) = (along().reduce(f64::min)?, along().reduce(f64::max)?);
        Some(high - low + VOXEL_M)
    };
    let usual = |axis: usize| median(&mut volumes.iter().filter_map(|v| extent(v, axis)).collect());
    Some(Vector3::new(usual(0)?, usual(1)?, usual(2)?))
}

/// Litres that lie apart from the body, which stands in each volume's frame as `body` says: median over the frames.
pub(super) fn apart_l<'a>(volumes: &[Volume], body: impl Fn(usize) -> Posed<'a>) -> f64 {
    let apart = |volume: &Volume| {
        let ellipsoids = body(volume.frame).ellipsoids();
        let inverse =
            ellipsoids.iter().filter_map(|e| Some((e.centre, e.shape.cholesky()?.inverse())));
        let inverse: Vec<_> = inverse.collect();

        // along the line from the centre, the surface lies at 1/ρ of the way
        let is_apart = |place: &&Point3<f64>| {
            inverse.iter().all(|(centre, inverse)| {
                let offset = place.coords - centre;
                let rho = offset.dot(&(inverse * offset)).sqrt();
                offset.norm() * (1.0 - 1.0 / rho.max(f64::MIN_POSITIVE)) > CLOTH_M
            })
        };
        volume.places.iter().filter(is_apart).count() as f64
    };
    let voxels = median(&mut volumes.iter().map(apart).collect()).unwrap_or(0.0);
    1e3 * VOXEL_M.powi(3) * voxels
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::Mask;
    use crate::pipeline::diagnosis::coherence::Scene;
    use crate::pipeline::diagnosis::figures::{Figures, joined};

    #[test]
    fn a_second_person_is_litres_beside_the_first_and_one_alone_is_as_tall_as_he_is() {
        let figures = Figures::new();
        let (first, second) = (figures.standing(0.0, -0.5), figures.standing(0.0, 0.5));
        let found = |masks| {
            let frames = [figures.frame(0, masks)];
            let readings = Scene::new(&figures.rig, &frames).plain();
            let volumes = volumes(&figures.rig, &frames, &readings);
            let litres = apart_l(&volumes, |_| figures.posed(&first));
            (litres, size_m(&volumes).unwrap().z)
        };

        let alone = figures.masks(&first);
        let (litres, height_m) = found(&alone);
        assert!(litres < 1.0, "{litres}");
        assert!((1.5..1.9).contains(&height_m), "{height_m}");

        let (litres, _) = found(&joined(&alone, &figures.masks(&second)));
        assert!(litres > 40.0, "{litres}");
    }

    #[test]
    fn who_stands_in_every_frame_is_half_of_what_is_seen_and_who_walks_is_nothing() {
        let figures = Figures::new();
        let walks: Vec<Vec<Mask>> = (0..4)
            .map(|i| figures.masks(&figures.standing(0.6 * f64::from(i) - 0.9, 0.0)))
            .collect();
        let still = figures.masks(&figures.standing(0.0, 0.8));
        let share = |shown: &dyn Fn(&[Mask]) -> Vec<Mask>| {
            let frames: Vec<FrameObservations> =
                walks.iter().enumerate().map(|(i, m)| figures.frame(i, &shown(m))).collect();
            let readings = Scene::new(&figures.rig, &frames).plain();
            let volumes = volumes(&figures.rig, &frames, &readings);
            still_share(&figures.rig, &frames, &readings, &volumes)
        };

        let walker = share(&|masks| masks.to_vec());
        assert!(walker < 0.02, "{walker}");
        let beside = share(&|masks| joined(masks, &still));
        assert!((0.3..0.7).contains(&beside), "{beside}");
    }
}
