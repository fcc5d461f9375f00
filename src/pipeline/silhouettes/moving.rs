//! What moves, and so can be the person, before there is a model: points of its surface, and its silhouettes.
//!
//! Points say where the person is. A silhouette also says where nobody is: a fit to points alone loses limbs into empty space.
//! Both come from disparities. A pixel moves where it is nearer than its still scene. Where the person stood in one place all
//! the time, the still scene is the person, and what moves has a hole. The border of that hole is none of the person's, so a
//! border is believed only where depth ends with it:
//!
//! r = \[n(x + kν) − n(x − lν) > T, k, l ≤ w\],
//!
//! with nearness n, the normal ν towards the person, the width w that correlation blurs, and the same threshold T that
//! separates what moves from what stands still. Where no depth is known, n is that of the still scene.

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::{Point2, Vector2};

use super::ends::nearness;
use super::still::{NEARER_PX, StillScene, StillScenes, points_where};
use super::undistorted::UndistortedFrame;
use crate::camera::{Camera, InfiniteHomography, Rig};
use crate::image::{CleanOptions, Mask, Plane, Runs, clean, closed, opened, resample, trace};
use crate::silhouette::{
    BorderPoint, FrameIndex, FrameObservations, Silhouette, SilhouetteOptions, from_curves,
};
use crate::stereo::{CloudPoint, DepthMap, RectifiedPair};

/// Radius of the disk that closes and opens what moves, px: the correlation window's.
pub(super) const CLEAN_PX: u8 = 3;
/// Distance of neighbouring points of a border, px.
const SPACING_PX: f64 = 1.5;
/// Depth ends within so many pixels of a border, on either side: the window's reach, and the disk's.
const BLUR_PX: i32 = 6;
/// Edge of the cells by which points hang together, m.
const CELL_M: f64 = 0.1;
/// At most so many points of one frame are fitted to.
pub(super) const MOST_POINTS: usize = 1500;
/// A cell of fewer points is stray.
const LEAST_IN_CELL: usize = 3;

impl StillScenes {
    /// The points and silhouettes of a frame that are in front of the still scenes of the same cameras.
    pub fn moving(
        &self,
        frame: FrameIndex,
        rig: &Rig,
        shown: &UndistortedFrame,
    ) -> FrameObservations {
        let mut observed = FrameObservations::nothing(frame);
        let mut points = Vec::new();
        for (camera, map) in shown.depths(rig) {
            let Some(still) = self.get(camera) else {
                continue;
            };
            let moves = still.nearer(&nearness(&map));
            points.extend(points_where(&map, &moves));
            let silhouette = silhouette(still, &map, &moves, &rig.cameras[camera.0]);
            observed.views.extend(silhouette.map(|s| (camera, s)));
        }

        observed.points = thinned(largest_piece(points), MOST_POINTS);
        observed
    }
}

/// The silhouette of what moves, in undistorted pixels of its camera; `None` where nothing does.
fn silhouette(
    still: &StillScene,
    map: &DepthMap,
    moves: &Mask,
    camera: &Camera,
) -> Option<Silhouette> {
    let mask = opened(&closed(moves, CLEAN_PX), CLEAN_PX);
    let now = still.filled_in(&nearness(map));
    let borders = trace(&clean(&Runs::from_mask(&mask), &CleanOptions::default()));
    let recorded = InfiniteHomography::new(&map.pair.left.camera, camera);
    let curve = |border: &Vec<Point2<f64>>| {
        let pixels = resample(border, SPACING_PX);
        let n = pixels.len();
        let point = |i: usize| {
            let along = pixels[(i + 1) % n] - pixels[(i + n - 1) % n];
            // the person is on the left as seen on the screen
            let inwards = Vector2::new(along.y, -along.x).try_normalize(0.0)?;
            Some(BorderPoint {
                pixel: recorded.pixel(&pixels[i])?,
                reliability: f64::from(u8::from(
                    depth_ends(&now, &pixels[i], &inwards)
                        .is_some_and(|near| both_see(&map.pair, &pixels[i], &inwards, near)),
                )),
            })
        };
        (0..n).filter_map(point).collect()
    };
    let curves: Vec<Vec<BorderPoint>> = borders.iter().map(curve).collect();
    from_curves(&curves, camera, &SilhouetteOptions::default()).ok()
}

/// How near what is within a border is, if it is nearer than what is outside.
fn depth_ends(nearness: &Plane<f32>, border: &Point2<f64>, inwards: &Vector2<f64>) -> Option<f32> {
    let at = |steps: i32| {
        let p = border + inwards * f64::from(steps);
        let is_in = p.x >= 0.0 && p.y >= 0.0;
        let value = is_in.then(|| nearness.get(p.x.round() as usize, p.y.round() as usize));
        value.flatten().filter(|v| v.is_finite())
    };
    let inside = (1..=BLUR_PX).filter_map(at).fold(f32::NAN, f32::max);
    let outside = (1..=BLUR_PX).filter_map(|k| at(-k)).fold(f32::NAN, f32::min);
    (inside > outside + NEARER_PX).then_some(inside)
}

/// Whether both cameras of a pair see what is just outside a border, were it as near as what is inside.
///
/// On one side of a picture is a strip that the other camera does not see. There depths end, but nobody does.
fn both_see(
    pair: &RectifiedPair,
    border: &Point2<f64>,
    inwards: &Vector2<f64>,
    nearness: f32,
) -> bool {
    let beyond = border.x - inwards.x * f64::from(BLUR_PX);
    let disparity = pair.infinity() + f64::from(nearness) * pair.baseline().signum();
    let sees = |x: f64, width: u32| (0.0..f64::from(width)).contains(&x);
    sees(beyond, pair.left.camera.width_px) && sees(beyond - disparity, pair.right.camera.width_px)
}

/// At most so many of the points, taken evenly.
pub(super) fn thinned(points: Vec<CloudPoint>, most: usize) -> Vec<CloudPoint> {
    let step = points.len().div_ceil(most).max(1);
    points.into_iter().step_by(step).collect()
}

/// The points in the largest set of neighbouring cells.
pub(super) fn largest_piece(points: Vec<CloudPoint>) -> Vec<CloudPoint> {
    let cell = |p: &CloudPoint| -> [i64; 3] {
        let cell = p.position_world.coords.map(|x| (x / CELL_M).floor() as i64);
        cell.into()
    };
    let mut counts: BTreeMap<[i64; 3], usize> = BTreeMap::new();
    for point in &points {
        *counts.entry(cell(point)).or_default() += 1;
    }
    counts.retain(|_, count| *count >= LEAST_IN_CELL);

    // from any cell that is left, all that hang together with it
    let (mut best, mut most) = (BTreeSet::new(), 0);
    while let Some((first, count)) = counts.pop_first() {
        let (mut piece, mut waiting, mut total) = (BTreeSet::from([first]), vec![first], count);
        while let Some([x, y, z]) = waiting.pop() {
            for k in 0..27 {
                let next = [x + k % 3 - 1, y + k / 3 % 3 - 1, z + k / 9 - 1];
                if let Some(count) = counts.remove(&next) {
                    piece.insert(next);
                    waiting.push(next);
                    total += count;
                }
            }
        }
        if total > most {
            (best, most) = (piece, total);
        }
    }

    points.into_iter().filter(|p| best.contains(&cell(p))).collect()
}

#[cfg(test)]
mod tests {
    use super::super::still::tests::{depth_map, learnt};
    use super::*;
    use crate::stereo::Spread;

    #[test]
    fn a_border_is_believed_where_depth_ends_with_it_and_not_where_the_person_always_stood() {
        let still_person = |x: usize| (10..20).contains(&x);
        let moves = |x: usize| (20..30).contains(&x);
        let is_body = |y: usize| (5..25).contains(&y);
        let maps: Vec<DepthMap> = (0..10)
            .map(|frame| {
                depth_map(|x, y| {
                    let is_near = is_body(y) && (still_person(x) || frame > 6 && moves(x));
                    if is_near { 20.0 } else { 5.0 }
                })
            })
            .collect();
        let still = learnt(&maps.iter().map(nearness).collect::<Vec<_>>());
        let seen = |map: &DepthMap| {
            let moves = still.nearer(&nearness(map));
            silhouette(&still, map, &moves, &map.pair.left.camera)
        };
        assert!(seen(&maps[0]).is_none());
        let found = seen(&maps[9]).unwrap();
        let beside = |x: f64| {
            let points = found
                .contour
                .iter()
                .filter(move |p| (p.pixel.x - x).abs() < 2.0 && (p.pixel.y - 15.0).abs() < 5.0);
            points.map(|p| p.reliability).collect::<Vec<_>>()
        };
        let (held, free) = (beside(21.0), beside(28.0));
        assert!(!held.is_empty() && held.iter().all(|r| *r <= 0.0), "{held:?}");
        assert!(!free.is_empty() && free.iter().all(|r| *r >= 1.0), "{free:?}");
    }

    #[test]
    fn where_only_one_camera_sees_depths_end_but_nobody_does() {
        // the second camera is to the right: it does not see the leftmost columns, as many as the disparity has pixels
        let map = depth_map(|_, _| 5.0);
        let outwards_left = Vector2::new(1.0, 0.0);
        let at = |x: f64| both_see(&map.pair, &Point2::new(x, 15.0), &outwards_left, 20.0);
        assert!(!at(20.0) && !at(25.0) && at(27.0));
        let upwards = Vector2::new(0.0, 1.0);
        let at = |x: f64| both_see(&map.pair, &Point2::new(x, 15.0), &upwards, 20.0);
        assert!(!at(19.0) && at(21.0) && !at(41.0));
    }

    #[test]
    fn of_two_pieces_the_larger_is_kept_and_strays_go() {
        let at =
            |x: f64| CloudPoint { position_world: [x, 0.0, 1.0].into(), spread: Spread::Unknown };
        let near = (0..90).map(|i| at(f64::from(i) * 0.01));
        let far = (0..30).map(|i| at(5.0 + f64::from(i) * 0.01));
        let all = near.chain(far).chain([at(2.0)]).collect();
        assert_eq!(largest_piece(all).len(), 90);
    }
}
