//! The loudness of a video's sound, out of `ffmpeg`'s pipe.

use std::io::{BufReader, Read};
use std::path::Path;
use std::process::{Command, Stdio};

use serde::Deserialize;

use super::FootageError;
use super::probe::cannot_run;
use crate::pipeline::ENVELOPE_HZ;

/// Samples a second that are decoded: a clap's onset lies below half of it.
const RATE_HZ: usize = 8000;

/// What a video sounds like.
#[derive(Debug, Clone, PartialEq)]
pub struct Loudness {
    /// When its sound begins, seconds after its first picture.
    pub start_s: f64,
    /// Mean square of the samples, in steps of 1/[`ENVELOPE_HZ`].
    pub energy: Vec<f32>,
}

#[derive(Deserialize)]
struct Answer {
    #[serde(default)]
    streams: Vec<Stream>,
}

#[derive(Deserialize)]
struct Stream {
    codec_type: Option<String>,
    start_time: Option<String>,
}

impl Loudness {
    /// Of a video; `None` if it has no sound.
    ///
    /// # Errors
    /// [`FootageError`] where `ffmpeg` is not installed or cannot be run.
    pub fn of(path: &Path) -> Result<Option<Self>, FootageError> {
        let Some(start_s) = start_s(path)? else {
            return Ok(None);
        };
        let failed = |source| cannot_run(path, source);
        let mut child = Command::new("ffmpeg")
            .args(["-nostdin", "-hide_banner", "-loglevel", "error", "-i"])
            .arg(path)
            .args(["-map", "0:a:0", "-ac", "1", "-ar", &RATE_HZ.to_string(), "-f", "f32le", "-"])
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .map_err(failed)?;
        let energy = child.stdout.take().map(energies).unwrap_or_default();
        child.wait().map_err(failed)?;
        Ok((!energy.is_empty()).then_some(Self { start_s, energy }))
    }
}

/// When the sound begins after the pictures; `None` where there is none.
fn start_s(path: &Path) -> Result<Option<f64>, FootageError> {
    let output = Command::new("ffprobe")
        .args(["-v", "error", "-of", "json", "-show_entries", "stream=codec_type,start_time", "-i"])
        .arg(path)
        .stdin(Stdio::null())
        .output()
        .map_err(|source| cannot_run(path, source))?;
    let answer: Answer =
        serde_json::from_slice(&output.stdout).unwrap_or(Answer { streams: Vec::new() });
    let start = |kind: &str| {
        let of_kind = |stream: &&Stream| stream.codec_type.as_deref() == Some(kind);
        let stream = answer.streams.iter().find(of_kind)?;
        // a stream that does not say begins with the file
        Some(stream.start_time.as_ref().and_then(|t| t.parse::<f64>().ok()).unwrap_or(0.0))
    };
    Ok(start("audio").map(|sound| sound - start("video").unwrap_or(sound)))
}

/// Mean squares, step by step, of samples as they come.
fn energies(pipe: impl Read) -> Vec<f32> {
    let mut pipe = BufReader::with_capacity(1 << 16, pipe);
    let each = RATE_HZ / ENVELOPE_HZ as usize;
    let mut bytes = vec![0; 4 * each];
    let mut energies = Vec::new();
    // what is left at the end, or cannot be read, is less than a step
    while pipe.read_exact(&mut bytes).is_ok() {
        let samples = bytes.chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]]));
        let squares = samples.filter(|s| s.is_finite()).map(|s| s * s);
        energies.push(squares.sum::<f32>() / each as f32);
    }
    energies
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_become_mean_squares_and_what_is_left_is_none() {
        let samples = [0.5_f32; 20].map(f32::to_le_bytes).concat();
        assert_eq!(energies(&samples[..]), [0.25, 0.25]);
    }
}
