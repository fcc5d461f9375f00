//! `maquette calibrate`: recordings in, a refined calibration out.

use std::path::PathBuf;
use std::time::Instant;

use clap::Args;
use maquette::io::calibration::check_name;
use maquette::pipeline::{POSE, Progress, Size};
use maquette::workflow::{LensRig, RefinedCamera, RefinedRig, UsedRecording};
use serde_json::{Value, json};

use super::camera_fit::{CameraFitArguments, check_free};
use super::choice::{Choice, one_of};
use super::error::CliError;
use super::lenses_found::{lenses_json, lenses_text};
use super::said::{Said, in_a_line};
use super::switches::{Output, Threads};
use super::table::Table;

pub(super) const ABOUT: &str = "\
Refine a calibration by a person who moves before the cameras.

Reads recordings of one calibration, or the folders of finished fits of them, and writes the calibration with each camera \
where the person shows it to be, and with the focal length that they show. The format follows from the name of OUT: *.toml (Pose2Sim, aniposelib), intri.yml \
(EasyMocap, with extri.yml), *.yml or *.xml (OpenCV), {camera}.yml or {camera}.xml (OpenCV, a file for each camera), \
*.qca.txt (Qualisys). A camera that the motion does not determine keeps its calibration. Distortion and principal points stay as they are.

With --from lenses the poses in the calibration are not read and need not be there: the cameras are placed by the detections of a person who walks \
through the room (pose/<camera>_json/), and then refined by the person's body. The person's height, or the distance of two cameras, says how \
large the room is. The world is that of the walk: z up, the floor at 0, x along the walk.";

pub(super) const EXAMPLES: &str = "\
Examples:
  maquette calibrate my-recording --fps 50 --out rig.toml
  maquette calibrate monday tuesday out/wednesday --fps 50 --out rig.toml    (out/wednesday: a finished fit)
  maquette calibrate out/me --out '{camera}.xml'
  maquette calibrate my-recording --fps 50 --from lenses --height 1.75 --out rig.toml
  maquette calibrate my-recording --fps 50 --from lenses --distance cam_01 cam_02 3.42 --out rig.toml";

/// Arguments of `maquette calibrate`.
#[derive(Debug, Args)]
pub(super) struct CalibrateArguments {
    /// Recordings, or folders of finished fits
    #[arg(required = true)]
    recordings: Vec<PathBuf>,
    /// The calibration to write
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// What is known of the cameras
    #[arg(long, value_name = "WHAT", default_value = "calibration", value_parser = one_of(&KNOWN))]
    from: Known,
    /// With --from lenses: the person's height without shoes, m [default: that of sequence.toml, or what people's bones are like]
    #[arg(long, value_name = "METRES", allow_negative_numbers = true, conflicts_with = "distance")]
    height: Option<f64>,
    /// With --from lenses: the distance of two cameras, m, in the place of the height
    #[arg(long, num_args = 3, value_names = ["CAMERA", "CAMERA", "METRES"], allow_negative_numbers = true)]
    distance: Option<Vec<String>>,
    #[command(flatten)]
    fit: CameraFitArguments,
    #[command(flatten)]
    threads: Threads,
    #[command(flatten)]
    output: Output,
}

/// What is known of the cameras.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Known {
    Calibration,
    Lenses,
}

static KNOWN: [Choice<Known>; 2] = [
    ("calibration", Known::Calibration, "lenses and places; the places are refined"),
    ("lenses", Known::Lenses, "lenses alone; the places are found by a person who walks"),
];

impl CalibrateArguments {
    /// What tells how large the world is.
    fn size(&self) -> Result<Size, CliError> {
        match (self.height, self.distance.as_deref()) {
            (Some(metres), _) => Ok(Size::Height(metres)),
            (None, Some([a, b, metres])) => {
                let expected = || format!("--distance: expected metres, found {metres:?}");
                let metres = metres.parse().map_err(|_| CliError::Arguments(expected()))?;
                Ok(Size::Distance { cameras: [a.clone(), b.clone()], metres })
            }
            _ => Ok(Size::Usual),
        }
    }

    /// The only recording, where lenses alone are known; `None` where the places are too.
    fn lenses_of(&self) -> Result<Option<&PathBuf>, CliError> {
        let fault = |text: &str| Err(CliError::Arguments(text.into()));
        match (self.from, self.recordings.as_slice()) {
            (Known::Calibration, _) if self.height.is_some() || self.distance.is_some() => {
                fault("--height and --distance are for --from lenses: a calibration has a size")
            }
            (Known::Calibration, _) => Ok(None),
            (Known::Lenses, [recording]) => Ok(Some(recording)),
            (Known::Lenses, _) => fault(
                "--from lenses: expected one recording; what it gives can be refined by others",
            ),
        }
    }
}

/// Refines a calibration and writes it.
pub(super) fn run(arguments: &CalibrateArguments) -> Result<(), CliError> {
    arguments.said(&arguments.output.progress())?.print(arguments.output);
    Ok(())
}

impl CalibrateArguments {
    /// What there is to say of the calibration, which is written.
    pub(super) fn said(&self, progress: &dyn Progress) -> Result<Said, CliError> {
        self.threads.run(|| calibrate(self, progress))
    }
}

fn calibrate(arguments: &CalibrateArguments, progress: &dyn Progress) -> Result<Said, CliError> {
    let start = Instant::now();
    let CalibrateArguments { recordings, out, fit, .. } = arguments;
    // before the minutes that the fits take
    check_name(out).map_err(maquette::Error::from)?;
    check_free(std::slice::from_ref(out), fit.existing())?;

    if let Some(recording) = arguments.lenses_of()? {
        let (size, options) = (arguments.size()?, fit.options());
        let found = LensRig::of(recording, fit.fps, size, &options, progress)?;
        check_free(&found.files(out)?, fit.existing())?;
        let written = found.write(out)?;
        let seconds = start.elapsed().as_secs_f64();
        let text = lenses_text(&found, &written, seconds);
        let json = lenses_json(&found, &written, seconds);
        return Ok(Said { text, json, notes: Vec::new() });
    }

    let rig = RefinedRig::of(recordings, fit.fps, &fit.options(), progress)?;
    check_free(&rig.files(out)?, fit.existing())?;
    let written = rig.write(out)?;
    let seconds = start.elapsed().as_secs_f64();
    let (text, json) = (text(&rig, &written, seconds), as_json(&rig, &written, seconds));
    Ok(Said { text, json, notes: rig.notes })
}

fn length(x: [f64; 3]) -> f64 {
    x.iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// Standard deviation of a length, of components that are taken to be independent.
fn length_sd(x: [f64; 3], sd: [f64; 3]) -> f64 {
    let norm = length(x);
    match norm > 0.0 {
        true => length([0, 1, 2].map(|i| x[i] * sd[i])) / norm,
        false => sd.into_iter().fold(0.0, f64::max),
    }
}

fn text(rig: &RefinedRig, written: &[PathBuf], seconds: f64) -> String {
    let mut table = Table::new(&["camera", "turned", "displaced", "focal length", "determined"]);
    for camera in &rig.cameras {
        let [turned, displaced, zoomed] = match &camera.found {
            Err(_) => ["–", "–", "–"].map(String::from),
            Ok(found) => {
                let (turn, turn_sd) = (found.turn_deg, found.turn_sd_deg);
                let (way, way_sd) = (found.displacement_m, found.displacement_sd_m);
                [
                    format!("{:.2} ± {:.2}°", length(turn), length_sd(turn, turn_sd)),
                    format!("{:.1} ± {:.1} mm", 1e3 * length(way), 1e3 * length_sd(way, way_sd)),
                    format!("{:+.2} ± {:.2} %", 100.0 * (found.zoom - 1.0), 100.0 * found.zoom_sd),
                ]
            }
        };
        let determined = format!("{:.1} of {POSE}", camera.determined);
        table.row(vec![camera.camera.clone(), turned, displaced, zoomed, determined]);
    }

    let kept = rig.cameras.iter().filter_map(|camera| {
        let why = camera.found.as_ref().err()?;
        Some(format!("  {} keeps its calibration: {why}\n", camera.camera))
    });
    let recordings = match rig.recordings.len() {
        1 => "1 recording".into(),
        count => format!("{count} recordings"),
    };
    format!(
        "{}{}{} from {recordings} in {seconds:.1} s\n",
        table.text(),
        kept.collect::<String>(),
        in_a_line(written)
    )
}

fn as_json(rig: &RefinedRig, written: &[PathBuf], seconds: f64) -> Value {
    let camera = |camera: &RefinedCamera| {
        let found = camera.found.as_ref().ok();
        json!({
            "camera": camera.camera,
            "kept": camera.found.as_ref().err(),
            "determined": camera.determined,
            "turn_deg": found.map(|f| f.turn_deg),
            "turn_sd_deg": found.map(|f| f.turn_sd_deg),
            "displacement_m": found.map(|f| f.displacement_m),
            "displacement_sd_m": found.map(|f| f.displacement_sd_m),
            "zoom": found.map(|f| f.zoom),
            "zoom_sd": found.map(|f| f.zoom_sd),
        })
    };
    let recording = |used: &UsedRecording| json!({ "path": used.path.display().to_string(), "frames": used.frames, "cameras": used.cameras });
    json!({
        "files": written.iter().map(|path| path.display().to_string()).collect::<Vec<_>>(),
        "seconds": seconds,
        "lenses": null,
        "recordings": rig.recordings.iter().map(recording).collect::<Vec<_>>(),
        "cameras": rig.cameras.iter().map(camera).collect::<Vec<_>>(),
        "notes": rig.notes,
    })
}
