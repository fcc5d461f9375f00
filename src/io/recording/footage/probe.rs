//! What `ffprobe` says of a video, without decoding it.

use std::io;
use std::path::Path;
use std::process::{Command, Stdio};

use serde::Deserialize;

use super::FootageError;
use super::numbers::Numbering;

/// What is known of a video before it is decoded.
#[derive(Debug, PartialEq)]
pub(super) struct Probe {
    /// Width and height as it is shown, turned as its metadata say.
    pub(super) size: [u32; 2],
    /// Mean number of pictures per second; `None` if the file does not say.
    pub(super) rate_hz: Option<f64>,
    /// Time of each picture in seconds, where the file says it of every one.
    times_s: Option<Vec<f64>>,
    /// How many pictures the file holds.
    pub(super) pictures: usize,
}

impl Probe {
    /// The numbering in a recording of `fps`.
    pub(super) fn numbering(&self, fps: f64) -> Numbering {
        match &self.times_s {
            Some(times) => Numbering::from_times(times.clone(), fps),
            None => {
                Numbering::Count { pictures: self.pictures, rate_hz: self.rate_hz.unwrap_or(fps) }
            }
        }
    }
}

#[derive(Deserialize)]
struct Answer {
    #[serde(default)]
    packets: Vec<Packet>,
    #[serde(default)]
    streams: Vec<Stream>,
}

#[derive(Deserialize)]
struct Packet {
    pts_time: Option<String>,
    /// When it is decoded: in the order of the file, also where pictures are not shown in that order.
    dts_time: Option<String>,
}

#[derive(Deserialize)]
struct Stream {
    width: Option<u32>,
    height: Option<u32>,
    avg_frame_rate: Option<String>,
    #[serde(default)]
    side_data_list: Vec<SideData>,
}

#[derive(Deserialize)]
struct SideData {
    rotation: Option<f64>,
}

/// Asks `ffprobe`.
pub(super) fn probe(path: &Path) -> Result<Probe, FootageError> {
    let output = Command::new("ffprobe")
        .args(["-v", "error", "-select_streams", "V:0", "-of", "json"])
        .args([
            "-show_entries",
            "stream=width,height,avg_frame_rate:stream_side_data=rotation:packet=pts_time,dts_time",
        ])
        .arg("-i")
        .arg(path)
        .stdin(Stdio::null())
        .output()
        .map_err(|source| cannot_run(path, source))?;

    let no_video = |reason: String| FootageError::NoVideo { path: path.into(), reason };

    if output.stdout.is_empty() {
        let reason = "ffprobe gave no answer: is ffmpeg fully installed?";
        return Err(no_video(reason.into()));
    }
    let answer: Answer =
        serde_json::from_slice(&output.stdout).map_err(|e| no_video(e.to_string()))?;
    let Some(stream) = answer.streams.first() else {
        return Err(no_video(last_words(&output.stderr)));
    };
    let (Some(width), Some(height)) = (stream.width, stream.height) else {
        return Err(no_video("the size of its pictures is not stated".into()));
    };
    if answer.packets.is_empty() || width == 0 || height == 0 {
        return Err(no_video("it holds no pictures".into()));
    }

    check_clock(path, &answer.packets)?;

    // turned by 90°, a picture is as wide as the stream is high
    let turned = stream.side_data_list.iter().find_map(|data| data.rotation);
    let is_upright = turned.is_none_or(|degrees| (degrees / 90.0).round() % 2.0 == 0.0);
    let times = answer.packets.iter().map(|p| p.pts_time.as_ref()?.parse().ok());

    Ok(Probe {
        size: if is_upright { [width, height] } else { [height, width] },
        rate_hz: stream.avg_frame_rate.as_deref().and_then(ratio),
        times_s: times.collect(),
        pictures: answer.packets.len(),
    })
}

/// Whether the clock of a video never jumps back.
fn check_clock(path: &Path, packets: &[Packet]) -> Result<(), FootageError> {
    let time_s = |packet: &Packet| packet.dts_time.as_ref()?.parse::<f64>().ok();
    let times: Option<Vec<f64>> = packets.iter().map(time_s).collect();
    let times = times.unwrap_or_default();
    match times.windows(2).position(|pair| pair[1] < pair[0]) {
        Some(at) => Err(FootageError::Backwards {
            path: path.into(),
            from_s: times[at],
            to_s: times[at + 1],
            picture: at + 2,
            pictures: packets.len(),
        }),
        None => Ok(()),
    }
}

/// The program is missing, or cannot be started.
pub(super) fn cannot_run(path: &Path, source: io::Error) -> FootageError {
    if source.kind() == io::ErrorKind::NotFound {
        FootageError::NoFfmpeg { path: path.into() }
    } else {
        FootageError::Ffmpeg { path: path.into(), source }
    }
}

/// The last line that a program printed, without its name tag.
fn last_words(stderr: &[u8]) -> String {
    let text = String::from_utf8_lossy(stderr);
    let last = text.lines().rfind(|line| !line.trim().is_empty());
    let last = last.unwrap_or("it has no video stream");
    last.rsplit_once(": ").map_or(last, |(_, words)| words).trim().into()
}

/// The value of a ratio like `60000/1001`, if it is positive.
fn ratio(text: &str) -> Option<f64> {
    let (over, under) = text.split_once('/')?;
    let value = over.parse::<f64>().ok()? / under.parse::<f64>().ok()?;
    (value > 0.0 && value.is_finite()).then_some(value)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rate_is_a_ratio_of_two_numbers_that_are_not_zero() {
        assert_eq!(ratio("60/1"), Some(60.0));
        assert_eq!(ratio("30000/1001"), Some(30_000.0 / 1001.0));
        for odd in ["0/0", "0/1", "25", "a/b", "-25/1"] {
            assert_eq!(ratio(odd), None, "{odd}");
        }
    }

    #[test]
    fn a_clock_that_jumps_back_is_refused_and_one_that_stands_still_is_not() {
        let packets = |times: &[f64]| {
            let packet = |t: &f64| Packet { pts_time: None, dts_time: Some(t.to_string()) };
            times.iter().map(packet).collect::<Vec<_>>()
        };
        let path = Path::new("a.ts");
        assert!(check_clock(path, &packets(&[0.0, 0.04, 0.04, 0.08])).is_ok());
        let fault = check_clock(path, &packets(&[1.0, 1.04, 0.0, 0.04])).unwrap_err();
        let text = fault.to_string();
        assert!(
            text.starts_with(
                "a.ts: the time stamps go backwards, from 1.040 s to 0.000 s at picture 3 of 4"
            ),
            "{text}"
        );
    }

    #[test]
    fn of_what_a_program_complains_the_last_words_are_kept() {
        let text =
            b"[mov] moov atom not found\nclip.mp4: Invalid data found when processing input\n";
        assert_eq!(last_words(text), "Invalid data found when processing input");
        assert_eq!(last_words(b""), "it has no video stream");
    }
}
