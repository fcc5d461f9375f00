//! PFD99 Figs. 8–11: an arm that waves before three cameras, two seconds at 25 Hz; first the limb model, then the full
//! arm on what that found.
//!
//! Clouds of each frame from three pairs side by side, so that the arm's far side is never seen. Tracked points give
//! shoulder, elbow and wrist in every frame to 2 cm (PFD99 § 4.2). The limb model (three metaballs a limb) starts there:
//! its sizes from every tenth frame, then its motion in all. The full arm (fifteen metaballs) starts from the limb
//! model's joints and goes the same way.

mod sequence;

use std::error::Error;
use std::process::ExitCode;

use experiments::limb::{
    LimbErrors, aligned, cameras_in_front, edges, full_arm, joints, limb_arm, limb_errors, true_arm,
};
use experiments::picture::{Panel, colour, svg};
use experiments::run::Run;
use experiments::table::Table;
use kuva::plot::LegendPosition;
use maquette::body::{BodyModel, Motion, Posed, Shape};
use maquette::math::stats::median;
use nalgebra::{Point3, Vector3};

use sequence::{
    ArmFrame, FPS, FRAMES, Track, fit, joints_of, sequence, skin_off_mm, tracked_joints,
};

/// Frames that are drawn.
const SHOWN: [usize; 3] = [5, 15, 30];

/// A model's track and its errors, frame by frame.
struct Result {
    name: &'static str,
    title: &'static str,
    colour: &'static str,
    model: BodyModel,
    track: Track,
    errors: Vec<LimbErrors>,
    skin_mm: Vec<f64>,
}

fn main() -> std::result::Result<ExitCode, Box<dyn Error>> {
    let mut run = Run::start("pfd99_arm");
    run.setting("frames", FRAMES);
    run.setting("fps", FPS);
    let frames = sequence(&true_arm()?, &cameras_in_front(), run.seed());
    // 1. the limb model, from joints that tracked points give
    let limb = limb_arm()?;
    let limb_starts = starts(&limb, &tracked_joints(&frames, run.seed()));
    let limb_track = fit(&limb, &frames, &limb_starts);
    // 2. the full arm, from the limb model's joints
    let full = full_arm()?;
    let found: Vec<_> = (0..FRAMES).map(|i| joints_of(&limb, &limb_track, i)).collect();
    let full_track = fit(&full, &frames, &starts(&full, &found));
    let results = [
        Result::new("limb", "limb model", colour::ORANGE, limb, limb_track, &frames),
        Result::new("full", "full arm", colour::BLUE, full, full_track, &frames),
    ];
    report(&mut run, &results)?;
    run.picture("errors", &errors_picture(&results))?;
    run.picture("arm", &arm_picture(&results, &frames))?;
    Ok(run.finish()?)
}

/// The motions that bring a model of mean shape to given joints.
fn starts(model: &BodyModel, all: &[[Point3<f64>; 3]]) -> Vec<Motion> {
    let shape = Shape(model.statistics.mean.clone());
    all.iter().map(|targets| aligned(model, &shape, targets)).collect()
}

impl Result {
    fn new(
        name: &'static str,
        title: &'static str,
        colour: &'static str,
        model: BodyModel,
        track: Track,
        frames: &[ArmFrame],
    ) -> Self {
        let bodies = || track.motions.iter().map(|m| Posed::new(&model, &track.shape, m));
        let errors = bodies().zip(frames).map(|(body, f)| limb_errors(&body, &f.truth.posed()));
        let skin_mm = bodies().zip(frames).map(|(body, f)| skin_off_mm(&model, &body, f));
        Self {
            name,
            title,
            colour,
            errors: errors.collect(),
            skin_mm: skin_mm.collect(),
            model,
            track,
        }
    }
}

fn report(run: &mut Run, results: &[Result]) -> std::result::Result<(), Box<dyn Error>> {
    let mut table = Table::new(
        "arm",
        &[
            "model",
            "joints, mm",
            "elbow, °",
            "upper arm, mm",
            "forearm, mm",
            "widths, %",
            "skin, mm",
            "lost",
        ],
    );
    for result in results {
        let middle = |value: &dyn Fn(&LimbErrors) -> f64| {
            median(&mut result.errors.iter().map(value).collect()).unwrap_or(f64::NAN)
        };
        let lost = result.errors.iter().filter(|e| e.joints_mm > 50.0).count();
        let numbers = [
            ("joints_mm", middle(&|e| e.joints_mm)),
            ("elbow_deg", middle(&|e| e.elbow_deg.abs())),
            ("upper_arm_mm", middle(&|e| e.length_mm[0])),
            ("forearm_mm", middle(&|e| e.length_mm[1])),
            ("widths_pct", middle(&|e| 0.5 * (e.width_pct[0].abs() + e.width_pct[1].abs()))),
            ("skin_mm", median(&mut result.skin_mm.clone()).unwrap_or(f64::NAN)),
            ("frames_lost", lost as f64),
        ];
        for (name, value) in numbers {
            run.number(format!("{}_{name}", result.name), value);
        }
        let cells = numbers.iter().map(|(_, value)| format!("{value:.1}"));
        table.row(std::iter::once(result.title.to_owned()).chain(cells));
    }
    Ok(run.table("Medians over the frames", &table)?)
}

fn errors_picture(results: &[Result]) -> String {
    let panel = |title: &str, unit: &str, most: f64, value: &dyn Fn(&Result, usize) -> f64| {
        let empty = Panel::new(title, "frame", unit)
            .ranges((0.0, FRAMES as f64), (0.0, most))
            .legend(LegendPosition::OutsideRightTop);
        results.iter().fold(empty, |panel, result| {
            let curve: Vec<(f64, f64)> =
                (0..FRAMES).map(|i| (i as f64, value(result, i))).collect();
            panel.curve(result.title, result.colour, &curve)
        })
    };
    let panels = vec![
        panel("shoulder, elbow and wrist", "mean error, mm", 40.0, &|r, i| r.errors[i].joints_mm),
        panel("bend of the elbow", "error, °", 10.0, &|r, i| r.errors[i].elbow_deg.abs()),
        panel("true skin off the fitted", "mean distance, mm", 8.0, &|r, i| r.skin_mm[i]),
    ];
    svg(1, (640.0, 250.0), panels)
}

/// Some frames as the middle camera sees them, flattened.
fn arm_picture(results: &[Result], frames: &[ArmFrame]) -> String {
    let camera = &cameras_in_front().cameras[1];
    let sight = camera.optical_axis().direction_world.into_inner();
    let right = sight.cross(&Vector3::z());
    let right = right.try_normalize(1e-9).unwrap_or(Vector3::x());
    let panel = |result: &Result, i: usize| {
        let middle = joints(&frames[i].truth.posed())[1];
        let flat = |p: &Point3<f64>| (100.0 * (p - middle).dot(&right), 100.0 * (p.z - middle.z));
        let points: Vec<(f64, f64)> =
            frames[i].points.iter().map(|p| flat(&p.position_world)).collect();
        let fitted = Posed::new(&result.model, &result.track.shape, &result.track.motions[i]);
        let truth = frames[i].truth.posed();
        let title = format!("{}, frame {i}", result.title);
        let empty = Panel::new(&title, "right, cm", "up, cm")
            .ranges((-45.0, 45.0), (-45.0, 45.0))
            .equal_aspect()
            .marks("", "#c8d8e8", &points);
        [(&truth, colour::BLACK), (&fitted, result.colour)].into_iter().fold(
            empty,
            |panel, (body, colour)| {
                let bones: Vec<(f64, f64)> = joints(body).iter().map(flat).collect();
                let sides = edges(body, &right);
                let panel = sides.iter().fold(panel, |panel, edge| {
                    let edge: Vec<(f64, f64)> = edge.iter().map(flat).collect();
                    panel.curve("", colour, &edge)
                });
                panel.dashed("", colour, &bones)
            },
        )
    };
    let panels = results.iter().flat_map(|result| SHOWN.map(|i| panel(result, i)));
    svg(3, (330.0, 310.0), panels.collect())
}
