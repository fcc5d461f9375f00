//! Why a recording could not be used.

use std::io;
use std::path::PathBuf;

use super::MaskFault;
use super::footage::FootageError;
use crate::io::calibration::CalibrationError;
use crate::io::frame_rate;
use crate::io::points::CloudError;
use crate::silhouette::FrameIndex;

/// Why a recording could not be used, in one line that says what to mend.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RecordingError {
    /// Neither a folder nor a manifest.
    #[error("{}: no such folder or file", path.display())]
    NotFound {
        /// As given.
        path: PathBuf,
    },
    /// A folder that cannot be listed.
    #[error("{}: the folder cannot be read: {source}", path.display())]
    Folder {
        /// The folder.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// The manifest, or an input whose checksum is wanted, cannot be read.
    #[error("{}: cannot be read: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// A manifest that is not TOML, or a value of the wrong kind.
    #[error("{}:{line}: {}", path.display(), source.message().replace('\n', ", "))]
    Syntax {
        /// The manifest.
        path: PathBuf,
        /// From 1.
        line: usize,
        /// What the parser expected.
        source: Box<toml::de::Error>,
    },
    /// A key of the manifest that means nothing.
    #[error(
        "{}:{line}: unknown key {key:?}; did you mean {nearest:?}? (known here: {})",
        path.display(), known.join(", ")
    )]
    UnknownKey {
        /// The manifest.
        path: PathBuf,
        /// From 1.
        line: usize,
        /// The key.
        key: String,
        /// The known key that looks most like it.
        nearest: &'static str,
        /// All keys known there.
        known: &'static [&'static str],
    },
    /// Two cameras of the same name.
    #[error("{}: camera {name:?} is listed {count} times: names must differ", path.display())]
    DuplicateCamera {
        /// The manifest.
        path: PathBuf,
        /// The name.
        name: String,
        /// How often it occurs.
        count: usize,
    },
    /// No frame rate anywhere.
    #[error(
        "{}: the frame rate is not known: give --fps, or fps = … in sequence.toml", path.display()
    )]
    NoFps {
        /// The recording.
        path: PathBuf,
    },
    /// A given frame rate that no camera has.
    #[error("frame rate {fps}: expected {}", frame_rate::EXPECTED)]
    Fps {
        /// As given.
        fps: f64,
    },
    /// A frame rate of the manifest that no camera has.
    #[error("{}:{line}: fps = {fps}: expected {}", path.display(), frame_rate::EXPECTED)]
    ManifestFps {
        /// The manifest.
        path: PathBuf,
        /// From 1.
        line: usize,
        /// As written.
        fps: f64,
    },
    /// A beginning of the manifest that no camera has.
    #[error("{}: camera {camera}: {key} = {value}: expected a number from −1e10 to 1e10", path.display())]
    Clock {
        /// The manifest.
        path: PathBuf,
        /// The camera.
        camera: String,
        /// Which.
        key: &'static str,
        /// As written.
        value: f64,
    },
    /// Offsets that were found at another frame rate.
    #[error(
        "{}: found at {found} frames per second, and the recording is read at {fps}: find them again with maquette sync, or delete the file",
        path.display()
    )]
    OffsetsFps {
        /// `offsets.toml`.
        path: PathBuf,
        /// At which they were found.
        found: f64,
        /// That of the recording.
        fps: f64,
    },
    /// A pattern that is none.
    #[error("{key} = {pattern:?}: expected {expected}")]
    Pattern {
        /// Whose: `camera left: masks` or `points`.
        key: String,
        /// As written.
        pattern: String,
        /// What a pattern looks like.
        expected: &'static str,
    },
    /// Two masks of one camera, or two clouds, of one frame.
    #[error("{key}: {} and {} are both number {number}", first.display(), second.display())]
    DuplicateFrame {
        /// Whose: `camera left: masks` or `points`.
        key: String,
        /// The number in both names.
        number: u64,
        /// One file.
        first: PathBuf,
        /// The other.
        second: PathBuf,
    },
    /// The calibration is at fault.
    #[error(transparent)]
    Calibration(#[from] CalibrationError),
    /// The pictures are at fault.
    #[error(transparent)]
    Footage(#[from] FootageError),
    /// No camera has masks.
    #[error(
        "{}: no masks and no pictures: expected masks/<camera>/, pose/<camera>_json/ (detections), videos/<camera>.* or images/<camera>/ beside the calibration, or masks, detections, video or images = … for each camera in sequence.toml{hint}",
        path.display()
    )]
    NoMasks {
        /// The recording.
        path: PathBuf,
        /// The videos that lie elsewhere, or nothing.
        hint: String,
    },
    /// Files of which none has the name of a calibrated camera.
    #[error(
        "{}: no calibrated camera is called {}: the calibration has {}; say in sequence.toml which is which, as in: camera = [{lines}]",
        path.display(), found.join(", "), known.join(", ")
    )]
    Strangers {
        /// The recording.
        path: PathBuf,
        /// The names of the files or folders.
        found: Vec<String>,
        /// The calibrated cameras.
        known: Vec<String>,
        /// The cameras, in the order of both, for a manifest.
        lines: String,
    },
    /// A camera's masks were promised and are not there.
    #[error("camera {camera}: no mask at {}", pattern.display())]
    MissingMasks {
        /// The camera.
        camera: String,
        /// Where they should be.
        pattern: PathBuf,
    },
    /// A single camera.
    #[error(
        "{}: only one camera ({camera}) has masks or detections: one camera cannot tell size from distance; expected two or more",
        path.display()
    )]
    OneCamera {
        /// The recording.
        path: PathBuf,
        /// The camera.
        camera: String,
    },
    /// A mask that cannot be used.
    #[error("{}: camera {camera}, {frame}: {fault}", path.display())]
    Mask {
        /// The file.
        path: PathBuf,
        /// The camera.
        camera: String,
        /// The frame.
        frame: FrameIndex,
        /// Why.
        fault: Box<MaskFault>,
    },
    /// Point clouds were promised and are not there.
    #[error("points: no point cloud (.ply, .xyz, .txt, .csv) at {}", pattern.display())]
    MissingPoints {
        /// Where they should be.
        pattern: PathBuf,
    },
    /// A point cloud that cannot be used.
    #[error("{frame}: {source}")]
    Cloud {
        /// The frame.
        frame: FrameIndex,
        /// Why, with the file.
        source: Box<CloudError>,
    },
    /// No detections where the manifest or the folder promises some.
    #[error("camera {camera}: no detections (.json) at {}", pattern.display())]
    MissingDetections {
        /// Where they were looked for.
        pattern: PathBuf,
        /// The camera.
        camera: String,
    },
    /// A file of detections that cannot be used.
    #[error("{}: {reason}", path.display())]
    Detections {
        /// The file.
        path: PathBuf,
        /// Why, in one line.
        reason: String,
    },
    /// Detections of points that nobody names.
    #[error("{}: detections: {found}: write keypoints = \"…\" in sequence.toml, with one of {known}", path.display())]
    KeypointSet {
        /// The recording.
        path: PathBuf,
        /// What was found.
        found: String,
        /// The sets that are known.
        known: String,
    },
    /// Detections in pictures of another size than the calibration's.
    #[error(
        "camera {camera}: detections reach pixel ({:.0}, {:.0}), its calibration is of pictures of {} × {}: were they made from pictures of another size? detections_scale in sequence.toml says how many of the calibration's pixels one of theirs is",
        farthest[0], farthest[1], size[0], size[1]
    )]
    DetectionSize {
        /// The camera.
        camera: String,
        /// Largest x and y, pixels.
        farthest: [f64; 2],
        /// Width and height, pixels.
        size: [u32; 2],
    },
    /// A scale of detections that no picture has.
    #[error("{}: detections_scale = {scale}: expected a number from 0.01 to 100, how many of the calibration's pixels one pixel of the detections is", path.display())]
    DetectionsScale {
        /// The manifest.
        path: PathBuf,
        /// What it says.
        scale: f64,
    },
    /// Points far outside the cameras' view, as when millimetres are read as metres.
    #[error(
        "{}: {frame}: the points lie {distance_m:.0} m from the middle of the cameras' view, the cameras {cameras_m:.1} m: if the points are in millimetres write points_unit = \"mm\" in sequence.toml; else check unit and up of the calibration",
        path.display()
    )]
    PointsFar {
        /// The file.
        path: PathBuf,
        /// The frame.
        frame: FrameIndex,
        /// Median distance of the points from the middle of what the cameras see, metres.
        distance_m: f64,
        /// Mean distance of the cameras from it, metres.
        cameras_m: f64,
    },
    /// Points in one place, as when metres are read as millimetres.
    #[error(
        "{}: {frame}: the points lie within {distance_m:.5} m, the cameras {cameras_m:.1} m away: if the points are in metres write points_unit = \"m\" in sequence.toml; else check unit of the calibration",
        path.display()
    )]
    PointsTogether {
        /// The file.
        path: PathBuf,
        /// The frame.
        frame: FrameIndex,
        /// Median distance of the points from their middle, metres.
        distance_m: f64,
        /// Mean distance of the cameras from the middle of what they see, metres.
        cameras_m: f64,
    },
    /// Another recording than the one that a result was fitted to.
    #[error(
        "{}: this is not the recording of the result: {reason}; give the one that was fitted, or fit this one",
        path.display()
    )]
    Another {
        /// The recording.
        path: PathBuf,
        /// What differs.
        reason: String,
    },
    /// A frame was asked for that the recording does not have.
    #[error("frame at position {position} of a recording of {count}")]
    NoFrame {
        /// Position asked for, from 0.
        position: usize,
        /// Number of frames.
        count: usize,
    },
}
