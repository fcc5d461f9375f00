//! What the cameras show in one frame, without their lenses, and how far away it is.

use rayon::prelude::*;

use super::cluster::largest;
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
#[derive(Debug, Clone, PartialEq)]
pub struct StillScene {
    nearness: Plane<f32>,
}

/// Of the nearnesses of a pixel this quantile is the still scene's: a person covers it less than so often.
const STILL: f64 = 0.15;
/// What moves is nearer than the still scene by this disparity, px.
const NEARER_PX: f32 = 1.5;
/// Pixels with fewer known nearnesses show no still scene.
const LEAST_KNOWN: usize = 3;

impl StillScene {
    /// The still scene of one camera's depth maps, of frames spread over the recording.
    pub fn of(maps: &[Plane<f32>]) -> Self {
        let Some(first) = maps.first() else {
            return Self {
                nearness: Plane::filled(0, 0, f32::NAN),
            };
        };
        let mut still = Plane::filled(first.width(), first.height(), f32::NAN);
        let mut known = Vec::with_capacity(maps.len());
        for y in 0..first.height() {
            for (x, value) in still.row_mut(y).iter_mut().enumerate() {
                known.clear();
                known.extend(
                    maps.iter()
                        .filter_map(|m| m.get(x, y))
                        .filter(|v| v.is_finite()),
                );
                if known.len() >= LEAST_KNOWN {
                    known.sort_by(f32::total_cmp);
                    *value = known[(STILL * (known.len() - 1) as f64) as usize];
                }
            }
        }
        Self { nearness: still }
    }

    /// The nearness of a depth map, to be given to [`StillScene::of`].
    pub fn seen(map: &DepthMap) -> Plane<f32> {
        nearness(map)
    }

    /// The points of a depth map of the same camera that are before the still scene, of the largest thing that is.
    pub fn moving(&self, map: &DepthMap) -> Vec<CloudPoint> {
        let now = nearness(map);
        let pixels = now.values().iter().zip(self.nearness.values());
        // one point for each known disparity, in their order
        let known = pixels.filter(|(now, _)| now.is_finite());
        let before = known
            .zip(&map.points)
            .filter(|((now, still), _)| **now > **still + NEARER_PX)
            .map(|(_, point)| *point);
        largest(before.collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_still_scene_is_what_is_farthest_most_of_the_time() {
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
        assert!(
            StillScene::of(&maps[..2])
                .nearness
                .values()
                .iter()
                .all(|d| d.is_nan())
        );
    }
}
