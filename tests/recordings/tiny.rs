//! Tiny recordings in temporary folders.

use std::fs;
use std::path::{Path, PathBuf};

use image::{DynamicImage, GrayImage, Luma};
use maquette::io::recording::{ObservationFiles, Recording, RecordingError};
use maquette::silhouette::{FrameObservations, SilhouetteOptions};
use tempfile::TempDir;

pub(crate) const SIZE: (u32, u32) = (64, 48);

pub(crate) fn is_person(x: u32, y: u32) -> bool {
    (20..40).contains(&x) && (10..40).contains(&y)
}

pub(crate) fn mask() -> DynamicImage {
    GrayImage::from_fn(SIZE.0, SIZE.1, |x, y| Luma([if is_person(x, y) { 255 } else { 0 }])).into()
}

pub(crate) fn write(path: PathBuf, bytes: impl AsRef<[u8]>) {
    fs::create_dir_all(path.parent().expect("a parent")).expect("a folder");
    fs::write(path, bytes).expect("a file");
}

pub(crate) fn save(path: PathBuf, image: &DynamicImage) {
    fs::create_dir_all(path.parent().expect("a parent")).expect("a folder");
    image.save(path).expect("an image");
}

pub(crate) fn calibration(cameras: &[&str]) -> String {
    let camera = |name: &&str| {
        format!(
            "[{name}]\nname = \"{name}\"\nsize = [64.0, 48.0]\n\
             matrix = [[60.0, 0.0, 31.5], [0.0, 60.0, 23.5], [0.0, 0.0, 1.0]]\n\
             distortions = [0.0, 0.0, 0.0, 0.0]\nrotation = [1.2, 1.2, -1.2]\n\
             translation = [0.0, 0.0, 4.0]\nfisheye = false\n"
        )
    };
    cameras.iter().map(camera).collect()
}

/// `calibration.toml` and three frames of masks for each camera, without manifest.
pub(crate) fn recording(cameras: &[&str]) -> TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    write(folder.path().join("calibration.toml"), calibration(cameras));
    for camera in cameras {
        for frame in 0..3 {
            save(folder.path().join(format!("masks/{camera}/{frame:06}.png")), &mask());
        }
    }
    folder
}

pub(crate) fn with_manifest(cameras: &[&str], manifest: &str) -> TempDir {
    let folder = recording(cameras);
    write(folder.path().join("sequence.toml"), manifest);
    folder
}

pub(crate) fn open(folder: &Path) -> Result<ObservationFiles, RecordingError> {
    Recording::open(folder).and_then(|found| found.with_fps(50.0).observations())
}

pub(crate) fn load(folder: &Path, position: usize) -> Result<FrameObservations, RecordingError> {
    open(folder)?.load_frame(position, &SilhouetteOptions::default())
}

/// The one line that says what is wrong.
fn complaint<T>(result: Result<T, RecordingError>) -> String {
    let Err(error) = result else {
        panic!("expected an error");
    };
    let message = error.to_string();
    assert!(!message.contains('\n'), "{message}");
    message
}

pub(crate) fn assert_complains<T>(result: Result<T, RecordingError>, parts: &[&str]) {
    let message = complaint(result);
    for part in parts {
        assert!(message.contains(part), "{part:?} is not in {message:?}");
    }
}
