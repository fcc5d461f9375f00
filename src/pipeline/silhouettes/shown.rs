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

    /// Depth of what each camera shows, by correlation with the camera beside it; `None` where there is none, or no picture.
    ///
    /// Without a mask, and of all depths that a shift of a third of the image allows.
    pub fn depths(&self, rig: &Rig) -> Vec<Option<DepthMap>> {
        let cameras: Vec<CameraId> = rig.iter().map(|(id, _)| id).collect();
        cameras.par_iter().map(|id| self.depth(rig, *id)).collect()
    }

    /// That of one camera.
    pub fn depth(&self, rig: &Rig, camera: CameraId) -> Option<DepthMap> {
        let view = |id: CameraId| self.views.get(id.0)?.as_ref();
        let (first, second) = (view(camera)?, view(neighbour(rig, camera)?)?);
        let options = CorrelationOptions::default();
        // a pair that cannot be correlated has no depth
        depth_map(&first.grey, &second.grey, None, None, &options).ok()
    }
}

/// Disparities of a depth map from infinity: the larger, the nearer; NaN unknown.
pub(super) fn nearness(map: &DepthMap) -> Plane<f32> {
    let infinity = map.pair.left.camera.intrinsics.cx_px - map.pair.right.camera.intrinsics.cx_px;
    map.disparities.map(|d| (d - infinity as f32).abs())
}

/// The parts of the scene that do not move, by their nearness: what each pixel shows when nobody is before it.
///
/// Only for the very first fit, when no model says yet where the person is: nothing of the background's look is learned.
/// Where the depth of a pixel is unknown most of the time (a bare wall), its still scene counts as far away.
#[derive(Debug, Clone, PartialEq)]
pub struct StillScene {
    /// 0: far away.
    nearness: Plane<f32>,
}

/// What moves is nearer than the still scene by this disparity, px.
const NEARER_PX: f32 = 1.5;
/// Gaps in the known part of the still scene up to twice this are bridged, px: correlation has no answer for every pixel.
const BRIDGED_PX: usize = 20;
/// Edge of the cells by which points hang together, m.
const CELL_M: f64 = 0.1;
/// A cell of fewer points is stray.
const LEAST_IN_CELL: usize = 3;

impl StillScene {
    /// The still scene of one camera's depth maps, of frames spread over the recording.
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
                let nearness = maps.iter().filter_map(|m| m.get(x, y));
                seen.extend(nearness.map(|d| if d.is_finite() { d } else { 0.0 }));
                let middle = seen.len() / 2;
                *value = *seen.select_nth_unstable_by(middle, f32::total_cmp).1;
            }
        }
        Self {
            nearness: filled(&still),
        }
    }

    /// The nearness of a depth map, to be given to [`StillScene::of`].
    pub fn seen(map: &DepthMap) -> Plane<f32> {
        nearness(map)
    }

    /// The points of a depth map of the same camera that are before the still scene: the largest piece that hangs together.
    pub fn moving(&self, map: &DepthMap) -> Vec<CloudPoint> {
        let now = nearness(map);
        let pixels = now.values().iter().zip(self.nearness.values());
        // one point for each known disparity, in their order
        let known = pixels.filter(|(now, _)| now.is_finite());
        let moving = known
            .zip(&map.points)
            .filter(|((now, still), _)| **now > **still + NEARER_PX)
            .map(|(_, point)| *point);
        largest_piece(moving.collect())
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
    fn the_still_scene_is_what_is_seen_most_of_the_time() {
        let frame = |k: usize| {
            let values = (0..20).map(|x| if x / 4 == k { 40.0 } else { 20.0 });
            Plane::from_values(20, 1, values.collect()).unwrap()
        };
        let maps: Vec<_> = (0..5).map(frame).collect();
        let still = StillScene::of(&maps);
        assert!(
            still
                .nearness
                .values()
                .iter()
                .all(|d| (*d - 20.0).abs() < 1e-6)
        );
        assert_eq!(StillScene::of(&[]).nearness.values().len(), 0);
    }

    #[test]
    fn a_wall_whose_depth_is_unknown_most_of_the_time_is_far_away() {
        let map = |d: f32| Plane::filled(3, 1, d);
        let still = StillScene::of(&[map(40.0), map(f32::NAN), map(f32::NAN)]);
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
