//! What is printed and checked.

use std::error::Error;

use experiments::held::{Summary, held, visible};
use experiments::metrics::mpjpe_mm;
use experiments::run::Run;
use experiments::table::Table;
use maquette::synth::Synthetic;

use crate::ways::{Scene, Way};

pub(crate) fn report(
    run: &mut Run,
    recording: &Synthetic,
    scene: &Scene<'_>,
    ways: &[Way],
) -> Result<(), Box<dyn Error>> {
    let frames = scene.frames.len();
    let is_held = |frame: usize| held(frame, frames) >= 0.5;
    let hidden = (0..frames).filter(|&f| is_held(f)).count();
    for (arm, [held, swinging]) in ["right", "left"].into_iter().zip(visible(recording)) {
        run.number(format!("visible_{arm}_held_pct"), 100.0 * held);
        run.number(format!("visible_{arm}_swinging_pct"), 100.0 * swinging);
    }
    let title = format!("Arms held against the body, {hidden} frames of {frames}");
    run.table(&title, &table("held", scene, ways, is_held))?;
    let title = format!("Arms swinging, the other {}", frames - hidden);
    run.table(&title, &table("swinging", scene, ways, |f| !is_held(f)))?;
    for way in ways {
        let joints = mpjpe_mm(&scene.truth, &way.fit).unwrap_or(f64::NAN);
        run.number(format!("{}_mpjpe_mm", way.name), joints);
    }
    for (when, counts) in [("held", true), ("swinging", false)] {
        for way in ways {
            let is_counted = |f: usize| is_held(f) == counts;
            let s = Summary::of(&scene.truth, &way.fit, is_counted);
            let mut number = |what: &str, value| {
                run.number(format!("{}_{when}_{what}", way.name), value);
            };
            number("lost", s.lost as f64);
            number("wrong_way", s.wrong_way as f64);
            number("shoulder_deg", s.shoulder_deg);
            number("elbow_deg", s.elbow_deg);
            if let Some(z) = way.elbow_rms_z(&scene.truth, is_counted) {
                number("elbow_rms_z", z);
            }
            number("wrist_median_mm", s.wrist_median_mm);
            number("wrist_p95_mm", s.wrist_p95_mm);
        }
    }
    Ok(())
}

fn table(
    name: &'static str,
    scene: &Scene<'_>,
    ways: &[Way],
    counts: impl Fn(usize) -> bool,
) -> Table {
    let columns = [
        "way",
        "frames with an arm lost",
        "elbow bent the wrong way",
        "upper arm, ° RMS",
        "elbow, ° RMS",
        "wrist, mm median",
        "wrist, mm 95 %",
        "s",
    ];
    let mut table = Table::new(name, &columns);
    for way in ways {
        let s = Summary::of(&scene.truth, &way.fit, &counts);
        let figures = [s.shoulder_deg, s.elbow_deg, s.wrist_median_mm, s.wrist_p95_mm];
        let counted = [s.lost, s.wrong_way].map(|n| n.to_string());
        let cells = std::iter::once(way.title.to_owned()).chain(counted);
        let cells = cells.chain(figures.map(|v| format!("{v:.1}")));
        table.row(cells.chain([format!("{:.0}", way.seconds)]));
    }
    table
}
