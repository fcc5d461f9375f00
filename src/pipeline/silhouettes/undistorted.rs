//! What the cameras show in one frame, without the distortion of their lenses, and how far away it is.

use rayon::prelude::*;

use crate::camera::{CameraId, Rig};
use crate::image::{Picture, Plane, luma};
use crate::stereo::correlation::CorrelationOptions;
use crate::stereo::{DepthMap, StereoView, StereoViewError, depth_map, neighbour};

/// One camera's picture as its ideal camera would show it.
#[derive(Debug, Clone)]
pub struct UndistortedView {
    /// Brightness, and the camera without its lens.
    pub grey: StereoView,
    /// Red, green and blue; NaN where the recorded picture shows nothing.
    pub colours: Vec<Plane<f32>>,
}

/// The pictures of one frame, in the order of the rig; `None` for a camera that has none.
#[derive(Debug, Clone)]
pub struct UndistortedFrame {
    /// View by view.
    pub views: Vec<Option<UndistortedView>>,
}

impl UndistortedFrame {
    /// Takes the lenses off the pictures of a frame.
    ///
    /// # Errors
    /// [`StereoViewError`] for a picture of another size than its camera's.
    pub fn new(rig: &Rig, pictures: &[Option<Picture>]) -> Result<Self, StereoViewError> {
        let cameras = rig.cameras.par_iter().enumerate();
        let views = cameras.map(|(i, camera)| {
            let Some(picture) = pictures.get(i).and_then(Option::as_ref) else {
                return Ok(None);
            };
            let channel = |c: usize| StereoView::undistorted(camera, &picture.map(|rgb| rgb[c]));
            let colours = (0..3).map(|c| Ok(channel(c)?.image)).collect::<Result<_, _>>()?;
            Ok(Some(UndistortedView {
                grey: StereoView::undistorted(camera, &luma(picture))?,
                colours,
            }))
        });
        Ok(Self { views: views.collect::<Result<_, _>>()? })
    }

    /// The depths that a camera sees, by correlation with the camera beside it; `None` without such a camera or its picture.
    ///
    /// They lie between a least and a greatest depth, m; without these, in all that a shift of a third of the image allows.
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

    /// The depths that each camera sees that has another beside it, from the nearest possible to infinity.
    pub fn depths(&self, rig: &Rig) -> Vec<(CameraId, DepthMap)> {
        let cameras = (0..rig.cameras.len()).into_par_iter().map(CameraId);
        cameras.filter_map(|camera| Some((camera, self.depth(rig, camera, None)?))).collect()
    }
}
