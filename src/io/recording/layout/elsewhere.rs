//! Videos that lie where none are looked for, as cameras of a manifest.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use super::visible;
use crate::io::recording::footage::ENDINGS;

/// Folders below the recording's in which a video is looked for, as in OpenCap's `Videos/Cam0/InputMedia/walk/walk.mp4`.
const DEEPEST: usize = 4;
/// Most of them.
const MOST: usize = 1000;

/// What to write into a manifest so that the videos of a folder are found; empty where fewer than two cameras have any.
pub(in crate::io::recording) fn hint(folder: &Path) -> String {
    let mut videos = Vec::new();
    collect(folder, DEEPEST, &mut videos);
    let below = videos.iter().filter_map(|path| path.strip_prefix(folder).ok());
    let below: Vec<&Path> = below.collect();

    // the outermost level at which the folders differ is that of the cameras
    let of_level = |level: usize| cameras(&below, level);
    let Some(cameras) = (0..DEEPEST).map(of_level).find(|cameras| cameras.len() > 1) else {
        return String::new();
    };
    let is_opencap = cameras.values().any(|camera| camera.has_pickle(folder));
    let line = |(i, (name, camera)): (usize, (&String, &Camera<'_>))| {
        // as Pose2Sim calls the cameras of OpenCap
        let name = if is_opencap { format!("cam_{i:02}") } else { name.clone() };
        format!("{{ name = {name:?}, video = {:?} }}", camera.video.display().to_string())
    };
    let lines: Vec<String> = cameras.iter().enumerate().map(line).collect();
    let before = match is_opencap {
        true => {
            "Python pickles can run any program and are not read: convert them to calibration.toml with Pose2Sim, and "
        }
        false => "",
    };
    format!(
        "; {before}write [[camera]] into sequence.toml, here in one line: camera = [{}]",
        lines.join(", ")
    )
}

/// The video of a camera, and the folder that is named like it.
struct Camera<'a> {
    folder: PathBuf,
    video: &'a Path,
}

impl Camera<'_> {
    fn has_pickle(&self, recording: &Path) -> bool {
        let files = visible(&recording.join(&self.folder)).unwrap_or_default();
        files.iter().any(|path| path.extension().is_some_and(|ending| ending == "pickle"))
    }
}

/// The first video of each camera, if the folders at this level are called after them: of the first group of folders
/// that are alike but for this name.
fn cameras<'a>(videos: &[&'a Path], level: usize) -> BTreeMap<String, Camera<'a>> {
    let mut groups: BTreeMap<PathBuf, BTreeMap<String, Camera<'a>>> = BTreeMap::new();
    for &video in videos {
        let mut folders: Vec<_> = video.iter().collect();
        folders.pop();
        if let Some(name) = folders.get(level).map(|name| name.to_string_lossy().into_owned()) {
            let folder = folders[..=level].iter().collect();
            folders.remove(level);
            let group = groups.entry(folders.into_iter().collect()).or_default();
            group.entry(name).or_insert(Camera { folder, video });
        }
    }
    groups.into_values().find(|group| group.len() > 1).unwrap_or_default()
}

/// The videos of a folder and of those in it, by name.
fn collect(folder: &Path, deeper: usize, videos: &mut Vec<PathBuf>) {
    for path in visible(folder).unwrap_or_default() {
        let ending = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
        if videos.len() >= MOST {
            return;
        } else if path.is_dir() && deeper > 0 {
            collect(&path, deeper - 1, videos);
        } else if ENDINGS.contains(&ending.as_str()) {
            videos.push(path);
        }
    }
}
