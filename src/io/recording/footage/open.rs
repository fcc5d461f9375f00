//! From a folder to cameras and frame numbers.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use super::probe::{Probe, probe};
use super::{CameraFootage, Footage, FramesError, FramesNote, Source, image};
use crate::camera::Rig;
use crate::io::calibration::{self, CalibrationOptions};
use crate::io::recording::layout;
use crate::io::recording::layout::numbered_files::{self, NumberedFiles, Wanted};
use crate::io::recording::manifest::{CameraFiles, Manifest};

/// How far a video's rate may be from the recording's, as a fraction of it, without a note: 59.94 is 60.
const SAME_RATE: f64 = 0.005;

/// What a camera has, before its frames are numbered.
enum Found {
    Images(NumberedFiles),
    Video(PathBuf, Probe),
}

pub(super) fn open(path: &Path, fps: Option<f64>) -> Result<Footage, FramesError> {
    let (folder, manifest_path) = layout::locate(path)?;
    let manifest = match &manifest_path {
        Some(path) => Manifest::read(path)?,
        None => Manifest::default(),
    };
    let mut notes = Vec::new();
    let mut cameras = find(path, &folder, &manifest, &mut notes)?;
    let rig = calibrate(path, &folder, &manifest, &mut cameras, &mut notes)?;
    check_sizes(&rig, &cameras)?;
    let fps = frame_rate(fps.or(manifest.fps), path, &cameras)?;
    let footage: Vec<CameraFootage> = cameras
        .into_iter()
        .map(|(files, found)| footage(&folder, &files, found, fps, &mut notes))
        .collect();
    let lengths: Vec<usize> = footage.iter().map(|c| c.frames().len()).collect();
    if lengths.windows(2).any(|pair| pair[0] != pair[1]) {
        let names = rig.names().map(str::to_owned);
        notes.push(FramesNote::Lengths {
            cameras: names.zip(lengths).collect(),
        });
    }
    Ok(Footage {
        fps,
        rig,
        cameras: footage,
        notes,
        folder,
        up: manifest.up,
    })
}

/// The cameras of the manifest, or of the folder where it lists none or none has pictures, and what they have.
fn find(
    path: &Path,
    folder: &Path,
    manifest: &Manifest,
    notes: &mut Vec<FramesNote>,
) -> Result<Vec<(CameraFiles, Found)>, FramesError> {
    let has_pictures = |camera: &CameraFiles| camera.images.is_some() || camera.video.is_some();
    let (mut with, without): (Vec<_>, Vec<_>) =
        manifest.cameras.iter().cloned().partition(has_pictures);
    if with.is_empty() {
        with = conventional(folder)?;
    } else {
        notes.extend(
            without
                .into_iter()
                .map(|c| FramesNote::Without { camera: c.name }),
        );
    }
    if with.is_empty() {
        return Err(FramesError::NoPictures { path: path.into() });
    }
    usable(folder, with, notes)
}

/// The cameras whose pictures can be read; a video that holds none costs its camera alone, as long as there are others.
fn usable(
    folder: &Path,
    cameras: Vec<CameraFiles>,
    notes: &mut Vec<FramesNote>,
) -> Result<Vec<(CameraFiles, Found)>, FramesError> {
    let (mut usable, mut first_fault) = (Vec::new(), None);
    for camera in cameras {
        match found(folder, &camera) {
            Ok(found) => usable.push((camera, found)),
            Err(fault @ FramesError::NoVideo { .. }) => {
                notes.push(FramesNote::Unusable {
                    camera: camera.name,
                    reason: fault.to_string(),
                });
                first_fault.get_or_insert(fault);
            }
            Err(fault) => return Err(fault),
        }
    }
    match first_fault {
        Some(fault) if usable.is_empty() => Err(fault),
        _ => Ok(usable),
    }
}

fn found(folder: &Path, camera: &CameraFiles) -> Result<Found, FramesError> {
    let missing = |key, path| FramesError::Missing {
        camera: camera.name.clone(),
        key,
        path,
    };
    if let Some(background) = camera.background.as_ref().map(|path| folder.join(path))
        && !background.is_file()
    {
        return Err(missing("background", background));
    }
    match (&camera.images, &camera.video) {
        (Some(_), Some(_)) => Err(FramesError::Both {
            camera: camera.name.clone(),
        }),
        (None, Some(video)) => {
            let video = folder.join(video);
            if !video.is_file() {
                return Err(missing("video", video));
            }
            let probed = probe(&video)?;
            Ok(Found::Video(video, probed))
        }
        (images, None) => {
            let pattern = images.as_deref().unwrap_or_default();
            let wanted = Wanted {
                key: &format!("camera {}: images", camera.name),
                is_kind: numbered_files::is_image,
            };
            let files = numbered_files::list(folder, pattern, &wanted)?;
            if files.of_number.is_empty() {
                return Err(missing("images", folder.join(pattern)));
            }
            Ok(Found::Images(files))
        }
    }
}

/// One camera for each file `videos/<camera>.*` and each folder `images/<camera>`, by name.
fn conventional(folder: &Path) -> Result<Vec<CameraFiles>, FramesError> {
    let mut cameras: BTreeMap<String, CameraFiles> = BTreeMap::new();
    for path in layout::visible(&folder.join("videos"))?
        .into_iter()
        .filter(|path| path.is_file())
    {
        let camera = camera_of(&mut cameras, &path);
        camera.video = Some(beneath("videos", &path));
    }
    for path in layout::visible(&folder.join("images"))?
        .into_iter()
        .filter(|path| path.is_dir())
    {
        let camera = camera_of(&mut cameras, &path);
        if camera.video.is_none() {
            camera.images = Some(format!("images/{}", camera.name));
        }
    }
    for path in layout::visible(&folder.join("background"))? {
        let stem = path
            .file_stem()
            .map(|stem| stem.to_string_lossy().into_owned());
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
    let name = if path.is_dir() {
        path.file_name()
    } else {
        path.file_stem()
    };
    let name = name.unwrap_or_default().to_string_lossy().into_owned();
    let empty = CameraFiles {
        name: name.clone(),
        ..CameraFiles::default()
    };
    cameras.entry(name).or_insert(empty)
}

/// A file's place relative to the recording.
fn beneath(folder: &str, path: &Path) -> PathBuf {
    Path::new(folder).join(path.file_name().unwrap_or_default())
}

/// Reads the calibration of the cameras; those that are not in it are left out unless the manifest lists them.
fn calibrate(
    path: &Path,
    folder: &Path,
    manifest: &Manifest,
    cameras: &mut Vec<(CameraFiles, Found)>,
    notes: &mut Vec<FramesNote>,
) -> Result<Rig, FramesError> {
    let sizes = cameras
        .iter()
        .filter_map(|(camera, found)| Some((camera.name.clone(), size(found)?)));
    let options = CalibrationOptions {
        unit: manifest.unit,
        up: manifest.up,
        image_sizes_px: sizes.collect(),
    };
    let sources = layout::calibration_paths(folder, manifest.calibration.as_ref());
    let calibrated = layout::read_calibration(&sources, &options)?;
    if manifest.cameras.is_empty() {
        for (camera, _) in cameras.iter_mut() {
            if let Some(name) = calibrated_name(&calibrated, &camera.name) {
                camera.name = name;
            }
        }
        let is_known =
            |(camera, _): &(CameraFiles, Found)| calibrated.by_name(&camera.name).is_some();
        if cameras.iter().any(is_known) {
            let unknown = cameras.iter().filter(|camera| !is_known(camera));
            notes.extend(unknown.map(|(c, _)| FramesNote::Uncalibrated {
                camera: c.name.clone(),
            }));
            cameras.retain(is_known);
        }
    }
    let source = match sources.as_slice() {
        [(_, source)] => source,
        _ => path,
    };
    let names: Vec<&str> = cameras
        .iter()
        .map(|(camera, _)| camera.name.as_str())
        .collect();
    Ok(calibration::select(&calibrated, source, &names)?)
}

/// The calibrated camera of this name; else the only one whose name has the same letters and digits (`cam01`, `cam_01`).
fn calibrated_name(rig: &Rig, name: &str) -> Option<String> {
    let plain = |name: &str| {
        let letters = name.chars().filter(|c| c.is_alphanumeric());
        letters.flat_map(char::to_lowercase).collect::<String>()
    };
    if rig.by_name(name).is_some() {
        return None;
    }
    let mut alike = rig.names().filter(|other| plain(other) == plain(name));
    let first = alike.next()?;
    alike.next().is_none().then(|| first.into())
}

/// Width and height of the pictures; `None` if the first image cannot be read.
fn size(found: &Found) -> Option<[u32; 2]> {
    match found {
        Found::Video(_, probe) => Some(probe.size),
        Found::Images(files) => {
            let picture = image::read(files.of_number.values().next()?).ok()?;
            Some([picture.width() as u32, picture.height() as u32])
        }
    }
}

fn check_sizes(rig: &Rig, cameras: &[(CameraFiles, Found)]) -> Result<(), FramesError> {
    for (camera, (_, found)) in rig.cameras.iter().zip(cameras) {
        let expected = [camera.width_px, camera.height_px];
        let path = match found {
            Found::Video(path, _) => Some(path),
            Found::Images(files) => files.of_number.values().next(),
        };
        if let (Some(found), Some(path)) = (size(found), path)
            && found != expected
        {
            return Err(FramesError::Size {
                camera: camera.name.clone(),
                path: path.clone(),
                expected,
                found,
            });
        }
    }
    Ok(())
}

/// That which is given; else that of the first video.
fn frame_rate(
    given: Option<f64>,
    path: &Path,
    cameras: &[(CameraFiles, Found)],
) -> Result<f64, FramesError> {
    let of_video = |found: &Found| match found {
        Found::Video(_, probe) => probe.rate_hz,
        Found::Images(_) => None,
    };
    let fps = given.or_else(|| cameras.iter().find_map(|(_, found)| of_video(found)));
    Ok(layout::frame_rate(fps, path)?)
}

fn footage(
    folder: &Path,
    camera: &CameraFiles,
    found: Found,
    fps: f64,
    notes: &mut Vec<FramesNote>,
) -> CameraFootage {
    let name = camera.name.clone();
    let source = match found {
        Found::Images(files) => {
            if files.unnumbered > 0 {
                notes.push(FramesNote::Unnumbered {
                    camera: name,
                    files: files.unnumbered,
                });
            }
            Source::Images(files.of_number)
        }
        Found::Video(path, probe) => {
            if let Some(video_hz) = probe
                .rate_hz
                .filter(|hz| (hz - fps).abs() > SAME_RATE * fps)
            {
                notes.push(FramesNote::Rate {
                    camera: name,
                    video_hz,
                    fps,
                });
            }
            let numbering = probe.numbering(fps);
            Source::Video { path, numbering }
        }
    };
    CameraFootage {
        source,
        shift: camera.shift(fps),
        background: camera.background.as_ref().map(|path| folder.join(path)),
    }
}
