//! Recordings of other makes of body than ours, which are shared by projects: how far joint centres are from the truth, and whether
//! their stated standard deviations are true; of all cameras, of two of them, and at half the frame rate.
//!
//! A limb is *wrong* if its tip is more than 10 cm off in more than a tenth of the frames: exchanged, or lost behind the body. It is
//! announced if a note names the limb, or says that left and right can be exchanged.
//!
//! Starts: the body is found from nothing, as `maquette fit` does it.

use std::error::Error;
use std::process::ExitCode;

use experiments::figures::{fitted, shares, shares_text};
use experiments::metrics::{INTERVALS, point, rms};
use experiments::recorded::Recorded;
use experiments::run::{Run, shared_data};
use experiments::table::Table;
use maquette::camera::{Camera, Rig};
use maquette::inference::search::{Origin, Pruning, SearchOptions};
use maquette::io::points::trc::Trajectories;
use maquette::math::stats::mean;
use maquette::pipeline::{CameraQuality, EstimateOptions, Fit, TriedHypothesis, Warning};
use nalgebra::Vector2;

/// A recording, and its frames per second.
type Set = (&'static str, f64);

/// Persons of other makes of body.
const SETS: [Set; 6] = [
    ("walk7", 50.0),
    ("walk7-noisy", 50.0),
    ("dressed", 50.0),
    ("moved", 50.0),
    ("trinocular", 25.0),
    ("treadmill", 25.0),
];
/// Those whose coverage is pooled.
const POOLED: usize = 5;
/// Those of which pairs of cameras are taken.
const PAIRED: [Set; 3] = [("walk7", 50.0), ("dressed", 50.0), ("moved", 50.0)];
/// Pairs of each that look at each other, and that look across each other.
const FACING: usize = 2;
const ACROSS: usize = 3;

/// The tips of limbs: joint, and part.
const TIPS: [(&str, &str); 4] =
    [("RAnkle", "foot_r"), ("LAnkle", "foot_l"), ("RWrist", "hand_r"), ("LWrist", "hand_l")];
/// When a limb is wrong.
const FAR_M: f64 = 0.1;
const OFTEN: f64 = 0.1;

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let mut run = Run::start("recordings");
    if !shared_data().is_dir() {
        run.say(&format!("skipped: no recordings in {}", shared_data().display()));
        return Ok(ExitCode::SUCCESS);
    }
    all_cameras(&mut run)?;
    if !run.is_quick() {
        cameras_that_are_off(&mut run)?;
        two_cameras(&mut run)?;
        half_the_rate(&mut run)?;
    }
    Ok(run.finish()?)
}

/// Every recording with all of its cameras, where they were.
fn all_cameras(run: &mut Run) -> Result<(), Box<dyn Error>> {
    let header =
        ["set", "mm", "without offset", "lengths, %", "knee, °", "RMS z", "50 · 80 · 95 %"];
    let mut table = Table::new("all_cameras", &header);
    let sets = if run.is_quick() { &SETS[..1] } else { &SETS[..] };
    let mut pooled = Vec::new();
    for (number, (name, fps)) in sets.iter().enumerate() {
        let recorded = read(name, *fps)?;
        let fit = recorded.fit()??;
        let figures = recorded.figures(&fit);
        table.row([
            (*name).to_owned(),
            format!("{:.1}", figures.raw_mm),
            format!("{:.1}", figures.offset_mm),
            format!("{:.1}", figures.lengths_pct),
            format!("{:.1}", figures.knee_deg),
            format!("{:.2}", rms(figures.z.iter().copied())),
            shares_text(&figures.z),
        ]);
        run.number(format!("{name}_mm"), figures.raw_mm);
        run.number(format!("{name}_z"), rms(figures.z.iter().copied()));
        if number < POOLED {
            pooled.extend(figures.z);
        }
    }
    run.table("All cameras", &table)?;
    if run.is_quick() {
        return Ok(());
    }
    for ((percent, _), share) in INTERVALS.into_iter().zip(shares(&pooled)) {
        run.number(format!("pooled_{percent}"), share);
    }
    Ok(())
}

/// Cameras that were touched after their calibration, and clocks that disagree.
fn cameras_that_are_off(run: &mut Run) -> Result<(), Box<dyn Error>> {
    let moved = Recorded::read(&shared_data().join("moved"), 50.0, "truth.trc")?;
    let truly = Recorded { rig: moved.true_rig.clone(), ..moved.clone() };
    let (found, best) = (moved.fit()??, truly.fit()??);
    let (with, without) = (moved.figures(&found), truly.figures(&best));
    run.number("moved_found_over_true", with.raw_mm / without.raw_mm);
    run.number("moved_found_over_true_offset", with.offset_mm / without.offset_mm);
    let (mut turn_deg, mut place_mm, mut wrongly) = (0.0_f64, 0.0_f64, 0);
    let rigs = moved.rig.cameras.iter().zip(&moved.true_rig.cameras);
    for ((before, after), quality) in rigs.zip(&found.cameras) {
        let rotation = |camera: &Camera| camera.camera_from_world.rotation;
        let turn = rotation(after).inverse() * rotation(before);
        let place = after.centre_world() - before.centre_world();
        let is_touched = turn.angle() > 1e-6;
        let offset = quality.found.offset();
        let was_touched = quality.found.pose.is_some_and(|pose| pose.was_touched());
        wrongly += usize::from(is_touched != was_touched);
        turn_deg = turn_deg.max(offset.turn.angle_to(&turn).to_degrees());
        place_mm = place_mm.max(1e3 * (offset.displacement_m - place).norm());
    }
    run.number("moved_turn_deg", turn_deg);
    run.number("moved_displacement_mm", place_mm);
    run.number("moved_named_wrongly", f64::from(u32::try_from(wrongly)?));

    let clocks = Recorded::read(&shared_data().join("clocks"), 50.0, "truth.trc")?;
    let text = std::fs::read_to_string(shared_data().join("clocks/truth.json"))?;
    let truth: serde_json::Value = serde_json::from_str(&text)?;
    let fit = clocks.fit()??;
    let ahead = truth["clock_offsets_frames"].as_array().map_or(&[][..], Vec::as_slice);
    let off = |(truth, quality): (&serde_json::Value, &CameraQuality)| {
        Some((quality.found.offset().ahead_s * clocks.fps - truth.as_f64()?).abs())
    };
    let worst = ahead.iter().zip(&fit.cameras).filter_map(off).fold(0.0, f64::max);
    run.number("clocks_frames", worst);
    run.number("clocks_mm", clocks.figures(&fit).raw_mm);
    Ok(())
}

/// Pairs of cameras.
fn two_cameras(run: &mut Run) -> Result<(), Box<dyn Error>> {
    let header = ["set", "cameras", "apart, °", "mm", "RMS z", "50 · 80 · 95 %", "wrong", "said"];
    let mut table = Table::new("two_cameras", &header);
    let (mut pooled, mut unannounced) = (Vec::new(), 0);
    for (name, fps) in PAIRED {
        let recorded = read(name, fps)?;
        for (degrees, pair) in pairs(&recorded) {
            let seen = recorded.with_cameras(&pair);
            let fit = seen.fit()??;
            let figures = seen.figures(&fit);
            let wrong = wrong_limbs(&seen.truth, &fitted(&fit, fps));
            let is_announced = wrong.iter().all(|part| announces(&fit, part));
            unannounced += usize::from(!is_announced);
            table.row([
                name.to_owned(),
                format!("{} {}", pair[0] + 1, pair[1] + 1),
                format!("{degrees:.0}"),
                format!("{:.0}", figures.raw_mm),
                format!("{:.2}", rms(figures.z.iter().copied())),
                shares_text(&figures.z),
                wrong.join(" "),
                match (wrong.is_empty(), is_announced) {
                    (true, _) => String::new(),
                    (false, true) => "announced".to_owned(),
                    (false, false) => "**not announced**".to_owned(),
                },
            ]);
            pooled.extend(figures.z);
        }
    }
    run.table("Two cameras", &table)?;
    run.number("two_cameras_95", shares(&pooled)[2]);
    run.number("two_cameras_unannounced", f64::from(u32::try_from(unannounced)?));
    Ok(())
}

/// The same person at half the frame rate: by which factors standard deviations and log odds grow.
///
/// The odds are those of two bodies that both follow the person, the winner and the mean. A hypothesis that is lost, as the other way of facing is
/// before seven cameras, is farther off the longer a step is, and says nothing of how data are counted.
fn half_the_rate(run: &mut Run) -> Result<(), Box<dyn Error>> {
    let recorded = read("walk7", 50.0)?;
    let half = recorded.with_every(2);
    let search = SearchOptions { pruning: Pruning::Off, ..SearchOptions::default() };
    let options = EstimateOptions { search, ..EstimateOptions::default() };
    let (all, half) = (recorded.fit_with(options.clone())??, half.fit_with(options)??);

    let ratios = all.frames.iter().step_by(2).zip(&half.frames).flat_map(|(all, half)| {
        let (all, half) = (all.uncertainty.as_ref(), half.uncertainty.as_ref());
        let points = all.zip(half).map(|(all, half)| all.points.iter().zip(&half.points));
        points.into_iter().flatten().map(|(all, half)| (half.trace() / all.trace()).sqrt())
    });
    run.number("half_rate_points_sd", mean(ratios).unwrap_or(f64::NAN));
    let lengths = all.uncertainty.as_ref().zip(half.uncertainty.as_ref());
    let lengths = lengths.into_iter().flat_map(|(all, half)| {
        all.lengths_sd_m.iter().zip(&half.lengths_sd_m).map(|(all, half)| half / all)
    });
    run.number("half_rate_lengths_sd", mean(lengths).unwrap_or(f64::NAN));
    run.number("half_rate_odds", odds_of_mean(&half) / odds_of_mean(&all));
    Ok(())
}

/// Log odds of the winner against the mean body; NaN if that was not followed to the end.
fn odds_of_mean(fit: &Fit) -> f64 {
    let is_mean = |tried: &&TriedHypothesis| {
        tried.trial.hypothesis.origin == Origin::Prior && tried.trial.finished()
    };
    let mean = fit.hypotheses.iter().find(is_mean);
    let won = &fit.hypotheses[fit.winner].trial;
    let data_weight = fit.noise.map_or(1.0, |noise| noise.data_weight());
    mean.map_or(f64::NAN, |mean| data_weight * (mean.trial.energy() - won.energy()))
}

fn read(name: &str, fps: f64) -> Result<Recorded, Box<dyn Error>> {
    let recorded = Recorded::read(&shared_data().join(name), fps, "truth.trc")?;
    Ok(Recorded { rig: recorded.true_rig.clone(), ..recorded })
}

/// Pairs of cameras that look at each other most nearly, and across each other, and by how much they are apart.
fn pairs(recorded: &Recorded) -> Vec<(f64, [usize; 2])> {
    let Rig { cameras } = &recorded.rig;
    let centres: Vec<Vector2<f64>> =
        cameras.iter().map(|camera| camera.centre_world().coords.xy()).collect();
    let middle = centres.iter().sum::<Vector2<f64>>() / centres.len() as f64;
    let apart = |a: usize, b: usize| (centres[a] - middle).angle(&(centres[b] - middle));
    let pairs = (0..cameras.len()).flat_map(|b| (0..b).map(move |a| [a, b]));
    let mut all: Vec<_> = pairs.map(|[a, b]| (apart(a, b).to_degrees(), [a, b])).collect();

    all.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut kept = all[..FACING].to_vec();
    all.sort_by(|a, b| (a.0 - 90.0).abs().total_cmp(&(b.0 - 90.0).abs()));
    kept.extend_from_slice(&all[..ACROSS]);
    kept
}

/// The tips of the limbs that are wrong.
fn wrong_limbs(truth: &Trajectories, fitted: &Trajectories) -> Vec<&'static str> {
    let is_wrong = |(joint, _): &&(&str, &str)| {
        let error =
            |frame| Some((point(truth, joint, frame)? - point(fitted, joint, frame)?).norm());
        let errors: Vec<f64> = (0..truth.frames.len()).filter_map(error).collect();
        let far = errors.iter().filter(|error| **error > FAR_M).count();
        far as f64 > OFTEN * errors.len() as f64
    };
    TIPS.iter().filter(is_wrong).map(|(_, part)| *part).collect()
}

/// Whether a note says that a limb may be elsewhere.
fn announces(fit: &Fit, part: &str) -> bool {
    let names = |warning: &Warning| match warning {
        Warning::HiddenLimbs { limbs } => limbs.iter().any(|(tip, _)| tip == part),
        Warning::OneOutline => true,
        _ => false,
    };
    fit.warnings.iter().any(names)
}
