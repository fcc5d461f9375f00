//! Gait analysis against what is known: force plates under a real walk, and the true joint centres of `walk7`.
//!
//! The plates' foot strike and foot off are where the vertical force passes 20 N. The walk's markers are analysed as
//! they are, and once more with hips, knees, ankles and toes only, as a fit or a tracker of joint centres would give them.
//!
//! Starts: the body is found from nothing, as `maquette fit` does it.

use std::error::Error;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use experiments::recorded::read_trajectories;
use experiments::run::{Run, shared_data};
use experiments::table::Table;
use maquette::gait::{Angle, EventKind, GaitAnalysis, GaitOptions, Parameter, Side, analyse};
use maquette::io::gait::read_points;
use maquette::io::points::trc::{Trajectories, write_trc};
use maquette::math::stats::mean;
use maquette::{FitOptions, Recording};

/// Vertical force above which a foot is on a plate.
const ON_N: f64 = 20.0;

/// A foot's event on the plates, seconds.
type PlateEvent = (Side, EventKind, f64);

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let mut run = Run::start("gait_events");
    let data = shared_data();
    if !data.join("gait").is_dir() || !data.join("walk7").is_dir() {
        run.say(&format!("skipped: no recordings in {}", data.display()));
        return Ok(ExitCode::SUCCESS);
    }
    let out = tempfile(&run)?;
    events(&mut run, &data.join("gait"), &out)?;
    walk7(&mut run, &data.join("walk7"))?;
    Ok(run.finish()?)
}

/// Foot strike and foot off against the plates.
fn events(run: &mut Run, folder: &Path, out: &Path) -> Result<(), Box<dyn Error>> {
    let plates = plates(&std::fs::read_to_string(folder.join("grf_walk.mot"))?);
    let markers = folder.join("motion_capture_walk.trc");
    let few = out.join("joint_centres.trc");
    std::fs::write(&few, joint_centres(&markers)?)?;
    let mut table = Table::new("events", &["points", "event", "side", "plate, s", "off by, ms"]);
    for (points, path) in [("markers", &markers), ("joints", &few)] {
        let gait = gait_of(path)?;
        for kind in [EventKind::Strike, EventKind::Off] {
            let mut errors = Vec::new();
            for (side, _, plate_s) in plates.iter().filter(|(_, k, _)| *k == kind) {
                let own = gait.events.iter().filter(|e| e.side == *side && e.kind == kind);
                let off_by = own.map(|e| e.time_s - plate_s);
                let nearest = off_by.min_by(|a, b| a.abs().total_cmp(&b.abs()));
                // an event that was not found counts as a tenth of a second
                let error_ms = 1e3 * nearest.unwrap_or(0.1);
                table.row([
                    points.to_owned(),
                    format!("{kind:?}"),
                    side.name().to_owned(),
                    format!("{plate_s:.4}"),
                    format!("{error_ms:+.1}"),
                ]);
                errors.push(error_ms.abs());
            }
            let name = format!("{points}_{kind:?}_ms").to_lowercase();
            run.number(name, mean(errors).unwrap_or(f64::NAN));
        }
    }
    run.table("Events against the force plates", &table)?;
    Ok(())
}

/// Parameters against those of the true joint centres, and angles against the true ones.
fn walk7(run: &mut Run, folder: &Path) -> Result<(), Box<dyn Error>> {
    let recording = Recording::open(folder)?.with_fps(50.0);
    let fit = recording.fit(&FitOptions::default())?.gait()?.analysis;
    let truth = gait_of(&folder.join("truth.trc"))?;
    let mut table = Table::new("parameters", &["parameter", "side", "true joint centres", "fit"]);
    for (parameter, name, scale) in [
        (Parameter::StepLength, "step_length_mm", 1e3),
        (Parameter::StrideTime, "stride_time_ms", 1e3),
        (Parameter::Stance, "stance_percent", 1.0),
    ] {
        let mut errors = Vec::new();
        for side in Side::BOTH {
            let of = |gait: &GaitAnalysis| gait.parameters.get(&(parameter, side)).map(|s| s.mean);
            let Some(expected) = of(&truth) else { continue };
            let found = of(&fit).unwrap_or(f64::NAN);
            errors.push(scale * (found - expected).abs());
            let cells = [parameter.name().to_owned(), side.name().to_owned()];
            let numbers = [expected, found].map(|v| format!("{v:.4}"));
            table.row(cells.into_iter().chain(numbers));
        }
        run.number(name, mean(errors).unwrap_or(f64::NAN));
    }
    run.table("walk7: parameters", &table)?;
    angles(run, &fit, &folder.join("truth.json"))
}

fn angles(run: &mut Run, fit: &GaitAnalysis, truth: &Path) -> Result<(), Box<dyn Error>> {
    let truth: serde_json::Value = serde_json::from_str(&std::fs::read_to_string(truth)?)?;
    let mut table = Table::new("angles", &["angle", "side", "offset, °", "RMS without it, °"]);
    for (angle, name) in [
        (Angle::HipFlexion, "hip_flexion"),
        (Angle::KneeFlexion, "knee_angle"),
        (Angle::AnkleDorsiflexion, "ankle_angle"),
    ] {
        let mut all = Vec::new();
        for side in Side::BOTH {
            let key = format!("{name}_{}", &side.name()[..1]);
            let expected = truth["angles_deg"][&key].as_array().ok_or("no such angle")?;
            let found = fit.angles.get(&(side, angle)).ok_or("angle not found")?;
            let rows = found.iter().zip(expected);
            let apart: Vec<f64> = rows
                .filter_map(|(f, e)| Some(f.to_degrees() - e.as_f64()?))
                .filter(|d| d.is_finite())
                .collect();
            let offset = mean(apart.iter().copied()).unwrap_or(f64::NAN);
            let squares = apart.iter().map(|d| (d - offset).powi(2));
            let rms = mean(squares).unwrap_or(f64::NAN).sqrt();
            let cells = [angle.name().to_owned(), side.name().to_owned()];
            table.row(cells.into_iter().chain([offset, rms].map(|v| format!("{v:.2}"))));
            all.push(rms);
        }
        let name = format!("{}_deg", angle.name());
        run.number(name, mean(all).unwrap_or(f64::NAN));
    }
    run.table("walk7: angles", &table)?;
    Ok(())
}

fn gait_of(path: &Path) -> Result<GaitAnalysis, Box<dyn Error>> {
    Ok(analyse(&read_points(path, None)?.movement, &GaitOptions::default())?)
}

/// Where the vertical forces of the right and left plate (third and twelfth column) pass 20 N.
fn plates(text: &str) -> Vec<PlateEvent> {
    let rows = text.lines().skip_while(|line| line.trim() != "endheader").skip(2);
    let number = |cell: &str| cell.trim().parse::<f64>().ok();
    let rows: Vec<Vec<f64>> =
        rows.map(|row| row.split('\t').filter_map(number).collect()).collect();
    let mut events = Vec::new();
    for (side, column) in [(Side::Right, 2), (Side::Left, 11)] {
        for pair in rows.windows(2) {
            let on = |row: &Vec<f64>| row.get(column).is_some_and(|f| *f > ON_N);
            match (on(&pair[0]), on(&pair[1])) {
                (false, true) => events.push((side, EventKind::Strike, pair[1][0])),
                (true, false) => events.push((side, EventKind::Off, pair[1][0])),
                _ => {}
            }
        }
    }
    events
}

/// The same walk with the points of joint centres only: hips found from the pelvis, knees, ankles, toes.
fn joint_centres(markers: &Path) -> Result<String, Box<dyn Error>> {
    let all = read_trajectories(markers)?;
    let hips = read_points(markers, None)?.movement;
    let mut names = Vec::new();
    let mut columns = Vec::new();
    for (letter, side) in [("R", Side::Right), ("L", Side::Left)] {
        let hip = hips.paired_track(side, maquette::gait::Paired::Hip).ok_or("no hips")?;
        names.push(format!("{letter}Hip"));
        columns.push(hip.iter().map(|p| Some((*p).into())).collect::<Vec<_>>());
        for (name, marker) in [("Knee", "Knee"), ("Ankle", "Ankle"), ("BigToe", "Toe")] {
            let marker = format!("{letter}.{marker}");
            let column = all.names.iter().position(|n| *n == marker).ok_or("no such marker")?;
            names.push(format!("{letter}{name}"));
            columns.push(all.frames.iter().map(|f| f[column]).collect());
        }
    }
    let frame = |i: usize| columns.iter().map(|column| column[i]).collect();
    let frames = (0..all.frames.len()).map(frame).collect();
    let few = Trajectories { names, frames, ..all };
    Ok(write_trc(&few, "joint_centres.trc"))
}

/// A folder for what is made on the way.
fn tempfile(run: &Run) -> Result<PathBuf, Box<dyn Error>> {
    let folder = std::env::temp_dir().join(format!("maquette_gait_events_{}", run.seed()));
    std::fs::create_dir_all(&folder)?;
    Ok(folder)
}
