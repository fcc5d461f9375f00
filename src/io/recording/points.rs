//! The point clouds of a recording.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use nalgebra::{Point3, Vector3};

use super::{Note, RecordingError};
use crate::camera::{Camera, Rig};
use crate::io::points::{self, is_cloud};
use crate::io::recording::layout::numbered_files::{self, Wanted};
use crate::io::recording::manifest::Manifest;
use crate::math::Rigid3;
use crate::math::stats::median;
use crate::pipeline::Frames;
use crate::silhouette::{FrameIndex, FrameObservations};
use crate::stereo::Cloud;

/// Most points used in one frame; a larger cloud is thinned evenly.
pub const MOST_POINTS: usize = 5000;

/// Where points are looked for when the manifest names no place.
const FOLDER: &str = "points";
/// Least distance that cameras count as having from what they see, metres: cameras in one place would give no scale.
const NEAREST_CAMERAS: f64 = 1.0;
/// Points farther from the middle of the view than this many times the cameras' distance cannot be the person.
const FARTHEST: f64 = 20.0;
/// A cloud smaller than this fraction of the cameras' distance cannot be a body.
const SMALLEST: f64 = 1e-3;
/// Fewer points have no size.
const LEAST_FOR_SIZE: usize = 20;

/// Where the cameras look, and from how far.
#[derive(Debug, Clone, Copy, PartialEq)]
struct CommonView {
    middle_world: Point3<f64>,
    /// Mean distance of the cameras, metres.
    cameras_m: f64,
}

impl CommonView {
    fn new(rig: &Rig) -> Option<Self> {
        let middle_world = rig.common_view()?.point_world;
        let distance = |camera: &Camera| (camera.centre_world() - middle_world).norm();
        let sum: f64 = rig.cameras.iter().map(distance).sum();
        Some(Self {
            middle_world,
            cameras_m: (sum / rig.cameras.len() as f64).max(NEAREST_CAMERAS),
        })
    }

    /// Medians, so that strays do not count.
    fn check(&self, cloud: &Cloud, path: &Path, frame: FrameIndex) -> Result<(), RecordingError> {
        let places = || cloud.points.iter().map(|p| p.position_world);
        let from =
            |middle: Point3<f64>| median(&mut places().map(|p| (p - middle).norm()).collect());
        let (path, cameras_m) = (path.to_owned(), self.cameras_m);

        match from(self.middle_world) {
            Some(distance_m) if distance_m > FARTHEST * cameras_m => {
                return Err(RecordingError::PointsFar { path, frame, distance_m, cameras_m });
            }
            _ => {}
        }

        let middle = |axis: usize| median(&mut places().map(|p| p[axis]).collect()).unwrap_or(0.0);
        let middle = Point3::from(Vector3::from_fn(|axis, _| middle(axis)));
        match from(middle) {
            Some(distance_m)
                if distance_m < SMALLEST * cameras_m && cloud.points.len() >= LEAST_FOR_SIZE =>
            {
                Err(RecordingError::PointsTogether { path, frame, distance_m, cameras_m })
            }
            _ => Ok(()),
        }
    }
}

/// The clouds of a recording: which frames have one, and how their numbers become metres of the world.
#[derive(Debug, Clone, Default)]
pub(super) struct PointFiles {
    of_frame: BTreeMap<FrameIndex, PathBuf>,
    in_metres: f64,
    world_from_file: Rigid3,
    view: Option<CommonView>,
}

impl PointFiles {
    /// Whether a recording has points, or its manifest names some.
    pub(super) fn are_promised(folder: &Path, manifest: &Manifest) -> bool {
        pattern(folder, manifest).is_some()
    }

    /// The clouds that the manifest names, else those in the folder `points`, if there is one.
    pub(super) fn find(
        folder: &Path,
        manifest: &Manifest,
        rig: &Rig,
        notes: &mut Vec<Note>,
    ) -> Result<Self, RecordingError> {
        let pattern = pattern(folder, manifest);
        let wanted = Wanted { key: "points", is_kind: is_cloud };
        let files = pattern.map(|pattern| numbered_files::list(folder, pattern, &wanted));
        let files = files.transpose()?.unwrap_or_default();

        if let (Some(pattern), true) = (&manifest.points, files.of_number.is_empty()) {
            let pattern = folder.join(pattern);
            return Err(RecordingError::MissingPoints { pattern });
        }
        if files.unnumbered > 0 {
            let files = files.unnumbered;
            notes.push(Note::UnnumberedPoints { files });
        }

        let frame = |number: u64| Some(FrameIndex(usize::try_from(number).ok()?));
        let numbered = files.of_number.into_iter();
        let of_frame: BTreeMap<_, _> =
            numbered.filter_map(|(number, path)| Some((frame(number)?, path))).collect();

        Ok(Self {
            in_metres: manifest.points_unit.map_or(1.0, |unit| unit.in_metres()),
            world_from_file: manifest.up.world_from_file(),
            view: (!of_frame.is_empty()).then(|| CommonView::new(rig)).flatten(),
            of_frame,
        })
    }

    /// The frames that have a cloud, ascending.
    pub(super) fn frames(&self) -> impl Iterator<Item = FrameIndex> {
        self.of_frame.keys().copied()
    }

    /// The clouds, in the order of the frames.
    pub(super) fn paths(&self) -> impl Iterator<Item = &PathBuf> {
        self.of_frame.values()
    }

    /// A note if only some of the frames have points.
    pub(super) fn missing(&self, frames: usize) -> Option<Note> {
        let with = self.of_frame.len();
        (0 < with && with < frames).then_some(Note::PointsMissing { with, frames })
    }

    /// The cloud of a frame, in metres of the world; empty if it has none.
    pub(super) fn load(&self, frame: FrameIndex) -> Result<Cloud, RecordingError> {
        let Some(path) = self.of_frame.get(&frame) else {
            return Ok(Cloud::default());
        };
        let cloud = points::read(path)
            .map_err(|source| RecordingError::Cloud { frame, source: Box::new(source) })?;

        let cloud = cloud.scaled(self.in_metres).moved(&self.world_from_file).thinned(MOST_POINTS);

        if let Some(view) = &self.view {
            view.check(&cloud, path, frame)?;
        }
        Ok(cloud)
    }

    /// Notes on the points of the frames that were loaded.
    pub(super) fn notes(&self, observations: &[FrameObservations]) -> Vec<Note> {
        let those = |is: &dyn Fn(&&FrameObservations) -> bool| {
            let which = observations.iter().filter(is).map(|o| o.frame);
            Some(Frames(which.collect())).filter(|frames| !frames.0.is_empty())
        };
        let empty = those(&|o| self.of_frame.contains_key(&o.frame) && o.points.is_empty());
        let unusable = those(&|o| o.points_left_out.unusable > 0);
        let thinned = those(&|o| o.points_left_out.thinned > 0);
        let points = observations.iter().map(|o| o.points_left_out.unusable);
        let points = points.sum();
        let most = observations.iter().map(|o| {
            // unusable points were never candidates
            o.points_left_out.thinned + o.points.len()
        });
        let most_points = most.max().unwrap_or(0);
        let empty = empty.map(|frames| Note::PointsEmpty { frames });
        let unusable = unusable.map(|frames| Note::PointsUnusable { points, frames });
        let thinned =
            thinned.map(|frames| Note::PointsThinned { most_points, used: MOST_POINTS, frames });
        [empty, unusable, thinned].into_iter().flatten().collect()
    }
}

/// The manifest's pattern, or the folder `points`, if there is one.
fn pattern<'m>(folder: &Path, manifest: &'m Manifest) -> Option<&'m str> {
    match &manifest.points {
        Some(pattern) => Some(pattern.as_str()),
        None => folder.join(FOLDER).is_dir().then_some(FOLDER),
    }
}
