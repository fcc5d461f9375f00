//! What the cameras show in one frame, without their lenses, and how far away it is.

use std::collections::{BTreeMap, BTreeSet};

use rayon::prelude::*;

use crate::camera::{CameraId, Rig};
use crate::image::{Picture, Plane, luma};
use crate::stereo::correlation::CorrelationOptions;
use crate::stereo::{CloudPoint, DepthMap, View, ViewError, depth_map, neighbour};

/// One camera's picture as its ideal camera would show it.
#[derive(Debug, Clone)]
pub struct ShownView {
    /// Brightness, and the camera without its lens.
    pub grey: View,
    /// Red, green and blue; NaN where the recorded picture shows nothing.
    pub colours: Vec<Plane<f32>>,
}

/// The pictures of one frame, in the order of the rig; `None` for a camera that has none.
#[derive(Debug, Clone)]
pub struct ShownFrame {
    /// View by view.
    pub views: Vec<Option<ShownView>>,
}

impl ShownFrame {
    /// Takes the lenses off the pictures of a frame.
    ///
    /// # Errors
    /// [`ViewError`] for a picture of another size than its camera's.
    pub fn of(rig: &Rig, pictures: &[Option<Picture>]) -> Result<Self, ViewError> {
        let cameras = rig.cameras.par_iter().enumerate();
        let views = cameras.map(|(i, camera)| {
            let Some(picture) = pictures.get(i).and_then(Option::as_ref) else {
                return Ok(None);
            };
            let channel = |c: usize| View::of(camera, &picture.map(|rgb| rgb[c]));
            let colours = (0..3)
                .map(|c| Ok(channel(c)?.image))
                .collect::<Result<_, _>>()?;
            Ok(Some(ShownView {
                grey: View::of(camera, &luma(picture))?,
                colours,
            }))
        });
        Ok(Self {
            views: views.collect::<Result<_, _>>()?,
        })
    }

    /// Depth of what a camera shows, by correlation with the camera beside it; `None` where there is none, or no picture.
    ///
    /// Without a mask; between a least and a greatest depth, m, or of all depths that a shift of a third of the image allows.
    pub fn depth(
        &self,
        rig: &Rig,
        camera: CameraId,
        depths_m: Option<(f64, f64)>,
    ) -> Option<DepthMap> {
        let view = |id: CameraId| self.views.get(id.0)?.as_ref();
        let (first, second) = (view(camera)?, view(neighbour(rig, camera)?)?);
        let options = CorrelationOptions::default();
        // a pair that cannot be correlated has no depth
        depth_map(&first.grey, &second.grey, None, depths_m, &options).ok()
    }
}

/// Disparities of a depth map from infinity: the larger, the nearer; NaN unknown.
pub fn nearness(map: &DepthMap) -> Plane<f32> {
    let infinity = map.pair.left.camera.intrinsics.cx_px - map.pair.right.camera.intrinsics.cx_px;
    map.disparities.map(|d| (d - infinity as f32).abs())
}

/// The parts of the scene that do not move, by their nearness: what each pixel shows when nobody is before it.
///
/// Only for the very first fit, when no model says yet where the person is: nothing of the background's look is learned.
/// A pixel's still scene is the farthest that it ever shows for long: the person is always nearer, and may stand before the same place
/// in most frames. Where its depth is almost never known (a bare wall), it counts as far away.
#[derive(Debug, Clone, PartialEq)]
pub struct StillScene {
    /// 0: far away.
    nearness: Plane<f32>,
}

/// The still scene is farther than all but this share of the depths that a pixel ever showed: these may be false.
const FALSE_SHARE: f64 = 0.1;
/// A pixel whose depth is known in a smaller share of the frames shows something without texture, which is far away.
const KNOWN_SHARE: f64 = 0.2;
/// What moves is nearer than the still scene by this disparity, px.
const NEARER_PX: f32 = 1.5;
/// Gaps in the known part of the still scene up to twice this are bridged, px: correlation has no answer for every pixel.
const BRIDGED_PX: usize = 20;
/// Edge of the cells by which points hang together, m.
const CELL_M: f64 = 0.1;
/// A cell of fewer points is stray.
const LEAST_IN_CELL: usize = 3;

/// The still scenes of those cameras of which they are known.
pub type StillScenes = BTreeMap<CameraId, StillScene>;

impl StillScene {
    /// The still scene of the [`nearness`] of one camera's depth maps, of frames spread over the recording.
    pub fn of(maps: &[Plane<f32>]) -> Self {
        let Some(first) = maps.first() else {
            return Self {
                nearness: Plane::filled(0, 0, 0.0),
            };
        };
        let mut still = Plane::filled(first.width(), first.height(), 0.0);
        let mut seen = Vec::with_capacity(maps.len());
        for y in 0..first.height() {
            for (x, value) in still.row_mut(y).iter_mut().enumerate() {
                seen.clear();
                seen.extend(
                    maps.iter()
                        .filter_map(|m| m.get(x, y))
                        .filter(|d| d.is_finite()),
                );
                if !seen.is_empty() && seen.len() as f64 >= KNOWN_SHARE * maps.len() as f64 {
                    let place = (FALSE_SHARE * seen.len() as f64) as usize;
                    *value = *seen.select_nth_unstable_by(place, f32::total_cmp).1;
                }
            }
        }
        Self {
            nearness: filled(&still),
        }
    }

    /// The points of a depth map of the same camera that are before the still scene: the largest piece that hangs together.
    pub fn moving(&self, map: &DepthMap) -> Vec<CloudPoint> {
        largest_piece(self.before(map))
    }

    /// The points of a depth map of the same camera that are before the still scene.
    ///
    /// Without the border of what moves: correlation by windows makes it wider than it is, and a body fitted to it too fat.
    pub fn before(&self, map: &DepthMap) -> Vec<CloudPoint> {
        let now = nearness(map);
        let moves = |x: usize, y: usize| match (now.get(x, y), self.nearness.get(x, y)) {
            (Some(now), Some(still)) => now > still + NEARER_PX,
            _ => false,
        };
        // row by row, as the points are
        let pixels = (0..now.height()).flat_map(|y| (0..now.width()).map(move |x| (x, y)));
        let known = pixels.filter(|(x, y)| now.get(*x, *y).is_some_and(f32::is_finite));
        let inside = known.zip(&map.points).filter(|((x, y), _)| {
            let beside = |k: usize| (*x + k % 3).checked_sub(1).zip((*y + k / 3).checked_sub(1));
            (0..9).all(|k| beside(k).is_some_and(|(x, y)| moves(x, y)))
        });
        inside.map(|(_, point)| *point).collect()
    }
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

/// Those of the points that lie in the largest set of neighbouring cells.
fn largest_piece(points: Vec<CloudPoint>) -> Vec<CloudPoint> {
    let cell = |p: &CloudPoint| -> [i64; 3] {
        let cell = p.position_world.coords.map(|x| (x / CELL_M).floor() as i64);
        cell.into()
    };
    let mut counts: BTreeMap<[i64; 3], usize> = BTreeMap::new();
    for point in &points {
        *counts.entry(cell(point)).or_default() += 1;
    }
    counts.retain(|_, count| *count >= LEAST_IN_CELL);
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
    points
        .into_iter()
        .filter(|p| best.contains(&cell(p)))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_still_scene_is_the_farthest_that_is_seen_again_and_again() {
        // before this pixel somebody stands most of the time, and one depth is false
        let depths = (0..20).map(|k| match k {
            0 => 3.0,
            1..8 => 20.0,
            _ => 40.0,
        });
        let maps: Vec<_> = depths.map(|d| Plane::filled(1, 1, d)).collect();
        let still = StillScene::of(&maps);
        assert_eq!(still.nearness.get(0, 0), Some(20.0));
        assert_eq!(StillScene::of(&[]).nearness.values().len(), 0);
    }

    #[test]
    fn a_wall_whose_depth_is_almost_never_known_is_far_away() {
        let map = |d: f32| Plane::filled(3, 1, d);
        let mut maps = vec![map(f32::NAN); 9];
        maps.push(map(40.0));
        let still = StillScene::of(&maps);
        assert!(still.nearness.values().iter().all(|d| *d <= 0.0));
    }

    #[test]
    fn of_two_pieces_the_larger_is_kept_and_strays_go() {
        let point = |x: f64| CloudPoint {
            position_world: nalgebra::Point3::new(x, 0.0, 1.0),
            spread: crate::stereo::Spread::Unknown,
        };
        let near = (0..90).map(|i| point(f64::from(i) * 0.01));
        let far = (0..30).map(|i| point(5.0 + f64::from(i) * 0.01));
        let all = near.chain(far).chain([point(2.0)]).collect();
        assert_eq!(largest_piece(all).len(), 90);
    }
}
