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

use nalgebra::{Point2, Vector2};

use super::ends::nearness;
use super::pieces::{Piece, middle, things};
use super::still::{NEARER_PX, StillScene, StillScenes, known_points, points_where};
use super::undistorted::UndistortedFrame;
use crate::camera::{Camera, CameraId, InfiniteHomography, Rig};
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
/// At most so many points of one frame are fitted to.
pub(super) const MOST_POINTS: usize = 1500;

/// A piece of what moves in a frame.
#[derive(Debug, Clone)]
pub(super) struct Thing {
    /// The middle of its points, seen from above, m.
    pub(super) place: Vector2<f64>,
    /// How many points of it the cameras see.
    pub(super) size: usize,
    /// Its silhouettes, and some of its points.
    pub(super) observed: FrameObservations,
}

impl StillScenes {
    /// What is in front of the still scenes of the same cameras in a frame, piece by piece, the largest first.
    ///
    /// The pixels of a piece that is large enough to be a thing of its own are in no silhouette of another; those of smaller ones, as
    /// a hand that hangs on by nothing seen, are in all.
    pub(super) fn moving(
        &self,
        frame: FrameIndex,
        rig: &Rig,
        shown: &UndistortedFrame,
    ) -> Vec<Thing> {
        // 1. what moves in each camera
        let depths = shown.depths(rig);
        let moves = |(camera, map): &(CameraId, DepthMap)| {
            let still = self.get(*camera)?;
            Some((still, still.nearer(&nearness(map))))
        };
        let seen: Vec<_> = depths.iter().filter_map(|view| Some((view, moves(view)?))).collect();
        let points = seen.iter().flat_map(|((_, map), (_, moves))| points_where(map, moves));
        let points: Vec<CloudPoint> = points.collect();

        // 2. piece by piece
        let things = things(&points);
        let thing = |(i, piece): (usize, &Piece)| {
            let own = piece.of(&points);
            let place = middle(&own)?;

            let mut others: Vec<&Piece> = things.iter().collect();
            others.remove(i);
            let mut observed = FrameObservations::nothing(frame);
            for ((camera, map), (still, moves)) in &seen {
                let own = without(map, moves, &others);
                let silhouette = silhouette(still, map, &own, &rig.cameras[camera.0]);
                observed.views.extend(silhouette.map(|s| (*camera, s)));
            }
            observed.points = thinned(own, MOST_POINTS);
            Some(Thing { place, size: piece.count, observed })
        };
        things.iter().enumerate().filter_map(thing).collect()
    }
}

/// What moves without the pixels that show some pieces.
fn without(map: &DepthMap, moves: &Mask, pieces: &[&Piece]) -> Mask {
    let width = moves.width();
    let mut is_theirs = vec![false; width * moves.height()];
    for ((x, y), point) in known_points(map) {
        is_theirs[y * width + x] = pieces.iter().any(|piece| piece.holds(&point.position_world));
    }
    Mask::from_fn(width, moves.height(), |x, y| {
        moves.is_foreground(x, y) && !is_theirs[y * width + x]
    })
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

#[cfg(test)]
mod tests {
    use super::super::still::tests::{depth_map, learnt};
    use super::*;

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
}
