//! The pictures of PF02: a failure and its repair frame by frame (Figs. 3 and 6), frames of a sequence (Fig. 4), and how far
//! the contours are off in the course of time.

use experiments::contours::{compared, sheet};
use experiments::picture::{Panel, colour, svg};
use experiments::run::Run;
use kuva::plot::LegendPosition;
use maquette::image::{Mask, Picture};

use crate::Fault;
use crate::sequence::{Sequence, Traced};

/// Frames of a failure that are shown lie this far apart.
const STEP: usize = 3;
/// Frames shown in a row.
const SHOWN: usize = 4;
/// Pixels around the person that are shown.
const MARGIN_PX: usize = 12;
/// Distances beyond this are drawn here.
const MOST_DRAWN_PX: f64 = 10.0;

/// Draws everything.
pub(crate) fn draw(run: &Run, all: &[(Sequence, Vec<Traced>)]) -> Result<(), Fault> {
    let panels = all.iter().enumerate().map(|(n, (_, traced))| distances(n, traced));
    run.picture("distances", &svg(1, (760.0, 240.0), panels.collect()))?;
    if let Some((number, worst)) = worst_failure(all) {
        let (sequence, traced) = &all[number];
        let last = traced[0].scores.len().saturating_sub(1);
        let first = (worst + STEP).saturating_sub(STEP * (SHOWN - 1)).min(last);
        let frames: Vec<usize> = (0..SHOWN).map(|k| (first + k * STEP).min(last)).collect();
        run.say(&format!("failure and repair: sequence {}, frames {frames:?}", number + 1));
        let rows: Vec<&Traced> = traced.iter().collect();
        run.photograph("failure", &strip(sequence, &rows, &frames)?)?;
    }
    if let Some((sequence, traced)) = all.last() {
        let count = traced[1].scores.len();
        let frames: Vec<usize> = (0..SHOWN).map(|k| (2 * k + 1) * count / (2 * SHOWN)).collect();
        run.say(&format!("joint, last sequence: frames {frames:?}"));
        run.photograph("joint", &strip(sequence, &[&traced[1]], &frames)?)?;
    }
    Ok(())
}

/// Sequence and frame in which the simple pipeline is worse than the joint one by most, in the centre camera.
fn worst_failure(all: &[(Sequence, Vec<Traced>)]) -> Option<(usize, usize)> {
    let frames = all.iter().enumerate().flat_map(|(number, (_, traced))| {
        (0..traced[0].scores.len()).map(move |frame| {
            let [simple, joint] = [&traced[0], &traced[1]].map(|t| t.distance_px(frame).min(99.0));
            ((number, frame), simple - joint)
        })
    });
    frames.max_by(|a, b| a.1.total_cmp(&b.1)).map(|(place, _)| place)
}

/// A row for each pipeline, the centre camera's photographs with the true border and the found one.
fn strip(sequence: &Sequence, traced: &[&Traced], frames: &[usize]) -> Result<Picture, Fault> {
    let studio = sequence.studio().ok_or("no such camera")?;
    let (mut rows, mut window) = (Vec::new(), None);
    for traced in traced {
        let mut row = Vec::new();
        for frame in frames {
            let (photograph, found, truth) = sequence.shown(&studio, traced, *frame)?;
            window = Some(around(&truth, window));
            row.push(compared(&photograph, &found, &truth));
        }
        rows.push(row);
    }
    let [left, top, right, bottom] = window.unwrap_or_default();
    let (left, top) = (left.saturating_sub(MARGIN_PX), top.saturating_sub(MARGIN_PX));
    let size = [right + MARGIN_PX - left, bottom + MARGIN_PX - top];
    Ok(sheet(&rows, [left, top, size[0], size[1]]))
}

/// Left, top, right and bottom of a mask and what was there before.
fn around(mask: &Mask, before: Option<[usize; 4]>) -> [usize; 4] {
    let [mut left, mut top, mut right, mut bottom] =
        before.unwrap_or([usize::MAX, usize::MAX, 0, 0]);
    for y in 0..mask.height() {
        for x in (0..mask.width()).filter(|x| mask.is_foreground(*x, y)) {
            (left, top) = (left.min(x), top.min(y));
            (right, bottom) = (right.max(x), bottom.max(y));
        }
    }
    [left, top, right, bottom]
}

fn distances(number: usize, traced: &[Traced]) -> Panel {
    let title = format!("Sequence {}, centre camera", number + 1);
    let count = traced.first().map_or(0, |t| t.scores.len());
    let mut panel = Panel::new(&title, "frame", "contour off, px")
        .ranges((0.0, count as f64), (0.0, MOST_DRAWN_PX))
        .legend(LegendPosition::InsideTopRight);
    for (traced, colour) in traced.iter().zip([colour::ORANGE, colour::BLUE, colour::GREY]) {
        let points: Vec<(f64, f64)> = (0..count)
            .map(|frame| (frame as f64, traced.distance_px(frame).min(MOST_DRAWN_PX)))
            .collect();
        panel = panel.curve(traced.pipeline, colour, &points);
    }
    let limit = experiments::contours::MOST_DISTANCE_PX;
    panel.dashed("", colour::GREY, &[(0.0, limit), (count as f64, limit)])
}
