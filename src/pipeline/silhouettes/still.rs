//! The static scene, learnt first: per pixel the farthest depth that is seen repeatedly. What is nearer moves.

use std::collections::BTreeMap;

use rayon::prelude::*;

use super::ends::{nearness, where_depth_goes_on};
use super::seen_depths::SeenDepths;
use crate::camera::CameraId;
use crate::image::{Mask, Plane};
use crate::stereo::{CloudPoint, DepthMap};

/// How near the static scene is in each pixel, when nobody stands in front of it.
///
/// It serves the first fit alone, when no model says yet where the person is. Nothing is learnt of how the background looks.
/// The person is always nearer than the scene and may stand in one place in most frames, so a pixel's scene is the farthest
/// depth that it shows repeatedly. Where that is seldom known (a bare wall), the scene counts as far away.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct StillScene {
    /// 0: far away.
    nearness: Plane<f32>,
    /// What moves is nearer by more than this, px.
    margin: Plane<f32>,
}

/// This share of a pixel's depths, the farthest, may be false.
const FALSE_SHARE: f64 = 0.1;
/// The scene has texture in a pixel if its depth is known in at least this share of the frames in which nothing is in front
/// of it. Without texture the known depths are those of the person who walked by.
const KNOWN_SHARE: f64 = 0.3;
/// What moves is nearer than the still scene at least by this disparity, px.
pub(super) const NEARER_PX: f32 = 1.5;
/// Gaps in the known part of the still scene up to twice this are bridged, px: correlation has no answer for every pixel.
const BRIDGED_PX: usize = 20;

/// What moves is beyond the noise of a pixel's depths by three standard deviations: from their middle, which lies 1.28
/// above the farthest tenth.
const BEYOND_NOISE: f32 = 4.28;
/// The lower quartile of |d − d'| of two depths with the same noise σ, over σ: √2 · 0.3186.
const QUARTILE_OF_STEPS: f32 = 0.4506;
/// Fewer steps do not tell the noise.
const LEAST_STEPS: usize = 4;

/// The still scenes of those cameras of which they are known.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct StillScenes(BTreeMap<CameraId, StillScene>);

impl StillScenes {
    /// The still scenes of the [`nearness`] of each camera's depth maps, of frames spread over the recording.
    pub(super) fn learn(seen: &BTreeMap<CameraId, SeenDepths>) -> Self {
        let scene = |(camera, seen): (&CameraId, &SeenDepths)| {
            let maps: Vec<&Plane<f32>> = seen.maps.values().collect();
            (*camera, StillScene::learn(&maps))
        };
        Self(seen.par_iter().map(scene).collect())
    }

    /// Whether none is known.
    pub(super) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Those of all cameras, to be changed.
    pub(super) fn iter_mut(&mut self) -> impl Iterator<Item = (&CameraId, &mut StillScene)> {
        self.0.iter_mut()
    }

    /// That of one camera.
    pub(super) fn get(&self, camera: CameraId) -> Option<&StillScene> {
        self.0.get(&camera)
    }
}

impl StillScene {
    /// The still scene of the [`nearness`] of one camera's depth maps, of frames spread over the recording.
    pub(super) fn learn(maps: &[&Plane<f32>]) -> Self {
        let Some(first) = maps.first() else {
            let nothing = Plane::filled(0, 0, 0.0);
            return Self { nearness: nothing.clone(), margin: nothing };
        };

        let mut still = Plane::filled(first.width(), first.height(), 0.0);
        let mut margin = Plane::filled(first.width(), first.height(), NEARER_PX);
        let mut seen = Vec::with_capacity(maps.len());
        for y in 0..first.height() {
            for (x, value) in still.row_mut(y).iter_mut().enumerate() {
                seen.clear();
                seen.extend(maps.iter().filter_map(|m| m.get(x, y)).filter(|d| d.is_finite()));
                if seen.is_empty() {
                    continue;
                }
                if let Some(margin) = margin.row_mut(y).get_mut(x) {
                    *margin = NEARER_PX.max(BEYOND_NOISE * noise_px(&seen));
                }

                // the farthest but for false depths, if it was known in most frames with nothing before it
                let place = (FALSE_SHARE * seen.len() as f64) as usize;
                let far = *seen.select_nth_unstable_by(place, f32::total_cmp).1;
                let before = seen.iter().filter(|d| **d > far + NEARER_PX).count();
                let known = seen.len() - before;
                if known as f64 >= KNOWN_SHARE * (maps.len() - before) as f64 {
                    *value = far;
                }
            }
        }
        Self { nearness: filled(&still), margin }
    }

    /// How near it is in a pixel; `None` outside, 0 far away.
    pub(super) fn nearness(&self, x: usize, y: usize) -> Option<f32> {
        self.nearness.get(x, y)
    }

    /// Whether a nearness in a pixel is in front of it.
    fn is_before(&self, x: usize, y: usize, nearness: f32) -> bool {
        let still = self.nearness.get(x, y).zip(self.margin.get(x, y));
        still.is_some_and(|(still, margin)| nearness > still + margin)
    }

    /// Whether a nearness in a pixel is its own, but for noise.
    pub(super) fn is_at(&self, x: usize, y: usize, nearness: f32) -> bool {
        let still = self.nearness.get(x, y).zip(self.margin.get(x, y));
        still.is_some_and(|(still, margin)| (nearness - still).abs() <= margin)
    }

    /// The scene behind somebody who always stands in some of its pixels: `behind` has how near things may be there without
    /// being the person's.
    pub(super) fn put_behind(&mut self, person: &Mask, behind: impl Fn(f32) -> f32) {
        for y in 0..person.height().min(self.nearness.height()) {
            for (x, value) in self.nearness.row_mut(y).iter_mut().enumerate() {
                if person.is_foreground(x, y) {
                    *value = behind(*value);
                    if let Some(margin) = self.margin.row_mut(y).get_mut(x) {
                        *margin = NEARER_PX;
                    }
                }
            }
        }
    }

    /// Where a [`nearness`] of the same camera is in front of the still scene, with all eight neighbours.
    ///
    /// So the outermost pixels are left out: correlation by windows makes what moves too wide, and a body fitted to it too fat.
    pub(super) fn nearer(&self, now: &Plane<f32>) -> Mask {
        let moves = Mask::from_fn(now.width(), now.height(), |x, y| {
            now.get(x, y).is_some_and(|now| self.is_before(x, y, now))
        });
        Mask::from_fn(now.width(), now.height(), |x, y| {
            let beside = |k: usize| (x + k % 3).checked_sub(1).zip((y + k / 3).checked_sub(1));
            (0..9).all(|k| beside(k).is_some_and(|(x, y)| moves.is_foreground(x, y)))
        })
    }

    /// A [`nearness`] of the same camera, and that of the still scene where it is not known.
    pub(super) fn filled_in(&self, now: &Plane<f32>) -> Plane<f32> {
        let mut filled = now.clone();
        for y in 0..filled.height() {
            for (x, value) in filled.row_mut(y).iter_mut().enumerate() {
                if value.is_nan() {
                    *value = self.nearness.get(x, y).unwrap_or(f32::NAN);
                }
            }
        }
        filled
    }

    /// The points of a depth map of the same camera that are in front of the still scene, away from the ends of depth.
    pub(super) fn before(&self, map: &DepthMap) -> Vec<CloudPoint> {
        let nearer = self.nearer(&nearness(map));
        points_where(map, &where_depth_goes_on(map, &nearer))
    }
}

/// Standard deviation of a pixel's depths, in the order of time, from the lower quartile of the steps between them: what comes
/// and goes takes larger steps, but not most of the time. 0 of too few depths.
fn noise_px(seen: &[f32]) -> f32 {
    let mut steps: Vec<f32> = seen.windows(2).map(|d| (d[1] - d[0]).abs()).collect();
    if steps.len() < LEAST_STEPS {
        return 0.0;
    }
    let quarter = steps.len() / 4;
    *steps.select_nth_unstable_by(quarter, f32::total_cmp).1 / QUARTILE_OF_STEPS
}

/// The points of a depth map that a mask of its pixels shows.
pub(super) fn points_where(map: &DepthMap, mask: &Mask) -> Vec<CloudPoint> {
    let shown = known_points(map).filter(|((x, y), _)| mask.is_foreground(*x, *y));
    shown.map(|(_, point)| *point).collect()
}

/// The pixels of a depth map whose depth is known, and their points.
pub(super) fn known_points(map: &DepthMap) -> impl Iterator<Item = ((usize, usize), &CloudPoint)> {
    // row by row, as the points are
    let disparities = &map.disparities;
    let (width, height) = (disparities.width(), disparities.height());
    let pixels = (0..height).flat_map(move |y| (0..width).map(move |x| (x, y)));
    let is_known = |(x, y): &(usize, usize)| disparities.get(*x, *y).is_some_and(f32::is_finite);
    pixels.filter(is_known).zip(&map.points)
}

/// Unknown places (0) that lie between known ones: as far away as the farther of these, along the row or the column.
fn filled(still: &Plane<f32>) -> Plane<f32> {
    let known = |x: usize, y: usize| still.get(x, y).filter(|d| *d > 0.0);
    let mut filled = still.clone();
    for y in 0..still.height() {
        for (x, value) in filled.row_mut(y).iter_mut().enumerate() {
            if *value > 0.0 {
                continue;
            }

            let reach = 1..=BRIDGED_PX;
            let left = reach.clone().find_map(|k| known(x.checked_sub(k)?, y));
            let right = reach.clone().find_map(|k| known(x + k, y));
            let above = reach.clone().find_map(|k| known(x, y.checked_sub(k)?));
            let below = reach.clone().find_map(|k| known(x, y + k));

            let between = |a: Option<f32>, b: Option<f32>| Some(a?.min(b?));
            let bridges = [between(left, right), between(above, below)];
            *value = bridges.into_iter().flatten().fold(0.0, f32::max);
        }
    }
    filled
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::stereo::StereoView;

    pub(in super::super) fn learnt(maps: &[Plane<f32>]) -> StillScene {
        StillScene::learn(&maps.iter().collect::<Vec<_>>())
    }

    fn point(place: [f64; 3]) -> CloudPoint {
        CloudPoint { position_world: place.into(), spread: crate::stereo::Spread::Unknown }
    }

    #[test]
    fn the_still_scene_is_the_farthest_that_is_seen_again_and_again() {
        // before this pixel somebody stands most of the time, and one depth is false
        let depths = (0..20).map(|k| match k {
            0 => 3.0,
            1..8 => 20.0,
            _ => 40.0,
        });
        let maps: Vec<_> = depths.map(|d| Plane::filled(1, 1, d)).collect();
        let still = learnt(&maps);
        assert_eq!(still.nearness.get(0, 0), Some(20.0));
        assert_eq!(StillScene::learn(&[]).nearness.values().len(), 0);
    }

    /// One camera and another 20 cm to its right.
    fn view(name: &str, x_m: f64) -> StereoView {
        StereoView {
            camera: crate::camera::Camera {
                name: name.into(),
                width_px: 40,
                height_px: 30,
                intrinsics: crate::camera::Intrinsics {
                    fx_px: 100.0,
                    fy_px: 100.0,
                    cx_px: 19.5,
                    cy_px: 14.5,
                    skew_px: 0.0,
                },
                distortion: crate::camera::Distortion::None,
                camera_from_world: crate::math::Rigid3::translation(-x_m, 0.0, 0.0),
            },
            image: Plane::filled(40, 30, 0.0),
        }
    }

    /// Of a camera of 40 by 30 px; its points are pixels, and 1.
    pub(in super::super) fn depth_map(disparity: impl Fn(usize, usize) -> f32) -> DepthMap {
        let pixels = (0..30).flat_map(|y| (0..40).map(move |x| (x, y)));
        let values = pixels.clone().map(|(x, y)| disparity(x, y)).collect();
        DepthMap {
            pair: crate::stereo::RectifiedPair {
                left: view("left", 0.0),
                right: view("right", 0.2),
            },
            disparities: Plane::from_values(40, 30, values).unwrap(),
            points: pixels.map(|(x, y)| point([x as f64, y as f64, 1.0])).collect(),
        }
    }

    #[test]
    fn of_a_foot_on_the_floor_the_points_are_those_of_the_foot() {
        // the floor is the nearer the lower it is seen; the foot comes after a while and stands a little before it
        let floor = |y: usize| 5.0 + 0.3 * y as f32;
        let is_foot = |x: usize, y: usize| (10..20).contains(&x) && (15..25).contains(&y);
        let maps: Vec<DepthMap> = (0..10)
            .map(|frame| {
                depth_map(|x, y| floor(y) + if frame > 6 && is_foot(x, y) { 3.0 } else { 0.0 })
            })
            .collect();
        let still = learnt(&maps.iter().map(nearness).collect::<Vec<_>>());
        assert_eq!(still.before(&maps[0]), []);
        let foot = still.before(&maps[9]);
        let is_in =
            |p: &CloudPoint| is_foot(p.position_world.x as usize, p.position_world.y as usize);
        // without its border, as wide as a window
        assert!(foot.len() == 4 && foot.iter().all(is_in), "{}", foot.len());
    }

    #[test]
    fn a_wall_whose_depth_is_almost_never_known_is_far_away() {
        let map = |d: f32| Plane::filled(3, 1, d);
        let mut maps = vec![map(f32::NAN); 9];
        maps.push(map(40.0));
        let still = learnt(&maps);
        assert!(still.nearness.values().iter().all(|d| *d <= 0.0));
    }

    #[test]
    fn somebody_who_walks_before_a_bare_wall_is_not_the_still_scene() {
        // nearer from frame to frame, where the wall has no depth; and before one of which it is seen half the time
        let walks = |frame: usize| 20.0 + frame as f32;
        let of = |wall: fn(usize) -> f32| {
            let depths = (0..40).map(|k| if k < 16 { walks(k) } else { wall(k) });
            learnt(&depths.map(|d| Plane::filled(1, 1, d)).collect::<Vec<_>>())
        };
        assert_eq!(of(|_| f32::NAN).nearness.get(0, 0), Some(0.0));
        let textured = of(|k| if k % 2 == 0 { 15.0 } else { f32::NAN });
        assert_eq!(textured.nearness.get(0, 0), Some(15.0));
    }
}
