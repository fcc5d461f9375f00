//! `maquette sync`: a recording in, the beginning of each camera out.

use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::Args;
use maquette::pipeline::Progress;
use maquette::workflow::{SyncOptions, SyncedCamera, SyncedRecording};
use serde_json::{Value, json};

use super::camera_fit::{CameraFitArguments, check_free};
use super::error::CliError;
use super::said::Said;
use super::switches::{Output, Threads};
use super::table::Table;

pub(super) const ABOUT: &str = "\
Find when each camera began, from the person that they show.

Fits the recording, or reads the folder of a finished fit, and writes offsets.toml into the recording's folder, which the \
next fit reads. A long recording is looked at in three windows, which tell drift too. Where videos have sound, it is \
compared. A camera whose beginning the recording does not tell keeps what it had.";

pub(super) const EXAMPLES: &str = "\
Examples:
  maquette sync my-recording --fps 50
  maquette sync out/me                          (a finished fit: says and writes what it found)
  maquette sync my-recording --windows 5        (five windows of 100 frames, for drift)
  maquette sync my-recording --out elsewhere/offsets.toml";

/// Arguments of `maquette sync`.
#[derive(Debug, Args)]
pub(super) struct SyncArguments {
    /// A recording, or the folder of a finished fit
    recording: PathBuf,
    /// The file to write [default: offsets.toml in the recording's folder, where the next fit reads it]
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    #[command(flatten)]
    fit: CameraFitArguments,
    /// Look at so many windows of 100 frames, evenly over the recording [default: all frames up to 600, else 3 windows]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1000))]
    windows: Option<u16>,
    /// Do not listen to the sound of videos
    #[arg(long)]
    no_sound: bool,
    #[command(flatten)]
    threads: Threads,
    #[command(flatten)]
    output: Output,
}

/// Finds the clocks of a recording and writes them.
pub(super) fn run(arguments: &SyncArguments) -> Result<(), CliError> {
    arguments.said(&arguments.output.progress())?.print(arguments.output);
    Ok(())
}

impl SyncArguments {
    /// What there is to say of the clocks, which are written.
    pub(super) fn said(&self, progress: &dyn Progress) -> Result<Said, CliError> {
        self.threads.run(|| sync(self, progress))
    }

    /// The file to write, as far as it is known before the minutes that the fits take: of a finished fit the recording's folder is
    /// known only afterwards.
    fn expected_file(&self) -> PathBuf {
        let folder = match self.recording.is_dir() {
            true => self.recording.as_path(),
            false => self.recording.parent().unwrap_or(Path::new("")),
        };
        self.out.clone().unwrap_or_else(|| folder.join("offsets.toml"))
    }
}

fn sync(arguments: &SyncArguments, progress: &dyn Progress) -> Result<Said, CliError> {
    let start = Instant::now();
    let SyncArguments { recording, fit, .. } = arguments;
    let existing = fit.existing();
    check_free(&[arguments.expected_file()], existing)?;

    let options = SyncOptions {
        fit: fit.options(),
        windows: arguments.windows.map(usize::from),
        sound: !arguments.no_sound,
    };
    let synced = SyncedRecording::of(recording, fit.fps, &options, progress)?;
    let out = arguments.out.clone().unwrap_or_else(|| synced.file());
    check_free(std::slice::from_ref(&out), existing)?;
    synced.write(&out)?;

    let seconds = start.elapsed().as_secs_f64();
    let (text, json) = (text(&synced, &out, seconds), as_json(&synced, &out, seconds));
    Ok(Said { text, json, notes: synced.notes })
}

fn text(synced: &SyncedRecording, out: &Path, seconds: f64) -> String {
    let ms = |frames: f64| 1e3 * frames / synced.fps;
    let has_drift = synced.no_drift.is_none();
    let has_sound = synced.cameras.iter().any(|camera| camera.sound.is_some());
    let mut headings = vec!["camera", "began after, frames", "ms", "was"];
    headings.extend(has_drift.then_some("drift, ppm"));
    headings.extend(has_sound.then_some("by sound"));
    let mut table = Table::new(&headings);
    for camera in &synced.cameras {
        let found = camera.found.ok();
        let is_reference = camera.camera == synced.reference;
        let told = found.filter(|_| !is_reference);
        let [frames, in_ms] = told.map_or(["–".into(), "–".into()], |found| {
            let (frames, sd) = (found.offset_frames, found.sd_frames);
            [format!("{frames:+.2} ± {sd:.2}"), format!("{:+.1} ± {:.1}", ms(frames), ms(sd))]
        });
        let mut cells =
            vec![camera.camera.clone(), frames, in_ms, format!("{:+.2}", camera.was_frames)];
        let drift = found.and_then(|found| found.drift);
        let drift =
            drift.map_or("–".into(), |drift| format!("{:+.0} ± {:.0}", drift.ppm, drift.sd_ppm));
        cells.extend(has_drift.then_some(drift));
        cells.extend(has_sound.then(|| sound(camera)));
        table.row(cells);
    }

    let against = format!(
        "  against {}, whose clock is the recording's and which keeps its offset\n",
        synced.reference
    );
    let kept = synced.cameras.iter().filter_map(|camera| {
        Some(format!("  {} keeps its offset: {}\n", camera.camera, camera.found.err()?))
    });
    let no_drift = synced.no_drift.iter().map(|why| format!("  {why}\n"));
    let notes: String = [against].into_iter().chain(kept).chain(no_drift).collect();
    format!("{}{notes}{} in {seconds:.1} s\n", table.text(), out.display())
}

fn sound(camera: &SyncedCamera) -> String {
    camera.sound.as_ref().map_or("–".into(), |check| {
        let word = if check.agrees { "agrees" } else { "DIFFERS" };
        format!(
            "{:+.2} ± {:.2} after {}: {word}",
            check.after_frames, check.sd_frames, check.against
        )
    })
}

fn as_json(synced: &SyncedRecording, out: &Path, seconds: f64) -> Value {
    let ms = |frames: f64| 1e3 * frames / synced.fps;
    let camera = |camera: &SyncedCamera| {
        let found = camera.found.ok();
        let drift = found.and_then(|found| found.drift);
        json!({
            "camera": camera.camera,
            "kept": camera.found.err(),
            "was_frames": camera.was_frames,
            "offset_frames": found.map(|f| f.offset_frames),
            "sd_frames": found.map(|f| f.sd_frames),
            "offset_ms": found.map(|f| ms(f.offset_frames)),
            "sd_ms": found.map(|f| ms(f.sd_frames)),
            "drift_ppm": drift.map(|d| d.ppm),
            "drift_sd_ppm": drift.map(|d| d.sd_ppm),
            "sound": camera.sound.as_ref().map(|check| json!({
                "against": check.against, "after_frames": check.after_frames, "sd_frames": check.sd_frames,
                "agrees": check.agrees,
            })),
        })
    };
    json!({
        "file": out.display().to_string(),
        "seconds": seconds,
        "fps": synced.fps,
        "reference": synced.reference,
        "windows": synced.windows,
        "no_drift": synced.no_drift,
        "cameras": synced.cameras.iter().map(camera).collect::<Vec<_>>(),
        "notes": synced.notes,
    })
}
