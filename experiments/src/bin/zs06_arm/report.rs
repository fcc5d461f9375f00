//! What is printed and checked.

use std::error::Error;

use experiments::arm::share_of;
use experiments::run::Run;
use experiments::table::Table;
use maquette::math::stats::mean_and_sd;

use crate::analysis::{ARM, Analysis, FRAMES, Outcome, RECORDINGS};

pub(crate) fn report(run: &mut Run, analyses: &[Analysis]) -> Result<(), Box<dyn Error>> {
    numbers(run, analyses);
    run.table(
        "Width of the posterior of a after frames … (1: nothing is known)",
        &widths(analyses),
    )?;
    run.table(
        "Hypotheses: a (normalised sequence posterior) from the prior and from each keyframe",
        &hypotheses(analyses),
    )?;
    let title = format!("{RECORDINGS} recordings with other noise");
    run.table(&title, &repeated(analyses))?;
    Ok(())
}

fn numbers(run: &mut Run, analyses: &[Analysis]) {
    for analysis in analyses {
        let (posterior, first) = (&analysis.posterior, &analysis.outcomes[0]);
        for (what, value) in [
            ("a", first.a),
            ("a_of_frame_1", first.a_of_first_frame),
            ("probability_of_frame_1", analysis.probabilities()[1]),
            ("width_after_1", posterior.width(1)),
            ("width_after_4", posterior.width(4)),
            ("width_after_6", posterior.width(6)),
            ("phi_rms_rad", analysis.angle_error()),
            ("fraction_within", analysis.fraction(Outcome::is_right)),
            ("fraction_first_chosen", analysis.fraction(|o| o.chose_first_frame)),
        ] {
            run.number(format!("{}_{what}", analysis.name), value);
        }
    }
    let sharpens =
        |a: &&Analysis| (1..FRAMES).all(|n| a.posterior.width(n + 1) < a.posterior.width(n));
    let sharpening = analyses.iter().filter(sharpens).count() as f64;
    run.number("sharpens_with_every_frame", sharpening / analyses.len() as f64);
}

fn widths(analyses: &[Analysis]) -> Table {
    let columns = ["likelihood", "1", "1–2", "1–3", "1–4", "1–5", "1–6"];
    let mut table = Table::new("width", &columns);
    for analysis in analyses {
        let width = |n| format!("{:.3}", analysis.posterior.width(n));
        table.row([analysis.name.to_owned()].into_iter().chain((1..=FRAMES).map(width)));
    }
    table
}

fn hypotheses(analyses: &[Analysis]) -> Table {
    let columns = ["likelihood", "mean of p(s)", "1", "2", "3", "4", "5", "6"];
    let mut table = Table::new("hypotheses", &columns);
    for analysis in analyses {
        let trials = analysis.found.trials.iter().zip(analysis.probabilities());
        let cells = trials.map(|(t, p)| format!("{:.3} ({p:.3})", share_of(&t.hypothesis.shape)));
        table.row([analysis.name.to_owned()].into_iter().chain(cells));
    }
    table
}

fn repeated(analyses: &[Analysis]) -> Table {
    let columns = [
        "likelihood",
        "a chosen (mean ± SD)",
        "within 0.05",
        "a of frame 1 (mean ± SD)",
        "frame 1 within 0.05",
        "frame 1 chosen",
    ];
    let mut table = Table::new("repeated", &columns);
    for analysis in analyses {
        let spread = |value: fn(&Outcome) -> f64| {
            let values: Vec<f64> = analysis.outcomes.iter().map(value).collect();
            let (mean, sd) = mean_and_sd(&values).unwrap_or((f64::NAN, None));
            format!("{mean:.3} ± {:.3}", sd.unwrap_or(f64::NAN))
        };
        let fraction = |holds: fn(&Outcome) -> bool| format!("{:.2}", analysis.fraction(holds));
        table.row([
            analysis.name.to_owned(),
            spread(|o| o.a),
            fraction(Outcome::is_right),
            spread(|o| o.a_of_first_frame),
            fraction(|o| (o.a_of_first_frame - ARM.a).abs() <= 0.05),
            fraction(|o| o.chose_first_frame),
        ]);
    }
    table
}
