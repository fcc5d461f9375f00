//! Parts of the masks that never move and that the body does not cover: pieces of the room.

use nalgebra::Point2;
use rayon::prelude::*;

use super::coherence::Scene;
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
/// What stands still is a picture of somebody if the smallest silhouette holds less than this share of what the usual one holds besides, …
const MOST_UNCOVERED: f64 = 0.33;
/// … and if it is most of a person, whom the rest overlaps, but not all: of somebody who stands still it is a larger share.
const MOST_OF_A_PERSON: std::ops::Range<f64> = 0.6..0.9;

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
            let silhouette = shown(&frames[*frame], id)?;
            Some((silhouette, coverings(camera, &body(*frame))))
        };
        let views: Vec<(&Silhouette, Vec<Covering>)> =
            sampled.iter().filter_map(of_camera).collect();
        (id, still_share(camera, &views))
    };
    cameras.into_par_iter().map(share).collect()
}

/// For each camera the area that stands still and shows what the other cameras do not see, over the median area of its silhouettes: a
/// piece of the room, whatever the body is.
pub(super) fn alone_shares(rig: &Rig, frames: &[FrameObservations]) -> Vec<(CameraId, f64)> {
    let sampled: Vec<usize> = evenly(frames.len(), SAMPLED_FRAMES).collect();
    let scene = Scene::new(rig, frames);
    let cameras: Vec<(CameraId, &Camera)> = rig.iter().collect();
    let share = |(id, camera): (CameraId, &Camera)| {
        let of_frame = |frame: &usize| shown(&frames[*frame], id);
        let views: Vec<&Silhouette> = sampled.iter().filter_map(of_frame).collect();
        let middle = sampled.iter().filter(|frame| of_frame(frame).is_some());
        let middle = middle.copied().nth(views.len() / 2).unwrap_or(0);
        let still = Cells::of(camera).middles().filter(|pixel| is_still(pixel, &views));
        let still: Vec<Point2<f64>> = still.collect();
        let area_px =
            median(&mut views.iter().map(|s| s.area_px).collect()).unwrap_or(f64::INFINITY);
        let alone = scene.alone(middle, id, &still).len() as f64;
        (id, Cells::of(camera).area_px(alone) / area_px)
    };
    cameras.into_par_iter().map(share).collect()
}

/// For each camera what stands still in the silhouettes, whatever the body is, over the median area of these, where the smallest of them
/// holds hardly more: a picture of the person is in every mask. Somebody who moves on the spot covers about as much in every frame.
pub(super) fn stale_shares(rig: &Rig, frames: &[FrameObservations]) -> Vec<(CameraId, f64)> {
    let sampled: Vec<usize> = evenly(frames.len(), SAMPLED_FRAMES).collect();
    let share = |(id, camera): (CameraId, &Camera)| {
        let of_frame = |frame: &usize| shown(&frames[*frame], id);
        let views: Vec<&Silhouette> = sampled.iter().filter_map(of_frame).collect();
        let count = |s: &&Silhouette| {
            Cells::of(camera).middles().filter(|pixel| s.contains(pixel)).count() as f64
        };
        let mut areas: Vec<f64> = views.iter().map(count).collect();
        let still =
            Cells::of(camera).middles().filter(|pixel| is_still(pixel, &views)).count() as f64;
        let least = areas.iter().copied().fold(f64::INFINITY, f64::min);
        let usual = median(&mut areas)?;
        let (uncovered, share) = (least - still, still / usual);
        let is_stale = uncovered < MOST_UNCOVERED * (usual - still);
        (is_stale && MOST_OF_A_PERSON.contains(&share)).then_some((id, share))
    };
    let cameras: Vec<(CameraId, &Camera)> = rig.iter().collect();
    cameras.into_par_iter().filter_map(share).collect()
}

/// What a camera shows in a frame.
pub(super) fn shown(frame: &FrameObservations, camera: CameraId) -> Option<&Silhouette> {
    frame.views.iter().find(|(id, _)| *id == camera).map(|(_, silhouette)| silhouette)
}

/// Whether a pixel is foreground in nearly all silhouettes.
fn is_still(pixel: &Point2<f64>, views: &[&Silhouette]) -> bool {
    let shown = views.iter().filter(|s| s.contains(pixel)).count();
    in_nearly_all(shown, views.len())
}

/// The cells of a camera's picture that are looked at: squares, row by row.
#[derive(Debug, Clone, Copy)]
pub(super) struct Cells {
    pub(super) columns: usize,
    pub(super) rows: usize,
    pub(super) step_px: f64,
}

impl Cells {
    pub(super) fn of(camera: &Camera) -> Self {
        let step_px = f64::from(camera.width_px) / ACROSS;
        let rows = (f64::from(camera.height_px) / step_px) as usize;
        Self { columns: ACROSS as usize, rows, step_px }
    }

    /// The middle of one of them.
    pub(super) fn middle(self, x: usize, y: usize) -> Point2<f64> {
        Point2::new((x as f64 + 0.5) * self.step_px, (y as f64 + 0.5) * self.step_px)
    }

    /// The middles of all.
    fn middles(self) -> impl Iterator<Item = Point2<f64>> {
        let cells = 0..self.rows * self.columns;
        cells.map(move |cell| self.middle(cell % self.columns, cell / self.columns))
    }

    /// The area of so many, px².
    fn area_px(self, count: f64) -> f64 {
        count * self.step_px.powi(2)
    }
}

/// Whether what is foreground in so many of the frames is so in nearly all.
pub(super) fn in_nearly_all(shown: usize, frames: usize) -> bool {
    shown as f64 >= STILL * frames as f64
}

fn still_share(camera: &Camera, views: &[(&Silhouette, Vec<Covering>)]) -> f64 {
    let Some(area_px) = median(&mut views.iter().map(|(s, _)| s.area_px).collect()) else {
        return 0.0;
    };
    let is_still = |pixel: &Point2<f64>| {
        let shown = views.iter().filter(|(s, _)| s.contains(pixel)).count();
        let covered = || {
            views.iter().filter(|(_, body)| body.iter().any(|part| part.contains(pixel))).count()
        };
        in_nearly_all(shown, views.len()) && 2 * covered() < views.len()
    };
    let still = Cells::of(camera).middles().filter(is_still).count();
    Cells::of(camera).area_px(still as f64) / area_px
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::Motion;
    use crate::image::Mask;
    use crate::pipeline::diagnosis::figures::{Figures, joined};

    /// The greatest and the least share over the cameras, of a person who stands where `motions` say, frame by frame.
    fn shares(figures: &Figures, motions: &[Motion], shown: &[Vec<Mask>]) -> (f64, f64) {
        let frames = shown.iter().enumerate().map(|(i, masks)| figures.frame(i, masks));
        let frames: Vec<FrameObservations> = frames.collect();
        let found = still_shares(&figures.rig, &frames, |frame| figures.posed(&motions[frame]));
        let all = || found.iter().map(|(_, share)| *share);
        (all().fold(0.0, f64::max), all().fold(f64::INFINITY, f64::min))
    }

    #[test]
    fn what_never_moves_and_is_not_the_body_is_found_in_each_camera() {
        let figures = Figures::new();
        let motions: Vec<Motion> =
            (0..5).map(|i| figures.standing(0.5 * f64::from(i) - 1.0, 0.0)).collect();
        let alone: Vec<Vec<Mask>> = motions.iter().map(|m| figures.masks(m)).collect();
        let (most, _) = shares(&figures, &motions, &alone);
        assert!(most < 0.01, "a person who walks: {most}");

        // a picture of the room with the person in it
        let stale: Vec<Vec<Mask>> = alone.iter().map(|masks| joined(masks, &alone[0])).collect();
        let (_, least) = shares(&figures, &motions, &stale);
        assert!(least > 0.25, "{least}");
    }

    #[test]
    fn a_picture_of_somebody_in_every_mask_is_found_though_they_move_on_the_spot() {
        let figures = Figures::new();
        let joint = |name: &str| figures.model.joint(name).unwrap().0;
        let joints = ["hip_flexion_r", "knee_flexion_r", "shoulder_flexion_l"].map(joint);
        let motions = (0..6).map(|i| {
            let mut motion = figures.standing(0.0, 0.0);
            joints.iter().for_each(|joint| motion.angles[*joint] = 0.3 * f64::from(i));
            motion
        });
        let shown: Vec<Vec<Mask>> = motions.map(|motion| figures.masks(&motion)).collect();
        let found = |shown: &[Vec<Mask>]| {
            let frames: Vec<_> = (0..6).map(|i| figures.frame(i, &shown[i])).collect();
            stale_shares(&figures.rig, &frames).len()
        };
        let cameras = figures.rig.cameras.len();
        assert!(2 * found(&shown) < cameras, "somebody who lifts a leg and an arm");
        assert_eq!(found(&vec![shown[0].clone(); 6]), 0, "somebody who stands");
        let stale: Vec<_> = shown.iter().map(|masks| joined(masks, &shown[0])).collect();
        assert!(2 * found(&stale) >= cameras, "{}", found(&stale));
    }

    #[test]
    fn what_stands_still_and_no_other_camera_sees_is_found_beside_one_who_stands_still_too() {
        let figures = Figures::new();
        let masks = figures.masks(&figures.standing(0.0, 0.0));
        let chair = |(camera, mask): (usize, &Mask)| {
            let (w, h) = (mask.width(), mask.height());
            let x = if camera % 2 == 0 { 0 } else { w * 3 / 4 };
            let is_chair = |px: usize, py: usize| (x..x + w / 4).contains(&px) && py > h / 2;
            Mask::from_fn(w, h, |px, py| mask.is_foreground(px, py) || is_chair(px, py))
        };
        let shares = |masks: &[Mask]| {
            let frames: Vec<_> = (0..3).map(|i| figures.frame(i, masks)).collect();
            let found = alone_shares(&figures.rig, &frames);
            let all = || found.iter().map(|(_, share)| *share);
            (all().fold(0.0, f64::max), all().fold(f64::INFINITY, f64::min))
        };
        let (most, _) = shares(&masks);
        assert!(most < 0.02, "a person alone: {most}");
        let (_, least) = shares(&masks.iter().enumerate().map(chair).collect::<Vec<_>>());
        assert!(least > 0.25, "{least}");
    }

    #[test]
    fn a_person_who_stands_still_is_no_part_of_the_room() {
        let figures = Figures::new();
        let motions = vec![figures.standing(0.0, 0.0); 4];
        let shown = vec![figures.masks(&motions[0]); 4];
        let (most, _) = shares(&figures, &motions, &shown);
        assert!(most < 0.1, "{most}");
    }
}
