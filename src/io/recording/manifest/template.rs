//! `{camera}`: one pattern for the files of all cameras.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use super::{CameraFiles, Manifest};

/// The placeholder for a camera's name.
const NAME: &str = "{camera}";

/// Gives each camera the files that it does not name itself and that exist; lists the cameras if the manifest lists none.
pub(super) fn fill(manifest: &mut Manifest, folder: &Path) {
    let of_each = |pattern: &Option<String>| {
        let pattern = pattern.as_deref()?;
        Some((pattern.to_owned(), names(folder, pattern)))
    };
    let (masks, images) = (of_each(&manifest.masks), of_each(&manifest.images));
    let (video, background) = (of_each(&manifest.video), of_each(&manifest.background));
    let detections = of_each(&manifest.detections);

    if manifest.cameras.is_empty() {
        let found = [&masks, &images, &video, &detections].into_iter().flatten();
        let names: BTreeSet<&String> = found.flat_map(|(_, names)| names).collect();
        manifest.cameras = names.into_iter().map(|name| named(name)).collect();
    }

    for camera in &mut manifest.cameras {
        let of = |found: &Option<(String, BTreeSet<String>)>| {
            let (pattern, names) = found.as_ref()?;
            let is_there = names.contains(&camera.name);
            is_there.then(|| pattern.replace(NAME, &camera.name))
        };

        let has_pictures = camera.images.is_some() || camera.video.is_some();
        camera.masks = camera.masks.take().or_else(|| of(&masks));
        camera.detections = camera.detections.take().or_else(|| of(&detections));
        if !has_pictures {
            camera.images = of(&images);
            camera.video = of(&video).map(Into::into);
        }
        let background = of(&background).map(Into::into);
        camera.background = camera.background.take().or(background);
    }
}

fn named(name: &str) -> CameraFiles {
    CameraFiles { name: name.into(), ..CameraFiles::default() }
}

/// The names that exist in place of `{camera}` in the path; none if the path has no `{camera}`.
fn names(folder: &Path, pattern: &str) -> BTreeSet<String> {
    let Some((before, after)) = pattern.split_once(NAME) else {
        return BTreeSet::new();
    };
    let (parent, start) = before.rsplit_once('/').unwrap_or(("", before));
    let end = after.split('/').next().unwrap_or_default();
    let entries = fs::read_dir(folder.join(parent)).into_iter().flatten();
    let name = |entry: fs::DirEntry| {
        let file = entry.file_name().to_string_lossy().into_owned();
        let name = file.strip_prefix(start)?.strip_suffix(end)?;
        (!name.is_empty() && !name.starts_with('.')).then(|| name.to_owned())
    };
    entries.flatten().filter_map(name).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_pattern_names_the_cameras_and_the_files_of_each() {
        let folder = tempfile::tempdir().unwrap();
        for path in ["masks/b", "masks/a", "videos", "empty"] {
            fs::create_dir_all(folder.path().join(path)).unwrap();
        }
        for path in ["videos/take_a.mp4", "videos/notes.txt", "empty/a.png"] {
            fs::write(folder.path().join(path), "").unwrap();
        }
        let path = folder.path().join("sequence.toml");
        let text = "masks = \"masks/{camera}/%06d.png\"\nvideo = \"videos/take_{camera}.mp4\"\n\
                    background = \"empty/{camera}.png\"\n";
        fs::write(&path, text).unwrap();
        let cameras = Manifest::read(&path).unwrap().cameras;
        let names: Vec<&str> = cameras.iter().map(|c| c.name.as_str()).collect();
        assert_eq!(names, ["a", "b"]);
        assert_eq!(cameras[1].masks.as_deref(), Some("masks/b/%06d.png"));
        assert_eq!(cameras[0].video.as_deref(), Some(Path::new("videos/take_a.mp4")));
        assert_eq!(cameras[0].background.as_deref(), Some(Path::new("empty/a.png")));
        assert_eq!(cameras[1].background, None);
    }

    #[test]
    fn what_a_camera_says_itself_goes_before() {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("a.mp4"), "").unwrap();
        fs::write(folder.path().join("b.mp4"), "").unwrap();
        let path = folder.path().join("sequence.toml");
        let text = "video = \"{camera}.mp4\"\n[[camera]]\nname = \"a\"\n\
                    [[camera]]\nname = \"b\"\nimages = \"pictures\"\n";
        fs::write(&path, text).unwrap();
        let cameras = Manifest::read(&path).unwrap().cameras;
        assert_eq!(cameras[0].video.as_deref(), Some(Path::new("a.mp4")));
        assert_eq!((&cameras[1].video, cameras[1].images.as_deref()), (&None, Some("pictures")));
    }
}
