//! `sequence.toml`: what a recording consists of.
//!
//! ```toml
//! fps = 50.0
//! calibration = "calibration.toml"   # or { cam1 = "cam1/config.xml", cam2 = "cam2/config.xml" }
//! unit = "m"                         # of the calibration: m | mm
//! up = "z"                           # of the calibration's world: z | -z | y | -y
//! poses = "world-to-camera"          # of the calibration: see `PoseForm`
//! body = "human-ellipsoids"          # a shipped model or a path
//! height_m = 1.80                    # of the person, without shoes
//! [[camera]]
//! name = "cam_01"
//! masks = "masks/cam_01/%06d.png"    # printf pattern, folder, or glob
//! ```
//!
//! `masks`, `images`, `video`, `background` and `detections` may also stand once at the top, with `{camera}` in the place of the name:
//! each applies to every camera without an entry of its own whose file or folder exists. Where no camera is listed, these
//! files name the cameras.
//!
//! Per camera also `images`, `video`, `background`, `detections`, `offset_frames` and `start_s`; for the recording `points`,
//! `points_unit`, `keypoints`, `detections_scale` and `start`.
//! Paths are relative to the file. All keys but a camera's `name` are optional: what is missing is looked for where a
//! folder without manifest has it.

mod beginning;
mod template;

use std::collections::BTreeMap;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

use serde::Deserialize;
use toml::de::{DeTable, DeValue};

use crate::camera::{PoseForm, UpAxis};
use crate::io::calibration::Unit;
use crate::io::recording::RecordingError;
use crate::io::unknown_key::{UnknownKey, line_of};
use crate::io::{frame_rate, input};

pub(crate) use beginning::Beginning;

const KEYS: &[&str] = &[
    "fps",
    "calibration",
    "unit",
    "up",
    "poses",
    "body",
    "height_m",
    "points",
    "points_unit",
    "keypoints",
    "detections_scale",
    "start",
    "camera",
    "masks",
    "images",
    "video",
    "background",
    "detections",
];
const CAMERA_KEYS: &[&str] =
    &["name", "masks", "images", "video", "background", "detections", "offset_frames", "start_s"];

/// A recording's manifest, as written.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(default)]
pub(crate) struct Manifest {
    /// Frames per second; positive.
    pub fps: Option<f64>,
    /// The calibration file or files.
    pub calibration: Option<CalibrationFiles>,
    /// Unit of the calibration; `None`: that of its format.
    pub unit: Option<Unit>,
    /// Which axis of the calibration's world points up.
    pub up: UpAxis,
    /// What the calibration's rotations and translations mean.
    pub poses: PoseForm,
    /// A shipped body model or the path of one.
    pub body: Option<String>,
    /// The person's height without shoes, metres.
    pub height_m: Option<f64>,
    /// Points on the surface, of each frame: printf pattern, folder, or glob.
    pub points: Option<String>,
    /// Unit of the points; metres if left out.
    pub points_unit: Option<Unit>,
    /// The set of points of the detections; `None`: by the number of their points.
    pub keypoints: Option<String>,
    /// How many of the calibration's pixels one pixel of the detections is; 1 if left out.
    pub detections_scale: Option<f64>,
    /// Reserved for a known start pose.
    pub start: Option<toml::Value>,
    /// [`CameraFiles::masks`] of each camera that has none of its own; `{camera}` is replaced by its name.
    pub masks: Option<String>,
    /// The same of [`CameraFiles::images`].
    pub images: Option<String>,
    /// The same of [`CameraFiles::video`].
    pub video: Option<String>,
    /// The same of [`CameraFiles::background`].
    pub background: Option<String>,
    /// The same of [`CameraFiles::detections`].
    pub detections: Option<String>,
    /// The cameras, in the order in which they are numbered.
    #[serde(rename = "camera")]
    pub cameras: Vec<CameraFiles>,
}

/// One calibration file for all cameras, or one for each.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(untagged, expecting = "calibration: expected a path or a table of camera = path")]
pub(crate) enum CalibrationFiles {
    /// All cameras in one file.
    One(PathBuf),
    /// Camera name → file.
    PerCamera(BTreeMap<String, PathBuf>),
}

/// What one camera recorded.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
pub(crate) struct CameraFiles {
    /// Its name in the calibration.
    pub name: String,
    /// Masks: printf pattern, folder, or glob.
    pub masks: Option<String>,
    /// Images: printf pattern, folder, or glob.
    pub images: Option<String>,
    /// A video.
    pub video: Option<PathBuf>,
    /// An image or a video of the empty scene.
    pub background: Option<PathBuf>,
    /// Detections of joints, a JSON file for each frame: printf pattern, folder, or glob.
    pub detections: Option<String>,
    /// Added to the numbers of this camera's files, so that those of one moment agree: a camera that started three
    /// frames after the others has 3.
    #[serde(default)]
    pub offset_frames: f64,
    /// When this camera's first frame was taken, in seconds on a clock that all cameras share; this times the frame rate is
    /// added to `offset_frames`.
    #[serde(default)]
    pub start_s: f64,
}

/// When a camera may begin: also on a clock that counts seconds from 1970.
const MOST_START_S: RangeInclusive<f64> = -1e10..=1e10;
/// From pictures of a hundredth of the calibration's size to those of a hundred times it.
const DETECTIONS_SCALES: RangeInclusive<f64> = 0.01..=100.0;
pub(crate) const MOST_OFFSET: RangeInclusive<f64> = -1e10..=1e10;

impl CameraFiles {
    /// When this camera began in a recording of this rate.
    pub(crate) fn beginning(&self, fps: f64) -> Beginning {
        Beginning(self.offset_frames + self.start_s * fps)
    }
}

impl Manifest {
    /// Reads and checks a manifest.
    ///
    /// # Errors
    /// [`RecordingError`], with the line where there is one.
    pub(crate) fn read(path: &Path) -> Result<Self, RecordingError> {
        let text = input::read_text(path)
            .map_err(|source| RecordingError::Read { path: path.into(), source })?;
        let mut manifest = Self::parse(&text, path)?;
        template::fill(&mut manifest, path.parent().unwrap_or(Path::new("")));
        Ok(manifest)
    }

    /// Checks the text of a manifest; `path` is for messages.
    ///
    /// # Errors
    /// [`RecordingError`], with the line where there is one.
    pub(crate) fn parse(text: &str, path: &Path) -> Result<Self, RecordingError> {
        let syntax = |source: toml::de::Error| RecordingError::Syntax {
            path: path.into(),
            line: line_of(text, source.span().map_or(0, |span| span.start)),
            source: Box::new(source),
        };
        let table = DeTable::parse(text).map_err(syntax)?;
        if let Some(key) = first_unknown_key(text, table.get_ref()) {
            let UnknownKey { line, key, nearest, known } = key;
            let path = path.into();
            return Err(RecordingError::UnknownKey { path, line, key, nearest, known });
        }
        let manifest: Self = toml::from_str(text).map_err(syntax)?;
        manifest.check_fps(text, table.get_ref(), path)?;
        manifest.check_names(path)?;
        manifest.check_clocks(path)?;
        manifest.check_scale(path)?;
        Ok(manifest)
    }

    fn check_fps(
        &self,
        text: &str,
        table: &DeTable<'_>,
        path: &Path,
    ) -> Result<(), RecordingError> {
        match self.fps {
            Some(fps) if !frame_rate::is_one(fps) => {
                let key = table.keys().find(|key| key.get_ref() == "fps");
                Err(RecordingError::ManifestFps {
                    path: path.into(),
                    line: line_of(text, key.map_or(0, |key| key.span().start)),
                    fps,
                })
            }
            _ => Ok(()),
        }
    }

    fn check_clocks(&self, path: &Path) -> Result<(), RecordingError> {
        let clock = |camera: &CameraFiles, key, value| RecordingError::Clock {
            path: path.into(),
            camera: camera.name.clone(),
            key,
            value,
        };
        for camera in &self.cameras {
            if !MOST_START_S.contains(&camera.start_s) {
                return Err(clock(camera, "start_s", camera.start_s));
            }
            if !MOST_OFFSET.contains(&camera.offset_frames) {
                return Err(clock(camera, "offset_frames", camera.offset_frames));
            }
        }
        Ok(())
    }

    fn check_scale(&self, path: &Path) -> Result<(), RecordingError> {
        match self.detections_scale {
            Some(scale) if !DETECTIONS_SCALES.contains(&scale) => {
                Err(RecordingError::DetectionsScale { path: path.into(), scale })
            }
            _ => Ok(()),
        }
    }

    fn check_names(&self, path: &Path) -> Result<(), RecordingError> {
        let count = |name: &str| self.cameras.iter().filter(|c| c.name == name).count();
        match self.cameras.iter().find(|camera| count(&camera.name) > 1) {
            Some(camera) => Err(RecordingError::DuplicateCamera {
                path: path.into(),
                name: camera.name.clone(),
                count: count(&camera.name),
            }),
            None => Ok(()),
        }
    }
}

fn first_unknown_key(text: &str, table: &DeTable<'_>) -> Option<UnknownKey> {
    let in_cameras = table
        .iter()
        .filter(|(key, _)| key.get_ref() == "camera")
        .filter_map(|(_, value)| match value.get_ref() {
            DeValue::Array(cameras) => Some(cameras.iter()),
            _ => None,
        })
        .flatten()
        .filter_map(|camera| match camera.get_ref() {
            DeValue::Table(camera) => UnknownKey::first_in(text, camera, CAMERA_KEYS),
            _ => None,
        });
    UnknownKey::first_in(text, table, KEYS)
        .into_iter()
        .chain(in_cameras)
        .min_by_key(|unknown| unknown.line)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> Result<Manifest, RecordingError> {
        Manifest::parse(text, Path::new("walk/sequence.toml"))
    }

    fn message(text: &str) -> String {
        parse(text).unwrap_err().to_string()
    }

    #[test]
    fn every_key_is_read() {
        let manifest = parse(
            r#"
            fps = 50
            calibration = { left = "left.xml", right = "right.xml" }
            unit = "mm"
            up = "-z"
            body = "human-ellipsoids"
            height_m = 1.8
            points = "points/%06d.ply"
            points_unit = "mm"
            keypoints = "halpe26"
            start = { frame = 3 }
            [[camera]]
            name = "left"
            masks = "masks/%06d.png"
            images = "images"
            video = "left.avi"
            background = "empty.png"
            detections = "pose/left_json"
            offset_frames = -2
            start_s = 0.5
            [[camera]]
            name = "right"
            "#,
        )
        .unwrap();
        assert_eq!(manifest.fps, Some(50.0));
        assert_eq!(manifest.unit, Some(Unit::Millimetre));
        assert_eq!(manifest.up, UpAxis::MinusZ);
        assert_eq!(manifest.points.as_deref(), Some("points/%06d.ply"));
        assert_eq!(manifest.points_unit, Some(Unit::Millimetre));
        assert_eq!(manifest.body.as_deref(), Some("human-ellipsoids"));
        assert_eq!(manifest.height_m, Some(1.8));
        let Some(CalibrationFiles::PerCamera(files)) = &manifest.calibration else {
            panic!("{manifest:?}");
        };
        assert_eq!(files["right"], PathBuf::from("right.xml"));
        assert_eq!(manifest.keypoints.as_deref(), Some("halpe26"));
        let left = &manifest.cameras[0];
        assert_eq!(left.detections.as_deref(), Some("pose/left_json"));
        assert_eq!((left.offset_frames, left.images.as_deref()), (-2.0, Some("images")));
        assert_eq!(left.beginning(50.0), Beginning(23.0));
        assert_eq!(manifest.cameras[1].name, "right");
    }

    #[test]
    fn unknown_keys_are_refused_with_line_and_neighbour() {
        assert_eq!(
            message("fps = 50\n[[camera]]\nname = \"a\"\nmask = \"m\"\n"),
            "walk/sequence.toml:4: unknown key \"mask\"; did you mean \"masks\"? (known here: \
             name, masks, images, video, background, detections, offset_frames, start_s)"
        );
        assert!(
            message("calibrations = 3")
                .contains(":1: unknown key \"calibrations\"; did you mean \"calibration\"?")
        );
    }

    #[test]
    fn a_frame_rate_that_is_not_positive_is_refused() {
        for fps in ["0.0", "-25", "nan", "inf"] {
            let text = format!("body = \"b\"\nfps = {fps}\n");
            assert!(
                matches!(parse(&text), Err(RecordingError::ManifestFps { line: 2, .. })),
                "{fps}"
            );
        }
    }

    #[test]
    fn values_of_the_wrong_kind_are_named_with_their_line() {
        for (text, line, part) in [
            ("fps = 50\nunit = \"cm\"", 2, "`cm`"),
            ("fps = 50\n\nup = \"x\"", 3, "`x`"),
            ("fps = \"fast\"", 1, "fast"),
            ("calibration = 7", 1, "expected a path or a table"),
            ("fps = 50\n[[camera]]\nmasks = \"m\"", 2, "`name`"),
            ("fps = 50\ncamera = 3", 2, "expected a sequence"),
            ("fps = 50\nfps = 60", 2, "duplicate key"),
            ("fps = = 2", 1, ""),
        ] {
            let message = message(text);
            assert!(message.starts_with(&format!("walk/sequence.toml:{line}: ")), "{message}");
            assert!(message.contains(part), "{message}");
            assert!(!message.contains('\n'), "{message}");
        }
    }

    #[test]
    fn two_cameras_of_one_name_are_refused() {
        let text = "[[camera]]\nname = \"a\"\n[[camera]]\nname = \"a\"\n";
        assert_eq!(
            message(text),
            "walk/sequence.toml: camera \"a\" is listed 2 times: names must differ"
        );
    }
}
