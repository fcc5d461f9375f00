//! `offsets.toml`: when each camera began, as `maquette sync` found it.
//!
//! It stands beside the recording's `sequence.toml`, which a person writes and a program must not change. For the cameras that it names it
//! takes the place of `offset_frames` and `start_s`. It may be deleted.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use serde::Deserialize;

use super::RecordingError;
use super::manifest::{CameraFiles, MOST_OFFSET};
use crate::io::unknown_key::line_of;
use crate::io::{frame_rate, input};

/// The name of the file in a recording's folder.
pub const OFFSETS: &str = "offsets.toml";

/// Rates that differ by less are one: 59.94 passes for 60.
const SAME_RATE: f64 = 0.005;

/// When each camera began.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Offsets {
    /// The frame rate at which they were found, Hz.
    pub fps: f64,
    /// Camera by camera.
    #[serde(rename = "camera", default)]
    pub cameras: Vec<CameraOffsetFrames>,
}

/// When a camera began.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CameraOffsetFrames {
    /// Its name in the calibration.
    pub name: String,
    /// By how many frames it began after the recording.
    pub offset_frames: f64,
    /// Its standard deviation; `None` where the recording did not tell, and the offset is what it was.
    pub sd_frames: Option<f64>,
}

impl Offsets {
    /// Reads the file in a folder; `None` where there is none.
    pub(super) fn find(folder: &Path) -> Result<Option<(PathBuf, Self)>, RecordingError> {
        let path = folder.join(OFFSETS);
        if !path.exists() {
            return Ok(None);
        }
        let text = input::read_text(&path)
            .map_err(|source| RecordingError::Read { path: path.clone(), source })?;
        let offsets = Self::parse(&text, &path)?;
        Ok(Some((path, offsets)))
    }

    /// Checks a text; `path` is for messages.
    fn parse(text: &str, path: &Path) -> Result<Self, RecordingError> {
        let offsets: Self = toml::from_str(text).map_err(|source| RecordingError::Syntax {
            path: path.into(),
            line: line_of(text, source.span().map_or(0, |span| span.start)),
            source: Box::new(source),
        })?;
        let path = || path.to_owned();
        if !frame_rate::is_one(offsets.fps) {
            return Err(RecordingError::ManifestFps { path: path(), line: 1, fps: offsets.fps });
        }
        for (i, camera) in offsets.cameras.iter().enumerate() {
            let name = camera.name.clone();
            if !MOST_OFFSET.contains(&camera.offset_frames) {
                let (key, value) = ("offset_frames", camera.offset_frames);
                return Err(RecordingError::Clock { path: path(), camera: name, key, value });
            }
            if offsets.cameras[..i].iter().any(|other| other.name == name) {
                return Err(RecordingError::DuplicateCamera { path: path(), name, count: 2 });
            }
        }
        Ok(offsets)
    }

    /// The text of the file.
    pub fn text(&self) -> String {
        let mut text = format!(
            "# When each camera began, as `maquette sync` found it: instead of offset_frames and start_s in sequence.toml.\n\
             fps = {:?}\n",
            self.fps
        );
        for camera in &self.cameras {
            let name = toml::Value::String(camera.name.clone());
            // writing to a String cannot fail
            let _ = writeln!(
                text,
                "\n[[camera]]\nname = {name}\noffset_frames = {:?}",
                camera.offset_frames
            );
            if let Some(sd) = camera.sd_frames {
                let _ = writeln!(text, "sd_frames = {sd:?}");
            }
        }
        text
    }

    /// Puts them in the place of what the manifest says.
    pub(super) fn apply<'a>(&self, cameras: impl Iterator<Item = &'a mut CameraFiles>) {
        for camera in cameras {
            let known = self.cameras.iter().find(|known| known.name == camera.name);
            if let Some(known) = known {
                (camera.offset_frames, camera.start_s) = (known.offset_frames, 0.0);
            }
        }
    }

    /// Whether they were found at this frame rate.
    pub(super) fn check(&self, path: &Path, fps: f64) -> Result<(), RecordingError> {
        match (self.fps - fps).abs() > SAME_RATE * fps {
            true => Err(RecordingError::OffsetsFps { path: path.into(), found: self.fps, fps }),
            false => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn message(text: &str) -> String {
        Offsets::parse(text, Path::new("walk/offsets.toml")).unwrap_err().to_string()
    }

    #[test]
    fn what_is_written_is_read_back() {
        let camera = |name: &str, offset_frames, sd_frames| CameraOffsetFrames {
            name: name.into(),
            offset_frames,
            sd_frames,
        };
        let cameras = vec![camera("left \"1\"", -1.7, Some(0.03)), camera("b", 2.0, None)];
        let offsets = Offsets { fps: 50.0, cameras };
        assert_eq!(Offsets::parse(&offsets.text(), Path::new("a")).unwrap(), offsets);

        let mut files = [CameraFiles { name: "b".into(), start_s: 3.0, ..CameraFiles::default() }];
        offsets.apply(files.iter_mut());
        assert_eq!((files[0].offset_frames, files[0].start_s), (2.0, 0.0));
        assert!(offsets.check(Path::new("a"), 50.1).is_ok());
        assert!(offsets.check(Path::new("a"), 25.0).is_err());
    }

    #[test]
    fn faults_are_named_in_one_line() {
        let one = "[[camera]]\nname = \"a\"\noffset_frames = 1\n";
        for (text, part) in [
            ("fps = 0\n".into(), "offsets.toml:1: fps = 0"),
            ("fps = 50\ncameras = 3\n".into(), "offsets.toml:2: "),
            (format!("fps = 50\n{one}{one}"), "camera \"a\" is listed 2 times"),
            (format!("fps = 50\n{}", one.replace("= 1", "= nan")), "camera a: offset_frames = NaN"),
        ] {
            let message = message(&text);
            assert!(message.contains(part) && !message.contains('\n'), "{message}");
        }
    }
}
