//! Tiny footage in temporary folders: picture k has the mean grey 20 + 8·k, and noise that makes its bytes many.

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};

use image::{DynamicImage, Rgb, RgbImage};
use maquette::Recording;
use maquette::camera::CameraId;
use maquette::io::recording::footage::{FootageNote, Pictures};
use tempfile::TempDir;

pub(crate) const SIZE: (u32, u32) = (64, 48);

/// A calibration of cameras of the given size.
pub(crate) fn calibration(cameras: &[&str], (width, height): (u32, u32)) -> String {
    let camera = |name: &&str| {
        format!(
            "[{name}]\nname = \"{name}\"\nsize = [{width}.0, {height}.0]\n\
             matrix = [[60.0, 0.0, 31.5], [0.0, 60.0, 23.5], [0.0, 0.0, 1.0]]\n\
             distortions = [0.0, 0.0, 0.0, 0.0]\nrotation = [1.2, 1.2, -1.2]\n\
             translation = [0.0, 0.0, 4.0]\nfisheye = false\n"
        )
    };
    cameras.iter().map(camera).collect()
}

pub(crate) fn write(folder: &TempDir, name: &str, bytes: impl AsRef<[u8]>) {
    let path = folder.path().join(name);
    fs::create_dir_all(path.parent().expect("a parent")).expect("a folder");
    fs::write(path, bytes).expect("a file");
}

/// An empty recording of cameras `a` and `b`.
pub(crate) fn folder() -> TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    write(&folder, "calibration.toml", calibration(&["a", "b"], SIZE));
    folder
}

pub(crate) fn image(folder: &TempDir, name: &str, grey: u8) {
    let path = folder.path().join(name);
    fs::create_dir_all(path.parent().expect("a parent")).expect("a folder");
    let picture = RgbImage::from_pixel(SIZE.0, SIZE.1, Rgb([grey; 3]));
    DynamicImage::from(picture).save(path).expect("an image");
}

/// Makes a video of `pictures` pictures with ffmpeg; says so and returns false where there is none.
pub(crate) fn video(folder: &TempDir, name: &str, pictures: usize, options: &[&str]) -> bool {
    let path = folder.path().join(name);
    fs::create_dir_all(path.parent().expect("a parent")).expect("a folder");
    let source =
        format!("nullsrc=s={}x{}:r=25,geq=lum='14+8*N+12*random(0)':cb=128:cr=128", SIZE.0, SIZE.1);
    let made = Command::new("ffmpeg")
        .args(["-nostdin", "-v", "error", "-y", "-f", "lavfi", "-i", &source])
        .args(["-frames:v", &pictures.to_string()])
        .args(options)
        .arg(path)
        .stdin(Stdio::null())
        .status();
    match made {
        Ok(status) => status.success(),
        Err(_) => {
            #[allow(clippy::print_stderr, reason = "a test that is skipped says so")]
            {
                eprintln!("skipped: no ffmpeg");
            }
            false
        }
    }
}

/// Number and mean brightness of each picture of the first camera, and the notes.
pub(crate) fn read(path: &Path, fps: Option<f64>) -> (Vec<(usize, f64)>, Vec<FootageNote>) {
    let footage =
        Recording::open(path).and_then(|found| found.with_fps(fps).footage()).expect("footage");
    greys(footage.stream(CameraId(0), 0..=usize::MAX))
}

pub(crate) fn greys(mut pictures: Pictures) -> (Vec<(usize, f64)>, Vec<FootageNote>) {
    let mut greys = Vec::new();
    for (frame, picture) in pictures.by_ref() {
        let sum: f64 = picture.values().as_flattened().iter().map(|v| f64::from(*v)).sum();
        greys.push((frame.0, sum / (3 * picture.width() * picture.height()) as f64));
    }
    (greys, pictures.notes().to_vec())
}

/// Grey of picture k as full-range RGB, from its limited-range luma.
pub(crate) fn expected(k: usize) -> f64 {
    (20.0 + 8.0 * k as f64 - 16.0) * 255.0 / 219.0
}

/// Whether each picture has the grey of its number.
pub(crate) fn are_in_place(greys: &[(usize, f64)]) -> bool {
    greys.iter().all(|(k, grey)| (grey - expected(*k)).abs() < 3.0)
}
