//! Following points of the surface from frame to frame (PFD99 § 2.2).
//!
//! A [`Tracker`] begins with the matches of one frame. In each camera every point's place in the next frame is predicted
//! from its motion, searched for in a box by correlation, and found by least-squares matching with the point's image in the
//! frame before (`temporal.rs`). Least-squares matching across the cameras at that place must agree; if it does, the point
//! has moved to where the lines of sight meet. [`Tracker::finish`] gives the [`Trajectory`]s with velocity and
//! acceleration, and [`filter_trajectories`] removes the false ones (`filters.rs`).

mod filters;
mod temporal;
mod trajectory;

use nalgebra::{Point2, Point3};
use rayon::prelude::*;

use super::intersection::{Sighting, intersect};
use super::matching::{
    DepthPlane, MatchError, MatchOptions, MatchViews, MatchedPoint, Patch, PatchPixel,
    pixels_around, point_world,
};
use super::view::StereoView;
use super::{CloudPoint, Intersection, Spread};
use crate::image::Mask;

pub use filters::{FilterOptions, filter_trajectories};
use temporal::TemporalMatch;
pub use trajectory::{TrackPoint, Trajectory};

/// How points are followed.
#[derive(Debug, Clone, PartialEq)]
pub struct TrackOptions {
    /// A patch has (2·radius + 1)² pixels. 6: 13 × 13 (PFD99 § 2.1).
    pub radius_px: usize,
    /// The larger patch in time where that one fails. 9: 19 × 19.
    pub larger_radius_px: usize,
    /// How far the search box reaches from the predicted place on each side. 10.
    pub search_px: usize,
    /// The same in the first step, without a motion to predict from. 24.
    pub first_search_px: usize,
    /// Least correlation coefficient with the patch of the frame before. 0.6.
    pub least_correlation: f64,
    /// Largest standard deviation of the place by the normal matrix, px. 0.3.
    pub most_sigma_px: f64,
    /// Largest difference of a match in time from that across the cameras, px. 0.7.
    pub most_difference_px: f64,
    /// Matching across the cameras; its `least_images` is not used: all must show the point.
    pub spatial: MatchOptions,
}

impl Default for TrackOptions {
    fn default() -> Self {
        Self {
            radius_px: 6,
            larger_radius_px: 9,
            search_px: 10,
            first_search_px: 24,
            least_correlation: 0.6,
            most_sigma_px: 0.3,
            most_difference_px: 0.7,
            spatial: MatchOptions::default(),
        }
    }
}

/// The images of the cameras in one frame.
#[derive(Debug, Clone)]
pub struct FrameViews {
    /// The template's camera first.
    pub views: Vec<StereoView>,
    /// For each view the subject's pixels, where they are known.
    pub masks: Vec<Option<Mask>>,
}

/// A point that is followed.
#[derive(Debug, Clone)]
struct Track {
    /// Places in each view, in the last frame and in the one before.
    last: Vec<Point2<f64>>,
    before: Option<Vec<Point2<f64>>>,
    plane: DepthPlane,
    path: Vec<CloudPoint>,
    lost: bool,
}

/// Follows the points of one frame through those that come after it.
#[derive(Debug)]
pub struct Tracker {
    options: TrackOptions,
    first_frame: usize,
    /// The last frame.
    here: FrameViews,
    tracks: Vec<Track>,
}

impl Tracker {
    /// Begins with points matched in the first frame, whose first view was their template.
    ///
    /// # Errors
    /// [`MatchError`] for cameras in one place.
    pub fn start(
        first_frame: usize,
        here: FrameViews,
        points: &[MatchedPoint],
        options: TrackOptions,
    ) -> Result<Self, MatchError> {
        let views = match_views(&here)?;
        let tracks = points.iter().filter_map(|point| {
            let place = Point2::new(point.pixel.0 as f64, point.pixel.1 as f64);
            let others = views.places_in_others(&place, point.plane.w)?;
            Some(Track {
                last: std::iter::once(place).chain(others).collect(),
                before: None,
                plane: point.plane,
                path: vec![point.point],
                lost: false,
            })
        });
        let tracks = tracks.collect();
        drop(views);

        Ok(Self { options, first_frame, here, tracks })
    }

    /// How many points are still followed.
    pub fn followed(&self) -> usize {
        self.tracks.iter().filter(|track| !track.lost).count()
    }

    /// Where the points are that are still followed.
    pub fn positions(&self) -> impl Iterator<Item = Point3<f64>> {
        let followed = self.tracks.iter().filter(|track| !track.lost);
        followed.filter_map(|track| Some(track.path.last()?.position_world))
    }

    /// Goes on to the next frame; points that are not found there are lost.
    ///
    /// # Errors
    /// [`MatchError`] for cameras in one place, and another number of views than before.
    pub fn advance(&mut self, next: FrameViews) -> Result<(), MatchError> {
        if next.views.len() != self.here.views.len() {
            let beside = |frame: &FrameViews| frame.views.len().saturating_sub(1);
            let (expected, found) = (beside(&self.here), beside(&next));
            return Err(MatchError::Images { expected, found });
        }

        let step = FrameStep {
            here: &self.here,
            next: &next,
            match_views: match_views(&next)?,
            options: &self.options,
        };
        let followed = self.tracks.par_iter_mut().filter(|track| !track.lost);
        followed.for_each(|track| match step.advanced(track) {
            Some(moved) => *track = moved,
            None => track.lost = true,
        });
        drop(step);

        self.here = next;
        Ok(())
    }

    /// The trajectories of all points, in the order in which they were given; `fps` frames a second.
    pub fn finish(self, fps: f64) -> Vec<Trajectory> {
        let tracks = self.tracks.into_iter();
        tracks.map(|track| Trajectory::new(self.first_frame, &track.path, fps)).collect()
    }
}

fn match_views(frame: &FrameViews) -> Result<MatchViews<'_>, MatchError> {
    let views = frame.views.split_first();
    let Some((template, others)) = views.filter(|(_, others)| !others.is_empty()) else {
        return Err(MatchError::Images { expected: 1, found: 0 });
    };
    let mask = frame.masks.first().and_then(Option::as_ref);
    MatchViews::new(template, &others.iter().collect::<Vec<_>>(), mask)
}

/// One frame and the next, in whose views points are matched.
struct FrameStep<'a> {
    here: &'a FrameViews,
    next: &'a FrameViews,
    match_views: MatchViews<'a>,
    options: &'a TrackOptions,
}

impl FrameStep<'_> {
    /// The track one frame on; `None` if it is lost.
    fn advanced(&self, track: &Track) -> Option<Track> {
        // 1. temporal matching in each view
        let moved = (0..track.last.len()).map(|view| self.temporal(track, view));
        let moved: Vec<TemporalMatch> = moved.collect::<Option<_>>()?;

        // 2. spatial matching at the result
        let place = moved[0].pixel;
        let rough = self.intersect(&moved)?;
        let camera = &self.next.views[0].camera;
        let depth = (camera.camera_from_world * rough.position_world).z;
        let plane = DepthPlane { w: 1.0 / depth, ..track.plane };
        let patch = Patch::around(&self.match_views, place, self.options.radius_px);
        let spatial = &self.options.spatial;
        let found = self.match_views.find_patch(&patch, &plane, spatial)?;

        // 3. both must agree
        let others = self.match_views.places_in_others(&place, found.plane.w)?;
        let pairs = others.iter().zip(&moved[1..]);
        let differences = pairs.map(|(spatial, temporal)| (spatial - temporal.pixel).norm());
        if differences.fold(0.0, f64::max) > self.options.most_difference_px {
            return None;
        }

        // 4. forward intersection
        let mut path = track.path.clone();
        path.push(CloudPoint {
            position_world: point_world(camera, &place, found.plane.w),
            spread: Spread::Full(rough.covariance),
        });
        Some(Track {
            last: std::iter::once(place).chain(others).collect(),
            before: Some(track.last.clone()),
            plane: found.plane,
            path,
            lost: false,
        })
    }

    /// Where the point is in the next image of a view, by its patch or, where that fails, by a larger one.
    fn temporal(&self, track: &Track, view: usize) -> Option<TemporalMatch> {
        let options = self.options;
        let radii = [options.radius_px, options.larger_radius_px];
        let mut found = radii.iter().filter_map(|radius| self.temporal_with(track, view, *radius));
        found.find(|moved| {
            moved.correlation >= options.least_correlation
                && moved.sigma_px <= options.most_sigma_px
        })
    }

    /// The same with the patch of one radius.
    fn temporal_with(&self, track: &Track, view: usize, radius: usize) -> Option<TemporalMatch> {
        let place = track.last[view];
        let patch = self.patch(view, place, radius)?;
        let (expected, reach) = match &track.before {
            Some(before) => (place + (place - before[view]), self.options.search_px),
            None => (place, self.options.first_search_px),
        };
        let image = &self.next.views[view].image;
        let start = temporal::search(&patch, image, &expected, reach)?;
        temporal::fit(&patch, image, &start)
    }

    /// The patch around a place in this frame; `None` unless more than half of it shows the subject.
    fn patch(&self, view: usize, place: Point2<f64>, radius: usize) -> Option<Vec<PatchPixel>> {
        let mask = self.here.masks.get(view).and_then(Option::as_ref);
        let pixels = pixels_around(&self.here.views[view].image, mask, place, radius);
        (2 * pixels.len() > (2 * radius + 1).pow(2)).then_some(pixels)
    }

    /// Where the lines of sight of the places in all views meet.
    fn intersect(&self, moved: &[TemporalMatch]) -> Option<Intersection> {
        let model = self.options.spatial.model_sigma_px;
        let views = self.next.views.iter().zip(moved);
        let sightings = views.map(|(view, moved)| Sighting {
            camera: &view.camera,
            pixel: moved.pixel,
            sigma_px: moved.sigma_px.hypot(model),
        });
        intersect(&sightings.collect::<Vec<_>>())
    }
}
