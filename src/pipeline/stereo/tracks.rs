//! Points of the surface followed from frame to frame.

use super::StereoError;
use crate::stereo::StereoView;
use crate::stereo::matching::{MatchOptions, MatchedPoint};
use crate::stereo::tracking::{
    FilterOptions, FrameViews, TrackOptions, Tracker, Trajectory, filter_trajectories,
};

/// Frames through which a set of points is followed, before a new one begins.
const TRACKED_FRAMES: usize = 10;

/// Points that were followed together.
#[derive(Debug, Clone)]
pub struct SurfaceTracks {
    /// Number of the frame in which they began.
    pub first_frame: usize,
    /// What the template's camera showed then.
    pub first_view: StereoView,
    /// Their paths, without the false ones.
    pub trajectories: Vec<Trajectory>,
}

/// Follows points through ten frames at a time.
pub(super) struct Tracking {
    matching: MatchOptions,
    fps: f64,
    followed: Option<FollowedPoints>,
}

/// The points that are followed now.
struct FollowedPoints {
    tracker: Tracker,
    first_frame: usize,
    first_view: StereoView,
    last_frame: usize,
}

impl FollowedPoints {
    /// Whether they have come as far as a frame, and are followed on from there.
    fn go_on_from(&self, frame: usize) -> bool {
        self.last_frame == frame && self.first_frame + TRACKED_FRAMES > frame
    }
}

impl Tracking {
    pub(super) fn new(matching: MatchOptions, fps: f64) -> Self {
        Self { matching, fps, followed: None }
    }

    /// Follows the points into a frame; every tenth frame, and a frame left out, ends the tracks and begins new ones.
    pub(super) fn follow(
        &mut self,
        frame: usize,
        views: FrameViews,
        points: &[MatchedPoint],
    ) -> Result<Option<SurfaceTracks>, StereoError> {
        if let Some(followed) = &mut self.followed
            && followed.last_frame + 1 == frame
        {
            followed.tracker.advance(views.clone())?;
            followed.last_frame = frame;
        }
        if self.followed.as_ref().is_some_and(|f| f.go_on_from(frame)) {
            return Ok(None);
        }

        let ended = self.end();
        let options = TrackOptions { spatial: self.matching.clone(), ..TrackOptions::default() };
        let first_view = views.views[0].clone();
        self.followed = Some(FollowedPoints {
            tracker: Tracker::start(frame, views, points, options)?,
            first_frame: frame,
            first_view,
            last_frame: frame,
        });
        Ok(ended)
    }

    /// Ends the tracks and takes the false ones away; `None` where nothing is followed.
    pub(super) fn end(&mut self) -> Option<SurfaceTracks> {
        let followed = self.followed.take()?;
        let all = followed.tracker.finish(self.fps);
        let true_ones = filter_trajectories(&all, &FilterOptions::default()).into_iter();
        Some(SurfaceTracks {
            first_frame: followed.first_frame,
            first_view: followed.first_view,
            trajectories: true_ones.map(|(_, trajectory)| trajectory).collect(),
        })
    }
}
