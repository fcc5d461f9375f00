//! Pictures out of `ffmpeg`'s pipe.
//!
//! The program decodes the first video stream, turns it as its metadata state, converts any pixel format to 8-bit RGB and
//! writes one PPM after another, each with its own size. The filter `showinfo` prints the time stamp of each picture
//! on standard error just before, so a picture is known by its time, not by its place.

use std::io::{self, BufRead, BufReader, Read};
use std::path::Path;
use std::process::{Child, ChildStderr, ChildStdout, Command, Stdio};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread::JoinHandle;

use super::FootageError;
use super::probe::cannot_run;
use crate::image::Picture;
use crate::io::recording::image_decoder::MOST_PX;

/// Longest line of a PPM's head.
const MOST_HEAD: usize = 64;

/// A video that is being decoded.
pub(super) struct Decoder {
    child: Child,
    pipe: BufReader<ChildStdout>,
    times_s: Receiver<f64>,
    complaints: Option<JoinHandle<Vec<String>>>,
}

impl Decoder {
    pub(super) fn start(path: &Path) -> Result<Self, FootageError> {
        let failed = |source| cannot_run(path, source);
        let mut child = decoding(path).spawn().map_err(failed)?;
        let (Some(pipe), Some(words)) = (child.stdout.take(), child.stderr.take()) else {
            let source = io::Error::other("its output is not there");
            return Err(FootageError::Ffmpeg { path: path.into(), source });
        };
        let (sender, times_s) = channel();
        Ok(Self {
            child,
            pipe: BufReader::with_capacity(1 << 20, pipe),
            times_s,
            complaints: Some(std::thread::spawn(move || listen(words, &sender))),
        })
    }

    /// The next picture and its time; `None` at the end.
    pub(super) fn next(&mut self) -> Option<(f64, Picture)> {
        let picture = read_ppm(&mut self.pipe)?;
        let time = self.times_s.recv().ok()?;
        Some((time, picture))
    }

    /// Ends the program; returns its errors.
    pub(super) fn finish(&mut self) -> Vec<String> {
        // it may have ended by itself
        let _ = self.child.kill();
        let _ = self.child.wait();
        let complaints = self.complaints.take().map(JoinHandle::join);
        complaints.and_then(Result::ok).unwrap_or_default()
    }
}

impl Drop for Decoder {
    fn drop(&mut self) {
        self.finish();
    }
}

/// The program that writes every picture of a video as PPM, and a line of text about each.
fn decoding(path: &Path) -> Command {
    let mut ffmpeg = Command::new("ffmpeg");
    ffmpeg
        .args(["-nostdin", "-hide_banner", "-nostats"])
        .args(["-loglevel", "level+info", "-copyts", "-i"])
        .arg(path)
        .args(["-map", "0:V:0", "-vf", "showinfo=checksum=0"])
        .args(["-fps_mode", "passthrough", "-pix_fmt", "rgb24"])
        .args(["-c:v", "ppm", "-f", "image2pipe", "-"])
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped());
    ffmpeg
}

/// Passes on the time of each picture; returns the errors.
fn listen(words: ChildStderr, times_s: &Sender<f64>) -> Vec<String> {
    let mut complaints = Vec::new();
    for line in BufReader::new(words).split(b'\n').map_while(Result::ok) {
        let line = String::from_utf8_lossy(&line);
        if let Some(time) = time_of(&line) {
            // whoever reads pictures may have stopped
            let _ = times_s.send(time);
        } else if let Some(complaint) = complaint(&line) {
            complaints.push(complaint);
        }
    }
    complaints
}

/// The time that `showinfo` states.
fn time_of(line: &str) -> Option<f64> {
    let rest = line.strip_prefix("[Parsed_showinfo")?;
    let (_, rest) = rest.split_once("pts_time:")?;
    rest.split_whitespace().next()?.parse().ok()
}

/// An error of the decoder. Errors about the pipe's own time stamps mean nothing.
fn complaint(line: &str) -> Option<String> {
    let (who, words) = line.split_once("[error]").or_else(|| line.split_once("[fatal]"))?;
    (!who.contains("image2pipe")).then(|| words.trim().into())
}

/// One binary PPM of 8 bits; `None` where the pipe ends, even within a picture.
fn read_ppm(pipe: &mut impl BufRead) -> Option<Picture> {
    let mut head = [(); 3].into_iter().map(|()| line(pipe));
    (head.next()??.trim() == "P6").then_some(())?;
    let size = head.next()??;
    (head.next()??.trim() == "255").then_some(())?;
    let (width, height) = size.trim().split_once(' ')?;
    let (width, height): (usize, usize) = (width.parse().ok()?, height.parse().ok()?);
    (width.max(height) <= MOST_PX as usize).then_some(())?;
    let mut pixels = vec![[0; 3]; width * height];
    pipe.read_exact(pixels.as_flattened_mut()).ok()?;
    Picture::from_values(width, height, pixels)
}

fn line(pipe: &mut impl BufRead) -> Option<String> {
    let mut text = String::new();
    let read = pipe.take(MOST_HEAD as u64).read_line(&mut text).ok()?;
    (read > 0).then_some(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_follow_each_other_in_the_pipe_each_with_its_size() {
        let mut pipe: &[u8] = b"P6\n2 1\n255\nabcdefP6\n1 1\n255\nxyzP6\n2 1\n255\nabc";
        let first = read_ppm(&mut pipe).unwrap();
        assert_eq!(first.values(), [*b"abc", *b"def"]);
        assert_eq!(read_ppm(&mut pipe).unwrap().values(), [*b"xyz"]);
        assert!(read_ppm(&mut pipe).is_none(), "cut off");
        assert!(read_ppm(&mut &b"P6\n99999 1\n255\n"[..]).is_none());
    }

    #[test]
    fn times_and_complaints_are_told_apart() {
        let line =
            "[Parsed_showinfo_0 @ 0x55] [info] n:   1 pts:    256 pts_time:0.0166667 pos: 89110";
        assert_eq!(time_of(line), Some(0.016_666_7));
        let damage = "[h264 @ 0x1] [error] error while decoding MB 3 4";
        assert_eq!(
            (time_of(damage), complaint(damage).as_deref()),
            (None, Some("error while decoding MB 3 4"))
        );
        assert_eq!(complaint("[image2pipe @ 0x5] [error] non monotonically increasing dts"), None);
        assert_eq!(complaint("[info] Stream #0:0"), None);
    }
}
