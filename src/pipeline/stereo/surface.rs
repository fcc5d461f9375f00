//! What one frame shows of the surface.

use super::tracks::{SurfaceTracks, Tracking};
use super::views::StereoCameras;
use super::{StereoError, StereoMethod, StereoOptions};
use crate::image::{Picture, Plane};
use crate::pipeline::silhouettes::nearness;
use crate::pipeline::{MaskSource, PictureSource};
use crate::silhouette::FrameIndex;
use crate::stereo::correlation::CorrelationOptions;
use crate::stereo::matching::{MatchedPoint, MatchedSurface, match_surface};
use crate::stereo::tracking::FrameViews;
use crate::stereo::{CloudPoint, StereoView, depth_map};

/// What one frame shows of the surface.
#[derive(Debug, Clone)]
pub struct SurfaceFrame {
    /// Which frame.
    pub frame: FrameIndex,
    /// What was measured; `None` where a picture or the template's mask is missing.
    pub surface: Option<MeasuredSurface>,
    /// Why there are no points; empty where there are.
    pub reason: String,
    /// Tracks that ended before or with this frame.
    pub ended_tracks: Vec<SurfaceTracks>,
}

/// The surface as it was measured in one frame.
#[derive(Debug, Clone)]
pub struct MeasuredSurface {
    /// What the template's camera shows, without its lens.
    pub template: StereoView,
    /// How near things are, of each pair that was correlated, or of all cameras together.
    pub disparities: Vec<DisparityMap>,
    /// Places with their covariance.
    pub points: Vec<CloudPoint>,
}

/// Disparities against infinity, px: the larger, the nearer.
#[derive(Debug, Clone)]
pub struct DisparityMap {
    /// Which of the other cameras was correlated with the template's, from 1; `None` of all together.
    pub pair: Option<usize>,
    /// NaN where not known.
    pub disparities_px: Plane<f32>,
}

impl MeasuredSurface {
    /// The surface by matching the template in all other images at once.
    fn from_matches(frame: &FrameViews, found: &MatchedSurface) -> Self {
        let [template, other] = [&frame.views[0], &frame.views[1]];
        let disparities_px = disparities(template, other, &found.points);
        Self {
            template: template.clone(),
            disparities: vec![DisparityMap { pair: None, disparities_px }],
            points: found.points.iter().map(|point| point.point).collect(),
        }
    }
}

impl SurfaceFrame {
    /// The points; none where nothing was measured.
    pub fn points(&self) -> &[CloudPoint] {
        self.surface.as_ref().map_or(&[], |surface| &surface.points)
    }
}

/// A measurement of frames, one after another.
pub(super) struct Measurement<'a> {
    cameras: StereoCameras<'a>,
    options: &'a StereoOptions,
    tracking: Tracking,
}

impl<'a> Measurement<'a> {
    pub(super) fn new(
        pictures: &'a dyn PictureSource,
        masks: Option<&'a dyn MaskSource>,
        options: &'a StereoOptions,
    ) -> Result<Self, StereoError> {
        let ids = options.choose_cameras(pictures.rig())?;
        let matching = options.matching(ids.len() - 1);
        Ok(Self {
            tracking: Tracking::new(matching, pictures.fps()),
            cameras: StereoCameras { pictures, masks, ids },
            options,
        })
    }

    /// Measures the next frame.
    pub(super) fn measure(
        &mut self,
        frame: FrameIndex,
        pictures: &[Option<Picture>],
    ) -> Result<SurfaceFrame, StereoError> {
        let mut measured =
            SurfaceFrame { frame, surface: None, reason: String::new(), ended_tracks: Vec::new() };
        let views = match self.cameras.views(frame, pictures) {
            Ok(views) => views,
            Err(reason) => {
                measured.reason = reason;
                measured.ended_tracks.extend(self.tracking.end());
                return Ok(measured);
            }
        };

        let surface = match self.options.method {
            StereoMethod::Correlation => self.correlate(&views)?,
            StereoMethod::Matching => {
                let found = self.match_all(&views)?;
                let surface = MeasuredSurface::from_matches(&views, &found);
                if self.options.tracks {
                    let ended = self.tracking.follow(frame.0, views, &found.points)?;
                    measured.ended_tracks.extend(ended);
                }
                surface
            }
        };
        if surface.points.is_empty() {
            let nothing = "nothing was matched: no texture, or the cameras do not see the same";
            measured.reason = nothing.into();
        }
        measured.surface = Some(surface);
        Ok(measured)
    }

    /// Every pair of the template and another camera.
    fn correlate(&self, frame: &FrameViews) -> Result<MeasuredSurface, StereoError> {
        let (template, mask) = (&frame.views[0], frame.masks[0].as_ref());
        let mut surface = MeasuredSurface {
            template: template.clone(),
            disparities: Vec::new(),
            points: Vec::new(),
        };
        for (i, other) in frame.views[1..].iter().enumerate() {
            let options = CorrelationOptions::default();
            let map = depth_map(template, other, mask, self.options.depth_m, &options)?;
            surface
                .disparities
                .push(DisparityMap { pair: Some(i + 1), disparities_px: nearness(&map) });
            surface.points.extend(map.points);
        }
        Ok(surface)
    }

    /// The template in all other images.
    fn match_all(&self, frame: &FrameViews) -> Result<MatchedSurface, StereoError> {
        let (template, mask) = (&frame.views[0], frame.masks[0].as_ref());
        let others: Vec<&StereoView> = frame.views[1..].iter().collect();
        let options = self.options.matching(others.len());
        Ok(match_surface(template, &others, mask, &[], &options)?)
    }

    /// The tracks that are still followed.
    pub(super) fn end_tracks(&mut self) -> Option<SurfaceTracks> {
        self.tracking.end()
    }
}

/// The shift of each point against one at infinity, as a pair side by side would show it: f·B/Z, px.
fn disparities(template: &StereoView, other: &StereoView, points: &[MatchedPoint]) -> Plane<f32> {
    let camera = &template.camera;
    let base =
        (camera.centre_world() - other.camera.centre_world()).norm() * camera.intrinsics.fx_px;

    let mut plane = Plane::filled(template.image.width(), template.image.height(), f32::NAN);
    for point in points {
        let depth = (camera.camera_from_world * point.point.position_world).z;
        let (x, y) = point.pixel;
        if let Some(disparity) = plane.row_mut(y).get_mut(x) {
            *disparity = (base / depth) as f32;
        }
    }
    plane
}
