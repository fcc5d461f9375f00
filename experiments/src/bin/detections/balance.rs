//! A real recording of a man in a room with others (`balance`): how much of the masks the body covers, and how well it predicts what a
//! camera sees that is left out. Fitted to detections alone it never sees the masks.
//!
//! The distances are medians over joints and frames, with each joint's median offset taken away: what a detector means by a joint, and where a
//! camera looks that was touched, is the same in all frames.

use std::collections::BTreeMap;
use std::error::Error;
use std::path::Path;

use experiments::run::Run;
use experiments::table::Table;
use maquette::body::Posed;
use maquette::body::metaball::Field;
use maquette::camera::{CameraId, Rig};
use maquette::io::recording::{ObservationFiles, Recording};
use maquette::math::stats::{mean, median};
use maquette::render;
use maquette::silhouette::{FrameIndex, Keypoint};
use maquette::{FitOptions, FittedRecording};
use nalgebra::{Point2, Point3, Vector2};
use rayon::prelude::*;

const FPS: f64 = 60.0;

/// What is fitted to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Shown {
    Detections,
    Both,
}

impl Shown {
    /// What the names of its numbers begin with.
    fn prefix(self) -> &'static str {
        match self {
            Self::Detections => "",
            Self::Both => "both_",
        }
    }

    fn table(self) -> &'static str {
        match self {
            Self::Detections => "balance",
            Self::Both => "balance_both",
        }
    }

    fn words(self) -> &'static str {
        match self {
            Self::Detections => "detections alone",
            Self::Both => "masks and detections",
        }
    }
}

/// Overlaps and predictions of the recording in this folder; `--quick`: by detections alone.
pub(crate) fn run(run: &mut Run, folder: &Path) -> Result<(), Box<dyn Error>> {
    let whole = Recording::open(folder)?.with_fps(FPS).observations()?;
    let names: Vec<String> = whole.rig.names().map(str::to_owned).collect();
    let all = [Shown::Detections, Shown::Both];
    for shown in all.into_iter().take(if run.is_quick() { 1 } else { 2 }) {
        let mut table =
            Table::new(shown.table(), &["camera", "overlap", "left out: joints off, px"]);
        let mut overlaps: Vec<f64> = overlaps(&fitted(folder, &names, shown)?, &whole)?;
        let mut left_out = Vec::new();
        for ((id, camera), overlap) in whole.rig.iter().zip(&overlaps) {
            let others: Vec<String> =
                names.iter().filter(|n| **n != camera.name).cloned().collect();
            let off = prediction_off_px(&fitted(folder, &others, shown)?, &whole, id)?;
            table.row([camera.name.clone(), format!("{overlap:.3}"), format!("{off:.1}")]);
            left_out.push(off);
        }
        run.table(&format!("balance, {}", shown.words()), &table)?;
        let prefix = shown.prefix();
        run.number(format!("{prefix}overlap"), median(&mut overlaps).unwrap_or(0.0));
        run.number(format!("{prefix}left_out_px"), median(&mut left_out).unwrap_or(f64::INFINITY));
    }
    Ok(())
}

/// A fit to some cameras.
fn fitted(
    folder: &Path,
    cameras: &[String],
    shown: Shown,
) -> Result<FittedRecording, Box<dyn Error>> {
    let folder = folder.canonicalize()?;
    let at = |path: &str| folder.join(path).display().to_string();
    let camera = |name: &String| {
        let number = name.trim_start_matches(|c: char| !c.is_ascii_digit());
        let pose = ["cam", "cam_"].map(|start| at(&format!("pose/{start}{number}_json")));
        let pose = pose.iter().find(|path| Path::new(path).is_dir()).cloned().unwrap_or_default();
        let masks = match shown {
            Shown::Detections => String::new(),
            Shown::Both => format!("masks = {:?}\n", at(&format!("masks/{name}"))),
        };
        format!("[[camera]]\nname = {name:?}\ndetections = {pose:?}\n{masks}")
    };
    let cameras: String = cameras.iter().map(camera).collect();
    let text = format!("fps = {FPS}\ncalibration = {:?}\n{cameras}", at("calibration.toml"));
    let own = std::env::temp_dir().join(format!("maquette-detections-{}", std::process::id()));
    std::fs::create_dir_all(&own)?;
    std::fs::write(own.join("sequence.toml"), text)?;
    let fit = Recording::open(&own)?.fit(&FitOptions::default());
    std::fs::remove_dir_all(&own)?;
    Ok(fit?)
}

/// The mean overlap with each camera's masks, where the fit found the camera.
fn overlaps(fit: &FittedRecording, masks: &ObservationFiles) -> Result<Vec<f64>, Box<dyn Error>> {
    let rig: Rig = fit.result.rig(&masks.rig);
    let shape = fit.result.shape_of(&fit.model)?;
    let overlap = |id: CameraId| -> Result<f64, Box<dyn Error>> {
        let camera = &rig.cameras[id.0];
        let of_frame = |frame: &maquette::io::result::FramePart| {
            let mask = masks.load_mask(id, FrameIndex(frame.frame)).ok().flatten()?;
            let motion = frame.motion();
            let field = Field::from_body(&Posed::new(&fit.model, &shape, &motion));
            let body = render::silhouette(camera, &field);
            let (mut both, mut either) = (0_usize, 0_usize);
            for (y, x) in (0..mask.height()).flat_map(|y| (0..mask.width()).map(move |x| (y, x))) {
                let (a, b) = (mask.is_foreground(x, y), body.is_foreground(x, y));
                both += usize::from(a && b);
                either += usize::from(a || b);
            }
            (either > 0).then(|| both as f64 / either as f64)
        };
        let all: Vec<f64> =
            fit.result.motion.frames.par_iter().step_by(5).filter_map(of_frame).collect();
        Ok(mean(all).unwrap_or(0.0))
    };
    masks.rig.iter().map(|(id, _)| overlap(id)).collect()
}

/// How far the detections of a camera lie from what the fit predicts there, px.
fn prediction_off_px(
    fit: &FittedRecording,
    whole: &ObservationFiles,
    id: CameraId,
) -> Result<f64, Box<dyn Error>> {
    let camera = &whole.rig.cameras[id.0];
    let mut offsets: BTreeMap<&'static str, Vec<Vector2<f64>>> = BTreeMap::new();
    for frame in &fit.result.motion.frames {
        let at = |name: &str| -> Option<Point2<f64>> {
            let index = fit.result.motion.points.iter().position(|point| point == name)?;
            camera.project_undistorted(&Point3::from(frame.points_m[index]))
        };
        let off = |person: &[Keypoint]| -> Vec<(&'static str, Vector2<f64>)> {
            person.iter().filter_map(|k| Some((k.name, k.pixel - at(k.name)?))).collect()
        };
        let people = whole.people(id, FrameIndex(frame.frame))?;
        let middle = |off: &Vec<(&'static str, Vector2<f64>)>| {
            median(&mut off.iter().map(|(_, off)| off.norm()).collect()).unwrap_or(f64::INFINITY)
        };
        let own = people.iter().map(|person| off(person));
        let own = own.min_by(|a, b| middle(a).total_cmp(&middle(b))).unwrap_or_default();
        own.into_iter().for_each(|(name, off)| offsets.entry(name).or_default().push(off));
    }
    let mut all = Vec::new();
    for of_joint in offsets.values() {
        let usual = [0, 1].map(|k| median(&mut of_joint.iter().map(|off| off[k]).collect()));
        let usual = Vector2::from(usual.map(|value| value.unwrap_or(0.0)));
        all.extend(of_joint.iter().map(|off| (off - usual).norm()));
    }
    Ok(median(&mut all).unwrap_or(f64::INFINITY))
}
