//! Pictures of frames as a film, by the installed program `ffmpeg`.

use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

/// Writes PNG files, in order, as a film (H.264 in MP4) of `fps` frames per second; a frame without a picture repeats the one
/// before. Gives the reason, in one line, why there is no film.
pub(super) fn write(film: &Path, frames: &[Option<PathBuf>], fps: f64) -> Result<(), String> {
    let known = frames.iter().position(Option::is_some);
    let Some(first) = known else {
        return Ok(());
    };
    let mut encoder = start(film, fps).map_err(|fault| match fault.kind() {
        io::ErrorKind::NotFound => "the program ffmpeg is not installed".to_owned(),
        _ => format!("ffmpeg cannot be run: {fault}"),
    })?;
    let written = feed(&mut encoder, &frames[first..]);
    let output = encoder.wait_with_output().map_err(|fault| format!("ffmpeg: {fault}"))?;
    if !output.status.success() {
        let said = String::from_utf8_lossy(&output.stderr);
        let last = said.lines().rfind(|line| !line.trim().is_empty()).unwrap_or("it failed");
        return Err(format!("ffmpeg: {last}"));
    }
    written.map_err(|fault| format!("ffmpeg: {fault}"))
}

fn start(film: &Path, fps: f64) -> io::Result<Child> {
    Command::new("ffmpeg")
        .args(["-v", "fatal", "-f", "image2pipe", "-c:v", "png", "-framerate"])
        .arg(fps.to_string())
        .args(["-i", "-", "-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2", "-c:v", "libx264"])
        .args(["-pix_fmt", "yuv420p", "-crf", "20", "-movflags", "+faststart", "-f", "mp4", "-y"])
        .arg(film)
        .stdin(Stdio::piped())
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
}

/// Sends all pictures and closes the pipe.
fn feed(encoder: &mut Child, frames: &[Option<PathBuf>]) -> io::Result<()> {
    let Some(mut pipe) = encoder.stdin.take() else {
        return Ok(());
    };
    let mut bytes = Vec::new();
    for path in frames {
        if let Some(path) = path {
            bytes = fs::read(path)?;
        }
        pipe.write_all(&bytes)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::Picture;
    use crate::io::folder::png::{Effort, encode_picture};

    #[test]
    fn a_film_lasts_as_long_as_its_frames_also_where_one_is_missing() {
        let folder = tempfile::tempdir().unwrap();
        let picture = |k: usize| {
            let path = folder.path().join(format!("{k}.png"));
            // an odd size, which the encoder does not take
            let grey = Picture::filled(81, 61, [60 * k as u8; 3]);
            fs::write(&path, encode_picture(&grey, Effort::Quick).unwrap()).unwrap();
            Some(path)
        };
        let film = folder.path().join("50 %d.mp4");
        let frames = [None, picture(1), picture(2), None, picture(3)];
        if let Err(reason) = write(&film, &frames, 25.0) {
            assert!(reason.contains("not installed"), "{reason}");
            return;
        }
        let said = Command::new("ffprobe")
            .args(["-v", "error", "-count_packets", "-show_entries"])
            .args(["stream=width,nb_read_packets,avg_frame_rate", "-of", "csv=p=0"])
            .arg(&film)
            .output()
            .unwrap();
        assert_eq!(String::from_utf8_lossy(&said.stdout).trim(), "82,25/1,4");
    }
}
