//! What is printed and checked.

use std::error::Error;

use experiments::metrics::{
    HIPS, KNEES, length_error_pct, mean_distance, mpjpe_mm, offset_mm, rms_deg,
};
use experiments::run::Run;
use experiments::table::Table;

use crate::fit::{Fit, Scene, Track};

pub(crate) fn report(run: &mut Run, scene: &Scene<'_>, fits: &[Fit]) -> Result<(), Box<dyn Error>> {
    numbers(run, scene, fits);
    run.table("Lengths, cm (difference from the truth, mm)", &lengths(scene, fits))?;
    run.table(
        "Likelihoods; hypotheses of the keyframes alone (ZS06)",
        &ablation("keyframes", scene, fits, |f| &f.keyframes),
    )?;
    run.table(
        "The joint optimum of all frames, from the most probable of them",
        &ablation("joint", scene, fits, |f| &f.joint),
    )?;
    Ok(())
}

fn figures(scene: &Scene<'_>, track: &Track) -> [(&'static str, f64); 7] {
    let (truth, fit) = (&scene.truth, &track.fit);
    let value = |figure: Option<f64>| figure.unwrap_or(f64::NAN);
    [
        ("mpjpe_mm", value(mpjpe_mm(truth, fit))),
        ("offset_mm", value(offset_mm(truth, fit))),
        ("length_error_pct", value(length_error_pct(truth, fit))),
        ("knee_deg", value(rms_deg(&KNEES, truth, fit))),
        ("hip_deg", value(rms_deg(&HIPS, truth, fit))),
        ("frames_lost", track.losses.frames as f64),
        ("searched_anew", track.searched_anew as f64),
    ]
}

fn numbers(run: &mut Run, scene: &Scene<'_>, fits: &[Fit]) {
    for fit in fits {
        for (what, value) in figures(scene, &fit.keyframes) {
            run.number(format!("{}_{what}", fit.name), value);
        }
        for (what, value) in figures(scene, &fit.joint) {
            run.number(format!("{}_joint_{what}", fit.name), value);
        }
        let (keyframes, near) = fit.starts;
        run.number(format!("{}_starts", fit.name), near as f64 / keyframes as f64);
    }
}

fn ablation(
    name: &'static str,
    scene: &Scene<'_>,
    fits: &[Fit],
    track: fn(&Fit) -> &Track,
) -> Table {
    let columns = [
        "likelihood",
        "starts within 50 mm",
        "joints, mm",
        "less offset, mm",
        "lengths, %",
        "knee, °",
        "hip, °",
        "frames with a joint lost",
        "joints lost (found again)",
        "frames searched anew",
        "search and joint optimum, s",
    ];
    let mut table = Table::new(name, &columns);
    for fit in fits {
        let chosen = track(fit);
        let figures = figures(scene, chosen).map(|(_, value)| format!("{value:.1}"));
        let [joints, offset, lengths, knee, hip, ..] = figures;
        table.row([
            fit.name.replace('_', " "),
            format!("{} of {}", fit.starts.1, fit.starts.0),
            joints,
            offset,
            lengths,
            knee,
            hip,
            chosen.losses.frames.to_string(),
            format!("{} ({})", chosen.losses.lost, chosen.losses.recovered),
            chosen.searched_anew.to_string(),
            fit.seconds.map(|s| format!("{s:.0}")).join(" + "),
        ]);
    }
    table
}

/// The model's lengths, each with its two points, in the order of its file.
pub(crate) fn model_lengths(scene: &Scene<'_>) -> Vec<(String, String, String)> {
    let point = |index: &usize| scene.model.points[*index].name.clone();
    let lengths = scene.model.lengths.iter();
    lengths.map(|(name, from, to)| (name.replace('_', " "), point(from), point(to))).collect()
}

fn lengths(scene: &Scene<'_>, fits: &[Fit]) -> Table {
    let shown = ["outline", "published"];
    let shown: Vec<&Fit> = fits.iter().filter(|f| shown.contains(&f.name)).collect();
    let mut columns = vec!["length".to_owned(), "truth".to_owned()];
    for fit in &shown {
        columns.push(fit.name.to_owned());
        columns.push(format!("{} joint", fit.name));
    }
    let columns: Vec<&str> = columns.iter().map(String::as_str).collect();
    let mut table = Table::new("lengths", &columns);
    for (name, from, to) in model_lengths(scene) {
        let Some(truth) = mean_distance(&scene.truth, &from, &to) else {
            continue;
        };
        let cell = |track: &Track| {
            let length = mean_distance(&track.fit, &from, &to).unwrap_or(f64::NAN);
            format!("{:.1} ({:+.0})", 1e2 * length, 1e3 * (length - truth))
        };
        let cells = shown.iter().flat_map(|f| [cell(&f.keyframes), cell(&f.joint)]);
        table.row([name, format!("{:.1}", 1e2 * truth)].into_iter().chain(cells));
    }
    table
}
