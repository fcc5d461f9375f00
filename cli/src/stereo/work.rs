//! The frames of a run, one after another.

use super::{Measured, Method, Settings, TRACKED_FRAMES};
use crate::error::CliError;
use crate::summary::counted;
use maquette::camera::CameraId;
use maquette::image::{Mask, Picture, Plane, luma};
use maquette::io::folder::stereo::{MeasuredFrame, StereoFolder};
use maquette::io::recording::ObservationFiles;
use maquette::io::recording::footage::Footage;
use maquette::render::stereo::{cloud_from_the_side, in_colour, vector_field};
use maquette::silhouette::FrameIndex;
use maquette::stereo::correlation::CorrelationOptions;
use maquette::stereo::matching::{MatchError, MatchOptions, MatchedPoint, match_surface};
use maquette::stereo::tracking::{
    FilterOptions, FrameViews, TrackOptions, Tracker, Trajectory, filter_trajectories,
};
use maquette::stereo::{CloudPoint, StereoView, depth_map};

/// The points that are followed.
pub(super) struct Following {
    tracker: Tracker,
    first: usize,
    last: usize,
    /// What the template's camera showed first.
    view: StereoView,
}

/// A run.
pub(super) struct Work<'a> {
    pub(super) settings: &'a Settings,
    pub(super) footage: &'a Footage,
    /// The template's camera first.
    pub(super) cameras: Vec<CameraId>,
    pub(super) masks: Option<&'a ObservationFiles>,
    pub(super) out: StereoFolder,
    pub(super) following: Option<Following>,
    pub(super) trajectories: Vec<Trajectory>,
    /// The frames so far.
    pub(super) frames: Vec<MeasuredFrame>,
}

impl Work<'_> {
    pub(super) fn frame(
        &mut self,
        frame: FrameIndex,
        pictures: &[Option<Picture>],
    ) -> Result<(), CliError> {
        let (points, reason) = match self.shown(frame, pictures) {
            Ok(shown) => {
                let points = match self.settings.method {
                    Method::Correlation => self.correlate(frame.0, &shown)?,
                    Method::Matching => self.match_all(frame.0, shown)?,
                };
                let nothing = "nothing was matched: no texture, or the cameras do not see the same";
                (
                    points,
                    if points == 0 {
                        nothing.into()
                    } else {
                        String::new()
                    },
                )
            }
            Err(reason) => {
                self.end_tracks()?;
                (0, reason)
            }
        };
        self.frames.push(MeasuredFrame {
            frame: frame.0,
            points,
            reason,
        });
        Ok(())
    }

    /// The views and masks of the cameras used; why not, where a picture is missing.
    fn shown(&self, frame: FrameIndex, pictures: &[Option<Picture>]) -> Result<FrameViews, String> {
        let mut shown = FrameViews {
            views: Vec::new(),
            masks: Vec::new(),
        };
        for id in &self.cameras {
            let picture = pictures.get(id.0).and_then(Option::as_ref);
            let (Some(picture), Some(camera)) = (picture, self.footage.rig.camera(*id)) else {
                return Err("a camera has no picture".into());
            };
            shown
                .views
                .push(StereoView::undistorted(camera, &luma(picture)).map_err(|e| e.to_string())?);
            shown.masks.push(self.mask(&camera.name, frame)?);
        }
        Ok(shown)
    }

    /// The camera's mask, where it has masks; a frame of which the template has none is not measured.
    fn mask(&self, camera: &str, frame: FrameIndex) -> Result<Option<Mask>, String> {
        let Some(recording) = self.masks else {
            return Ok(None);
        };
        let Some((id, _)) = recording.rig.by_name(camera) else {
            return Ok(None);
        };
        let mask = recording.load_mask(id, frame).map_err(|e| e.to_string())?;
        let is_template =
            self.footage.rig.by_name(camera).map(|(id, _)| id) == self.cameras.first().copied();
        match mask {
            None if is_template => Err(format!("camera {camera} has no mask of it")),
            mask => Ok(mask),
        }
    }

    /// Every pair of the template and another camera.
    fn correlate(&mut self, frame: usize, shown: &FrameViews) -> Result<usize, CliError> {
        let mut points = Vec::new();
        for (i, other) in shown.views[1..].iter().enumerate() {
            let (template, mask) = (&shown.views[0], shown.masks[0].as_ref());
            let map = depth_map(
                template,
                other,
                mask,
                self.settings.depth,
                &CorrelationOptions::default(),
            );
            let map = map.map_err(|e| CliError::Stereo(e.to_string()))?;
            let infinity =
                map.pair.left.camera.intrinsics.cx_px - map.pair.right.camera.intrinsics.cx_px;
            let disparities = map.disparities.map(|d| (d - infinity as f32).abs());
            let name = format!("{frame:06}_{}", i + 1);
            self.out.disparity(&name, &disparities)?;
            if self.settings.pictures {
                self.out
                    .picture(&format!("disparity_{name}"), &in_colour(&disparities))?;
            }
            points.extend(map.points);
        }
        self.write_points(frame, &shown.views[0], &points)?;
        Ok(points.len())
    }

    /// The template in all other images.
    fn match_all(&mut self, frame: usize, shown: FrameViews) -> Result<usize, CliError> {
        let options = self.options();
        let (template, others) = (&shown.views[0], shown.views[1..].iter().collect::<Vec<_>>());
        let found = match_surface(template, &others, shown.masks[0].as_ref(), &[], &options);
        let found = found.map_err(|e| CliError::Stereo(e.to_string()))?;
        let disparities = disparities(template, others[0], &found.points);
        self.out.disparity(&format!("{frame:06}"), &disparities)?;
        if self.settings.pictures {
            self.out
                .picture(&format!("disparity_{frame:06}"), &in_colour(&disparities))?;
        }
        let points: Vec<CloudPoint> = found.points.iter().map(|point| point.point).collect();
        self.write_points(frame, template, &points)?;
        if self.settings.tracks {
            self.follow(frame, shown, &found.points)?;
        }
        Ok(points.len())
    }

    fn options(&self) -> MatchOptions {
        MatchOptions {
            spacing_px: self.settings.spacing,
            least_images: self
                .settings
                .least_cameras
                .unwrap_or(self.cameras.len() - 1),
            depth: self.settings.depth,
            ..MatchOptions::default()
        }
    }

    fn write_points(
        &self,
        frame: usize,
        template: &StereoView,
        points: &[CloudPoint],
    ) -> Result<(), CliError> {
        self.out.points(frame, points)?;
        if self.settings.pictures {
            let cloud = cloud_from_the_side(&template.camera, points);
            self.out.picture(&format!("cloud_{frame:06}"), &cloud)?;
        }
        Ok(())
    }

    /// Follows the points into this frame; every tenth frame ends the tracks and begins new ones.
    fn follow(
        &mut self,
        frame: usize,
        shown: FrameViews,
        points: &[MatchedPoint],
    ) -> Result<(), CliError> {
        let fault = |e: MatchError| CliError::Stereo(e.to_string());
        if let Some(following) = self.following.as_mut().filter(|f| f.last + 1 == frame) {
            following.tracker.advance(shown.clone()).map_err(fault)?;
            following.last = frame;
        }
        let goes_on = |f: &Following| f.last == frame && f.first + TRACKED_FRAMES > frame;
        if !self.following.as_ref().is_some_and(goes_on) {
            self.end_tracks()?;
            let options = TrackOptions {
                spatial: self.options(),
                ..TrackOptions::default()
            };
            let view = shown.views[0].clone();
            let tracker = Tracker::start(frame, shown, points, options).map_err(fault)?;
            self.following = Some(Following {
                tracker,
                first: frame,
                last: frame,
                view,
            });
        }
        Ok(())
    }

    /// Filters the trajectories that were followed, and keeps them.
    fn end_tracks(&mut self) -> Result<(), CliError> {
        let Some(Following {
            tracker,
            first,
            view,
            ..
        }) = self.following.take()
        else {
            return Ok(());
        };
        let filtered =
            filter_trajectories(&tracker.finish(self.footage.fps), &FilterOptions::default());
        if self.settings.pictures {
            let points: Vec<_> = filtered
                .trajectories
                .iter()
                .filter_map(|t| t.at(first + 1).copied())
                .collect();
            self.out.picture(
                &format!("vectors_{first:06}"),
                &vector_field(&view.camera, &view.image, &points),
            )?;
        }
        self.trajectories.extend(filtered.trajectories);
        Ok(())
    }

    /// Writes what is written in the end.
    pub(super) fn finish(mut self) -> Result<Measured, CliError> {
        self.end_tracks()?;
        if self.settings.tracks {
            self.out.trajectories(&self.trajectories)?;
        }
        self.out.table(&self.frames)?;
        Ok(Measured {
            notes: self.without_points().into_iter().collect(),
            trajectories: self.settings.tracks.then_some(self.trajectories.len()),
            frames: self.frames,
        })
    }

    fn without_points(&self) -> Option<String> {
        let mut without = self.frames.iter().filter(|frame| frame.points == 0);
        let MeasuredFrame { frame, reason, .. } = without.next()?;
        let count = counted(1 + without.count(), "frame");
        Some(format!(
            "{count} without points, frame {frame} first: {reason}"
        ))
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
