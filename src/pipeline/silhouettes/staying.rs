//! Somebody who stays in one place is no part of the still scene, though their trunk never moves.
//!
//! On a treadmill arms and legs move and the trunk between them does not: a pixel of it shows the same depth all the time, so
//! it is learnt as still scene. But depth goes on from the limbs to the trunk, and ends behind it. So
//!
//! 1. what moves says where the person is: the median of the largest piece of moving points, frame by frame. Where as much moves
//!    elsewhere, a person may be there too;
//! 2. the floor is the height at which most points of the still scene about that place lie, no higher than what moves there;
//! 3. the person is the piece of depth, above the floor and within reach of that place, that holds most of what moves;
//! 4. a pixel whose still depth is in that piece in most of the frames that show it is the person's.
//!
//! There the still scene is put behind the person, as far as a body reaches. Of somebody who walks by, no pixel is so: what
//! is still is behind them. Of furniture that touches the person no more than what is within reach is taken for theirs; a
//! body is fitted to it robustly, and what is far from the fit is not used again.

use std::collections::BTreeMap;

use nalgebra::{Point3, Vector2};
use rayon::prelude::*;

use super::moving::CLEAN_PX;
use super::pieces::{LEAST_OF_LARGEST, MOST_THINGS, Piece, largest_piece, middle, things};
use super::seen_depths::{EVERY_PX, SeenDepths};
use super::still::{StillScene, StillScenes};
use crate::camera::CameraId;
use crate::image::{Mask, Plane, closed, opened};
use crate::silhouette::FrameIndex;
use crate::stereo::CloudPoint;

/// A standing body lies within this distance of its middle, but for arms that are stretched out, m.
pub(super) const REACH_M: f64 = 0.6;
/// A body's highest point is at most this far above the floor, m: but for one in a million, people are shorter.
const TALLEST_M: f64 = 2.2;
/// Heights are counted in steps of this size, m: what correlation tells apart at the distance of a room.
const HEIGHT_STEP_M: f64 = 0.04;
/// The floor is looked for within this distance of the person, m.
const ABOUT_M: f64 = 1.0;
/// Depth goes on between pixels whose disparities differ by at most this, px, and over gaps of [`GAP_PX`].
const GOES_ON_PX: f32 = 1.0;
/// Pixels without a depth are crossed up to this distance.
const GAP_PX: usize = 3;
/// A pixel is the person's if it is so in more than this share of the frames that show its still depth.
const MOSTLY: f64 = 0.5;
/// This share of the heights of what moves may be false, as of the depths of the still scene.
const LOWEST: f64 = 0.1;

/// Where the person stands, and the floor there.
#[derive(Debug, Clone, Copy)]
struct Standing {
    /// Seen from above, m.
    place: Vector2<f64>,
    /// m.
    floor: f64,
}

impl Standing {
    fn holds(&self, point: &Point3<f64>) -> bool {
        let height = point.z - self.floor;
        let beside = (point.coords.xy() - self.place).norm();
        beside < REACH_M && height > 1.5 * HEIGHT_STEP_M && height < TALLEST_M
    }
}

impl StillScenes {
    /// Puts the still scenes behind a person who stays in one place.
    pub(super) fn put_behind_who_stays(&mut self, seen: &BTreeMap<CameraId, SeenDepths>) {
        let moving = self.moving_masks(seen);
        let Some(standing) = self.standing(seen, &moving) else {
            return;
        };

        let staying = seen.par_iter().filter_map(|(camera, depths)| {
            let (still, masks) = (self.get(*camera)?, moving.get(camera)?);
            Some((*camera, staying(still, depths, masks, &standing)))
        });
        let staying: BTreeMap<CameraId, Mask> = staying.collect();
        for (camera, still) in self.iter_mut() {
            if let (Some(person), Some(depths)) = (staying.get(camera), seen.get(camera)) {
                let behind = |near: f32| behind(depths.scale(), near);
                still.put_behind(person, behind);
            }
        }
    }

    /// What moves, frame by frame, without specks.
    fn moving_masks(&self, seen: &BTreeMap<CameraId, SeenDepths>) -> Moving {
        let of_camera = |(camera, depths): (&CameraId, &SeenDepths)| {
            let still = self.get(*camera)?;
            let moves = |(frame, map): (&FrameIndex, &Plane<f32>)| {
                (*frame, opened(&closed(&still.nearer(map), CLEAN_PX), CLEAN_PX))
            };
            Some((*camera, depths.maps.par_iter().map(moves).collect()))
        };
        seen.iter().filter_map(of_camera).collect()
    }

    /// Where somebody may stand in each frame in which something moves.
    fn standing(
        &self,
        seen: &BTreeMap<CameraId, SeenDepths>,
        moving: &Moving,
    ) -> Option<BTreeMap<FrameIndex, Vec<Standing>>> {
        let mut points = BTreeMap::<FrameIndex, Vec<CloudPoint>>::new();
        for (camera, masks) in moving {
            for (frame, mask) in masks {
                let (depths, of_frame) = (seen.get(camera)?, points.entry(*frame).or_default());
                let map = depths.maps.get(frame)?;
                let near = |x, y| map.get(x, y).filter(|_| mask.is_foreground(x, y));
                of_frame.extend(depths.places(near));
            }
        }

        // the floor, about each thing that moves in the whole recording
        let all: Vec<_> = points.values().flatten().step_by(EVERY_PX).copied().collect();
        let floor = |thing: &Piece| self.floor(seen, &thing.of(&all));
        let floors: Vec<Standing> = things(&all).iter().filter_map(floor).collect();

        // and in each frame where most moves above it
        let standing = points.into_iter().filter_map(|(frame, points)| {
            let standing: Vec<_> = places(points, &floors);
            (!standing.is_empty()).then_some((frame, standing))
        });
        Some(standing.collect())
    }
}

/// Where most moves above the floor, and where else as much as a thing of its own would; `floors` are known at some places.
fn places(mut moving: Vec<CloudPoint>, floors: &[Standing]) -> Vec<Standing> {
    let floor = |place: Vector2<f64>| {
        let far = |standing: &&Standing| (standing.place - place).norm();
        floors.iter().min_by(|a, b| far(a).total_cmp(&far(b))).map(|nearest| nearest.floor)
    };
    moving.retain(|p| {
        let floor = floor(p.position_world.coords.xy());
        floor.is_some_and(|floor| p.position_world.z > floor + 1.5 * HEIGHT_STEP_M)
    });

    let (mut places, mut most) = (Vec::new(), 0);
    while places.len() < MOST_THINGS {
        let place = middle(&largest_piece(&moving));
        let Some((place, floor)) = place.and_then(|place| Some((place, floor(place)?))) else {
            break;
        };

        let before = moving.len();
        moving.retain(|p| (p.position_world.coords.xy() - place).norm() >= REACH_M);
        let within = before - moving.len();
        most = most.max(within);
        if (within as f64) < LEAST_OF_LARGEST * most as f64 {
            break;
        }
        places.push(Standing { place, floor });
    }
    places
}

impl StillScenes {
    /// Where something moves, and the floor there: the commonest height of the still scene about it, no higher than its lowest points.
    fn floor(
        &self,
        seen: &BTreeMap<CameraId, SeenDepths>,
        moving: &[CloudPoint],
    ) -> Option<Standing> {
        let place = middle(moving)?;
        let mut heights: Vec<f64> = moving.iter().map(|p| p.position_world.z).collect();
        heights.sort_by(f64::total_cmp);
        let lowest = heights.get((LOWEST * heights.len() as f64) as usize)?;
        let highest = lowest + 2.0 * HEIGHT_STEP_M;

        let mut below = Vec::new();
        for (camera, depths) in seen {
            let still = self.get(*camera)?;
            let about = depths.places(|x, y| still.nearness(x, y)).into_iter();
            let about = about.map(|p| p.position_world);
            let about = about.filter(|p| (p.coords.xy() - place).norm() < ABOUT_M);
            below.extend(about.map(|p| p.z).filter(|height| *height < highest));
        }
        Some(Standing { place, floor: commonest(&below).unwrap_or(*lowest) })
    }
}

/// Of each camera what moves in each frame.
type Moving = BTreeMap<CameraId, BTreeMap<FrameIndex, Mask>>;

/// How near things are that are a body's reach behind something.
fn behind(scale: f64, nearness: f32) -> f32 {
    let depth_m = scale / f64::from(nearness) + REACH_M;
    if depth_m.is_finite() { (scale / depth_m) as f32 } else { 0.0 }
}

/// The commonest of some heights, to within [`HEIGHT_STEP_M`].
fn commonest(heights: &[f64]) -> Option<f64> {
    let mut counts = BTreeMap::<i64, usize>::new();
    for height in heights {
        *counts.entry((height / HEIGHT_STEP_M).floor() as i64).or_default() += 1;
    }
    let most = counts.into_iter().max_by_key(|(_, count)| *count)?;
    Some((most.0 as f64 + 0.5) * HEIGHT_STEP_M)
}

/// The pixels of one camera whose still depth is a person's who stays.
fn staying(
    still: &StillScene,
    depths: &SeenDepths,
    moving: &BTreeMap<FrameIndex, Mask>,
    standing: &BTreeMap<FrameIndex, Vec<Standing>>,
) -> Mask {
    let (width, height) = (depths.camera.width_px as usize, depths.camera.height_px as usize);
    let frames: Vec<_> = depths.maps.iter().collect();
    let bodies = frames.par_iter().filter_map(|(frame, map)| {
        let (moves, standing) = (moving.get(frame)?, standing.get(frame)?);
        let bodies = standing.iter().map(|standing| body(depths, map, moves, standing));
        Some((*map, bodies.collect()))
    });
    let bodies: Vec<(&Plane<f32>, Vec<Mask>)> = bodies.collect();

    let mostly = Mask::from_fn(width, height, |x, y| {
        if still.nearness(x, y).is_none_or(|near| near <= 0.0) {
            return false;
        }
        let is_at = |map: &Plane<f32>| map.get(x, y).is_some_and(|d| still.is_at(x, y, d));
        let shown = bodies.iter().filter(|(map, _)| is_at(map));
        let (all, own) = shown.fold((0, 0), |(all, own), (_, bodies)| {
            (all + 1, own + usize::from(bodies.iter().any(|body| body.is_foreground(x, y))))
        });
        f64::from(own as u32) > MOSTLY * f64::from(all as u32)
    });
    opened(&closed(&mostly, CLEAN_PX), CLEAN_PX)
}

/// The piece of depth within reach that holds most of what moves.
fn body(depths: &SeenDepths, map: &Plane<f32>, moves: &Mask, standing: &Standing) -> Mask {
    let (width, height) = (map.width(), map.height());
    let can_be = |x: usize, y: usize| {
        let place = map.get(x, y).and_then(|near| depths.place(x, y, near));
        place.is_some_and(|place| standing.holds(&place))
    };
    let free = Mask::from_fn(width, height, can_be);

    // piece by piece
    let mut piece_of = vec![0u32; width * height];
    let (mut best, mut most, mut pieces) = (0, 0, 0);
    for start in 0..width * height {
        if piece_of[start] > 0 || !free.is_foreground(start % width, start / width) {
            continue;
        }

        pieces += 1;
        piece_of[start] = pieces;
        let (mut waiting, mut moved) = (vec![start], 0);
        while let Some(at) = waiting.pop() {
            let (x, y) = (at % width, at / width);
            moved += usize::from(moves.is_foreground(x, y));
            let here = map.get(x, y).unwrap_or(f32::NAN);
            for (x, y) in beside(x, y) {
                let goes_on = map.get(x, y).is_some_and(|d| (d - here).abs() < GOES_ON_PX);
                if goes_on && free.is_foreground(x, y) && piece_of[y * width + x] == 0 {
                    piece_of[y * width + x] = pieces;
                    waiting.push(y * width + x);
                }
            }
        }
        if moved > most {
            (best, most) = (pieces, moved);
        }
    }
    Mask::from_fn(width, height, |x, y| best > 0 && piece_of[y * width + x] == best)
}

/// The pixels up to [`GAP_PX`] away in the row and in the column.
fn beside(x: usize, y: usize) -> impl Iterator<Item = (usize, usize)> {
    (1..=GAP_PX).flat_map(move |k| {
        let left = x.checked_sub(k).map(|x| (x, y));
        let above = y.checked_sub(k).map(|y| (x, y));
        [Some((x + k, y)), Some((x, y + k)), left, above].into_iter().flatten()
    })
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_2;

    use nalgebra::Vector3;

    use super::*;
    use crate::camera::{Camera, Distortion, Intrinsics};
    use crate::math::Rigid3;

    const SIZE: [usize; 2] = [40, 30];

    /// One camera that looks along y and sees a centimetre a pixel at one metre; the wall is 2.5 m away.
    fn seen(is_person: impl Fn(usize, usize, usize) -> bool) -> BTreeMap<CameraId, SeenDepths> {
        let [width, height] = SIZE;
        let intrinsics =
            Intrinsics { fx_px: 100.0, fy_px: 100.0, cx_px: 19.5, cy_px: 14.5, skew_px: 0.0 };
        let camera = Camera {
            name: "left".into(),
            width_px: width as u32,
            height_px: height as u32,
            intrinsics,
            distortion: Distortion::None,
            camera_from_world: Rigid3::rotation(Vector3::new(FRAC_PI_2, 0.0, 0.0)),
        };
        let map = |frame: usize| {
            let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
            let near = pixels.map(|(x, y)| if is_person(frame, x, y) { 20.0 } else { 8.0 });
            Plane::from_values(width, height, near.collect()).expect("as many as pixels")
        };
        let maps = (0..20).map(|frame| (FrameIndex(frame), map(frame))).collect();
        BTreeMap::from([(CameraId(0), SeenDepths { camera, baseline_m: 0.2, maps })])
    }

    /// What is in front of the still scene in a frame, before and after it is put behind who stays.
    fn in_front(seen: &BTreeMap<CameraId, SeenDepths>, frame: usize) -> [Mask; 2] {
        let mut stills = StillScenes::learn(seen);
        let (id, depths) = seen.first_key_value().expect("one camera");
        let map = &depths.maps[&FrameIndex(frame)];
        let before = stills.get(*id).expect("its scene").nearer(map);
        stills.put_behind_who_stays(seen);
        [before, stills.get(*id).expect("its scene").nearer(map)]
    }

    fn is_arm(frame: usize, x: usize, y: usize) -> bool {
        frame % 4 < 2 && (24..34).contains(&x) && (2..28).contains(&y)
    }

    #[test]
    fn a_trunk_that_never_moves_is_in_front_once_the_arm_beside_it_has_moved() {
        let is_trunk = |x: usize, y: usize| (12..24).contains(&x) && (2..28).contains(&y);
        let seen = seen(|frame, x, y| is_trunk(x, y) || is_arm(frame, x, y));
        for frame in [0, 2] {
            let [before, after] = in_front(&seen, frame);
            assert!(!before.is_foreground(18, 9) && after.is_foreground(18, 9));
            assert!(!after.is_foreground(6, 9), "the wall is nobody");
        }
    }

    #[test]
    fn a_cupboard_apart_from_what_moves_stays_where_it_is() {
        // as near, but depth ends between it and the arm
        let is_cupboard = |x: usize, y: usize| x < 14 && (2..28).contains(&y);
        let seen = seen(|frame, x, y| is_cupboard(x, y) || is_arm(frame, x, y));
        let [before, after] = in_front(&seen, 0);
        assert_eq!(before, after);
        assert!(after.is_foreground(28, 9), "the arm");
    }

    #[test]
    fn a_trunk_is_in_front_too_where_a_cart_moves_more_than_the_arm() {
        // a curtain far from the person, a metre behind, comes and goes with the arm
        let is_trunk = |x: usize, y: usize| (16..24).contains(&x) && (2..28).contains(&y);
        let is_cart = |frame: usize, x: usize| frame % 4 < 2 && x < 7;
        let mut seen = seen(|frame, x, y| is_trunk(x, y) || is_arm(frame, x, y));
        for depths in seen.values_mut() {
            for (frame, map) in &mut depths.maps {
                for y in 0..SIZE[1] {
                    let row = map.row_mut(y).iter_mut().enumerate();
                    row.filter(|(x, _)| is_cart(frame.0, *x)).for_each(|(_, near)| *near = 11.0);
                }
            }
        }
        let [before, after] = in_front(&seen, 0);
        assert!(before.is_foreground(3, 9) && before.is_foreground(28, 9));
        assert!(!before.is_foreground(19, 9) && after.is_foreground(19, 9));
    }

    #[test]
    fn of_somebody_who_walks_by_nothing_is_changed() {
        let seen = seen(|frame, x, y| (2 * frame..2 * frame + 10).contains(&x) && y > 1);
        for frame in [3, 12] {
            let [before, after] = in_front(&seen, frame);
            assert_eq!(before, after);
        }
    }
}
