//! From a recording to cameras and frame numbers.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use super::probe::{Probe, probe};
use super::{CameraFootage, Footage, FootageError, FootageNote, Source, image};
use crate::camera::Rig;
use crate::io::recording::cameras::CalibratedCameras;
use crate::io::recording::layout::numbered_files::{self, NumberedFiles, Wanted};
use crate::io::recording::layout::{self, elsewhere};
use crate::io::recording::manifest::CameraFiles;
use crate::io::recording::{Recording, RecordingError};

/// Largest relative difference between a video's rate and the recording's that is not noted: 59.94 passes for 60.
const SAME_RATE: f64 = 0.005;

/// A camera's pictures, before their frames are numbered.
enum CameraPictures {
    Images(NumberedFiles),
    Video(PathBuf, Probe),
}

pub(in crate::io::recording) fn open(recording: &Recording) -> Result<Footage, RecordingError> {
    let mut notes = Vec::new();

    // cameras with pictures, and their calibration
    let found = find(recording, &mut notes)?;
    let CalibratedCameras { rig, cameras, uncalibrated, .. } = recording.calibrate(found, size)?;
    notes.extend(
        uncalibrated.into_iter().map(|unknown| FootageNote::Uncalibrated { camera: unknown.name }),
    );
    notes.extend(recording.calibration_notes().into_iter().map(FootageNote::from));
    check_sizes(&rig, &cameras)?;

    // frames
    let of_videos = cameras.iter().find_map(|(_, found)| found.rate_hz());
    // the pictures of one instant need no clock
    let is_instant = cameras.iter().all(|(_, found)| found.is_one_image());
    let fps = recording.frame_rate(of_videos.or(is_instant.then_some(1.0)))?;
    recording.check_offsets(fps)?;
    let cameras: Vec<CameraFootage> = cameras
        .into_iter()
        .map(|(files, found)| found.footage(&recording.folder, &files, fps, &mut notes))
        .collect();
    let lengths: Vec<usize> = cameras.iter().map(|c| c.frames().len()).collect();
    if lengths.windows(2).any(|pair| pair[0] != pair[1]) {
        let names = rig.names().map(str::to_owned);
        notes.push(FootageNote::Lengths { cameras: names.zip(lengths).collect() });
    }

    Ok(Footage { fps, rig, cameras, notes, up: recording.manifest.up })
}

/// The cameras that have pictures: of the manifest or, where it names no pictures, of the folder.
fn find(
    recording: &Recording,
    notes: &mut Vec<FootageNote>,
) -> Result<Vec<(CameraFiles, CameraPictures)>, RecordingError> {
    let has_pictures = |camera: &CameraFiles| camera.images.is_some() || camera.video.is_some();
    let cameras = recording.manifest.cameras.iter().cloned();
    let (mut with, without): (Vec<_>, Vec<_>) = cameras.partition(has_pictures);
    if with.is_empty() {
        with = conventional_cameras(&recording.folder)?;
    } else {
        let without = without.into_iter();
        notes.extend(without.map(|c| FootageNote::Without { camera: c.name }));
    }
    if with.is_empty() {
        let (path, hint) = (recording.path.clone(), elsewhere::hint(&recording.folder));
        return Err(FootageError::NoPictures { path, hint }.into());
    }
    usable_cameras(&recording.folder, with, notes)
}

/// The cameras whose pictures can be read. A camera whose video holds no pictures is left out, as long as there are others.
fn usable_cameras(
    folder: &Path,
    cameras: Vec<CameraFiles>,
    notes: &mut Vec<FootageNote>,
) -> Result<Vec<(CameraFiles, CameraPictures)>, RecordingError> {
    let (mut usable, mut first_fault) = (Vec::new(), None);
    for camera in cameras {
        match find_pictures(folder, &camera) {
            Ok(found) => usable.push((camera, found)),
            Err(RecordingError::Footage(fault @ FootageError::NoVideo { .. })) => {
                notes
                    .push(FootageNote::Unusable { camera: camera.name, reason: fault.to_string() });
                first_fault.get_or_insert(fault);
            }
            Err(fault) => return Err(fault),
        }
    }

    match first_fault {
        Some(fault) if usable.is_empty() => Err(fault.into()),
        _ => Ok(usable),
    }
}

fn find_pictures(folder: &Path, camera: &CameraFiles) -> Result<CameraPictures, RecordingError> {
    let missing = |key, path| FootageError::Missing { camera: camera.name.clone(), key, path };

    if let Some(background) = camera.background.as_ref().map(|path| folder.join(path))
        && !background.is_file()
    {
        return Err(missing("background", background).into());
    }

    match (&camera.images, &camera.video) {
        (Some(_), Some(_)) => Err(FootageError::Both { camera: camera.name.clone() }.into()),
        (None, Some(video)) => {
            let video = folder.join(video);
            if !video.is_file() {
                return Err(missing("video", video).into());
            }
            let probed = probe(&video)?;
            Ok(CameraPictures::Video(video, probed))
        }
        (images, None) => {
            let pattern = images.as_deref().unwrap_or_default();
            let wanted = Wanted {
                key: &format!("camera {}: images", camera.name),
                is_kind: numbered_files::is_image,
            };
            let files = numbered_files::list(folder, pattern, &wanted)?;
            if files.of_number.is_empty() {
                return Err(missing("images", folder.join(pattern)).into());
            }
            Ok(CameraPictures::Images(files))
        }
    }
}

/// Folders of videos: ours and Pose2Sim's, FreeMoCap's, and the recording's own, as caliscope has it.
const VIDEOS: [&str; 3] = ["videos", "synchronized_videos", ""];
/// Endings of videos in the recording's own folder.
pub(in crate::io::recording) const ENDINGS: [&str; 6] = ["mp4", "mov", "avi", "mkv", "m4v", "webm"];

/// The videos of the first of these folders that holds some.
fn conventional_videos(folder: &Path) -> Result<Vec<PathBuf>, RecordingError> {
    for place in VIDEOS {
        let is_video = |path: &PathBuf| {
            let ending = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
            path.is_file() && (!place.is_empty() || ENDINGS.contains(&ending.as_str()))
        };
        let mut found = layout::visible(&folder.join(place))?;
        found.retain(is_video);
        if !found.is_empty() {
            let beneath = |path: &PathBuf| beneath(place, path);
            return Ok(found.iter().map(beneath).collect());
        }
    }
    Ok(Vec::new())
}

/// One camera for each file `videos/<camera>.*` and each folder `images/<camera>`, by name.
fn conventional_cameras(folder: &Path) -> Result<Vec<CameraFiles>, RecordingError> {
    let mut cameras: BTreeMap<String, CameraFiles> = BTreeMap::new();
    for path in conventional_videos(folder)? {
        let camera = camera_of(&mut cameras, &path);
        if let Some(first) = camera.video.replace(path.clone()) {
            let (camera, folder) = (camera.name.clone(), folder.to_owned());
            let [first, second] = [first, path].map(|path| folder.join(path));
            return Err(FootageError::Two { camera, first, second }.into());
        }
    }

    for path in layout::visible(&folder.join("images"))?.into_iter().filter(|path| path.is_dir()) {
        let camera = camera_of(&mut cameras, &path);
        if camera.video.is_none() {
            camera.images = Some(format!("images/{}", camera.name));
        }
    }

    for path in layout::visible(&folder.join("background"))? {
        let stem = path.file_stem().map(|stem| stem.to_string_lossy().into_owned());
        if let Some(camera) = stem.and_then(|stem| cameras.get_mut(&stem)) {
            camera.background = Some(beneath("background", &path));
        }
    }

    Ok(cameras.into_values().collect())
}

fn camera_of<'a>(
    cameras: &'a mut BTreeMap<String, CameraFiles>,
    path: &Path,
) -> &'a mut CameraFiles {
    let name = if path.is_dir() { path.file_name() } else { path.file_stem() };
    let name = name.unwrap_or_default().to_string_lossy().into_owned();
    let empty = CameraFiles { name: name.clone(), ..CameraFiles::default() };
    cameras.entry(name).or_insert(empty)
}

/// A file's place relative to the recording.
fn beneath(folder: &str, path: &Path) -> PathBuf {
    Path::new(folder).join(path.file_name().unwrap_or_default())
}

/// Width and height of the pictures; `None` if the first image cannot be read.
fn size(found: &CameraPictures) -> Option<[u32; 2]> {
    match found {
        CameraPictures::Video(_, probe) => Some(probe.size),
        CameraPictures::Images(files) => {
            let picture = image::read(files.of_number.values().next()?).ok()?;
            Some([picture.width() as u32, picture.height() as u32])
        }
    }
}

fn check_sizes(rig: &Rig, cameras: &[(CameraFiles, CameraPictures)]) -> Result<(), RecordingError> {
    for (camera, (_, found)) in rig.cameras.iter().zip(cameras) {
        let expected = [camera.width_px, camera.height_px];
        let path = match found {
            CameraPictures::Video(path, _) => Some(path),
            CameraPictures::Images(files) => files.of_number.values().next(),
        };

        if let (Some(found), Some(path)) = (size(found), path)
            && found != expected
        {
            return Err(FootageError::Size {
                camera: camera.name.clone(),
                path: path.clone(),
                expected,
                found,
            }
            .into());
        }
    }
    Ok(())
}

impl CameraPictures {
    /// Frames per second of a video.
    fn rate_hz(&self) -> Option<f64> {
        match self {
            Self::Video(_, probe) => probe.rate_hz,
            Self::Images(_) => None,
        }
    }

    fn is_one_image(&self) -> bool {
        matches!(self, Self::Images(files) if files.of_number.len() == 1)
    }

    /// The numbered pictures of a camera in a recording of `fps`.
    fn footage(
        self,
        folder: &Path,
        camera: &CameraFiles,
        fps: f64,
        notes: &mut Vec<FootageNote>,
    ) -> CameraFootage {
        let name = camera.name.clone();
        let source = match self {
            CameraPictures::Images(files) => {
                if files.unnumbered > 0 {
                    notes.push(FootageNote::Unnumbered { camera: name, files: files.unnumbered });
                }
                Source::Images(files.of_number)
            }
            CameraPictures::Video(path, probe) => {
                if let Some(video_hz) =
                    probe.rate_hz.filter(|hz| (hz - fps).abs() > SAME_RATE * fps)
                {
                    notes.push(FootageNote::Rate { camera: name, video_hz, fps });
                }
                let numbering = probe.numbering(fps);
                Source::Video { path, numbering }
            }
        };

        CameraFootage {
            source,
            beginning: camera.beginning(fps),
            background: camera.background.as_ref().map(|path| folder.join(path)),
        }
    }
}
