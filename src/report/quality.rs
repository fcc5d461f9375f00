//! How far to trust the numbers: what the cameras saw, how well the body covers it, and what else was tried.

use std::collections::BTreeMap;

use maud::{Markup, html};

use super::ReportInput;
use super::by_frame::{figure, spreads};
use super::figure::{Axis, axis_range};
use super::joints::{joint_chart, joint_table, stand_alone};
use super::label::words;
use super::page::{Page, absent, number, probability};
use super::rig_view::rig_view;
use crate::io::result::{
    FramePart, HypothesisPart, MotionPart, OriginPart, OutcomePart, RecordingPart, RejectedPart,
    ResultFile, ShapePart,
};
use crate::pipeline::{CameraFound, CameraQuality, PoseFound};
use crate::silhouette::FrameIndex;

/// Most hypotheses that are listed.
const MOST_HYPOTHESES: usize = 10;

pub(super) fn page(input: &ReportInput<'_>) -> Page {
    Page {
        id: "quality",
        title: "Quality",
        body: match input.result {
            Some(result) => fit_quality(result),
            None => absent(
                "Points of another system: nothing is known of its cameras, its residuals or its alternatives.",
            ),
        },
        is_brief: input.result.is_none(),
    }
}

fn fit_quality(result: &ResultFile) -> Markup {
    html! {
        h3 { "Cameras" }
        @if stand_alone(result) {
            (joint_table(&result.quality.cameras))
        } @else {
            (camera_table(&result.quality.cameras))
        }
        (found_table(&result.quality.cameras, result.recording.fps))
        @if let Some(view) = rig_view(result) { (view) }
        @if stand_alone(result) {
            h3 { "Distance of the detections over time" }
            (joint_chart(result))
        } @else {
            h3 { "Overlap over time" }
            (overlap_chart(result))
        }
        h3 { "Missing" }
        (missing_table(&result.recording, &result.motion))
        h3 { "Agreement of the keyframes" }
        (confidence_table(&result.shape))
        h3 { "Hypotheses" }
        (hypothesis_table(result))
    }
}

fn camera_table(cameras: &[CameraQuality]) -> Markup {
    html! {
        table class="numbers" {
            thead { tr {
                th scope="col" { "Camera" } th scope="col" { "Views" } th scope="col" { "Overlap (IoU), mean" }
                th scope="col" { "Outline off, median, px" } th scope="col" { "Outline off, RMS, px" }
            } }

            tbody {
                @for camera in cameras {
                    tr {
                        th scope="row" { (camera.camera) }
                        td { (camera.frames) }
                        td { (number(Some(camera.mean_iou), 3)) }
                        td { (number(camera.median_px, 1)) }
                        td { (number(camera.rms_px, 1)) }
                    }
                }
            }
        }
        p class="note" {
            "Overlap: intersection over union of the recorded outline and the fitted body; 1 is perfect. "
            "A camera far below the others may have a wrong calibration or bad masks."
        }
    }
}

/// Where and when the cameras were found to be; nothing where they were trusted.
fn found_table(cameras: &[CameraQuality], fps: f64) -> Markup {
    let all = cameras.iter().filter(|c| c.found != CameraFound::default());
    let all: Vec<&CameraQuality> = all.collect();
    let pose =
        |c: &CameraQuality, of: fn(&PoseFound) -> (f64, Option<f64>)| c.found.pose.as_ref().map(of);
    html! {
        @if !all.is_empty() {
            h3 { "Where and when the cameras were" }
            table class="numbers" {
                thead { tr {
                    th scope="col" { "Camera" } th scope="col" { "Turned, °" } th scope="col" { "Displaced, mm" }
                    th scope="col" { "Late, frames" }
                } }
                tbody { @for camera in all { tr {
                    th scope="row" { (camera.camera) }
                    td { (off(pose(camera, PoseFound::turn), 1.0, 2)) }
                    td { (off(pose(camera, PoseFound::displacement), 1e3, 1)) }
                    td { (off(camera.found.clock.map(|clock| clock.late_frames(fps)), 1.0, 2)) }
                } } }
            }
            p class="note" {
                "By how much each camera is off its calibration and its clock, ± one standard deviation, relative to the rig: what all "
                "cameras have in common does not show. –: not estimated, and taken as calibrated."
            }
        }
    }
}

/// A size and its standard deviation, if that is not withheld, in another unit.
fn off(found: Option<(f64, Option<f64>)>, unit: f64, digits: usize) -> String {
    match found {
        None => "–".into(),
        Some((size, Some(sd))) => {
            format!("{} ± {:.digits$}", number(Some(unit * size), digits), unit * sd)
        }
        Some((size, None)) => number(Some(unit * size), digits),
    }
}

/// Mean overlap of the views of each frame, and the band from the worst to the best view.
fn overlap_chart(result: &ResultFile) -> Markup {
    let overlaps = spreads(result, result.quality.views.iter().map(|view| (view.frame, view.iou)));
    let (range, step) = axis_range(overlaps.iter().map(|overlap| overlap.least), (0.7, 1.0));
    let y = Axis { label: "overlap (IoU)".into(), range: (range.0.max(0.0), 1.0), step };
    let figure = figure(result, &overlaps, y);

    html! {
        @if figure.is_empty() {
            (absent("No chart: fewer than two frames were seen by a camera."))
        } @else {
            (figure.markup("Overlap of body and outlines, frame by frame: mean of the cameras, and from the worst to the best of them."))
            p class="note" {
                "Line: mean of the cameras. Tint: from the worst to the best of them. Gaps: frames that no camera saw, or in which the body was lost."
            }
        }
    }
}

fn missing_table(recording: &RecordingPart, motion: &MotionPart) -> Markup {
    let those = |is: fn(&&FramePart) -> bool| {
        let frames = motion.frames.iter().filter(is).map(|part| part.frame);
        ranges(&frames.collect::<Vec<_>>())
    };
    let without = |frames: &[FrameIndex]| ranges(&frames.iter().map(|f| f.0).collect::<Vec<_>>());

    html! {
        table class="facts" {
            tr { th scope="row" { "Frames that no camera saw" } td { (those(|part| part.views == 0)) } }
            tr { th scope="row" { "Frames searched anew after a loss" } td { (those(|part| part.recovered)) } }
            @for masks in &recording.missing {
                tr { th scope="row" { "No mask of " (masks.camera) } td { (without(&masks.frames)) } }
            }
            tr {
                th scope="row" { "Masks that show nobody" }
                td { (rejections(&recording.rejected)) }
            }
        }
    }
}

fn rejections(rejected: &[RejectedPart]) -> String {
    let mut frames: BTreeMap<&str, Vec<usize>> = BTreeMap::new();
    for part in rejected {
        frames.entry(&part.camera).or_default().push(part.frame);
    }
    let texts = frames.iter().map(|(camera, frames)| format!("{camera}: {}", ranges(frames)));
    match frames.is_empty() {
        true => "none".into(),
        false => texts.collect::<Vec<_>>().join("; "),
    }
}

/// `3–7, 12` of sorted numbers.
fn ranges(frames: &[usize]) -> String {
    let runs = frames.chunk_by(|a, b| a + 1 == *b).map(|run| match run {
        [only] => only.to_string(),
        [first, .., last] => format!("{first}–{last}"),
        [] => String::new(),
    });
    match frames.is_empty() {
        true => "none".into(),
        false => runs.collect::<Vec<_>>().join(", "),
    }
}

fn confidence_table(shape: &ShapePart) -> Markup {
    let coefficients = &shape.all_coefficients;
    let lengths = shape.lengths.iter().map(|length| (words(&length.name), &length.confidence));
    let all = lengths.chain([("all lengths".into(), &shape.all_lengths)]);
    let in_cm = |value: Option<f64>, digits| number(value.map(|v| 100.0 * v), digits);

    html! {
        table class="numbers" {
            thead { tr {
                th scope="col" { "Of" } th scope="col" { "ε, cm" } th scope="col" { "K" } th scope="col" { "σ, cm" }
                th scope="col" { "p" sub { "ε,σ" } "(K)" }
            } }
            tbody {
                @for (name, confidence) in all { tr {
                    th scope="row" { (name) }
                    td { (in_cm(Some(confidence.epsilon), 1)) }
                    td { (confidence.keyframes) }
                    td { (in_cm(confidence.sigma, 2)) }
                    td { (probability(confidence.p_within)) }
                } }
                tr {
                    th scope="row" { "all shape coefficients, without unit" }
                    td { (number(Some(coefficients.epsilon), 3)) }
                    td { (coefficients.keyframes) }
                    td { (number(coefficients.sigma, 3)) }
                    td { (probability(coefficients.p_within)) }
                }
            }
        }
        p class="note" {
            "K keyframes each proposed a body of their own; σ is how far the proposals scatter, "
            "p" sub { "ε,σ" } "(K) how probable it is that the best of them lies within ε of where they would settle, "
            "if they err at random. That is no accuracy: an error that all keyframes share does not show; the standard "
            "deviation of a length stands on the Shape page. Confidence of: " (words(&shape.confidence_of)) ". "
            @if shape.all_lengths.p_within.is_none() { "Absent: fewer than two keyframes proposed a body." }
        }
    }
}

fn hypothesis_table(result: &ResultFile) -> Markup {
    let energy = |h: &HypothesisPart| h.minus_log_posterior.total;
    let best = result.hypotheses.get(result.winner).map(energy);
    let mut sorted: Vec<&HypothesisPart> = result.hypotheses.iter().collect();
    sorted.sort_by(|a, b| energy(a).total_cmp(&energy(b)));

    html! {
        table class="numbers" {
            thead { tr {
                th scope="col" { "Shape from" } th scope="col" { "Keyframe" } th scope="col" { "Outcome" }
                th scope="col" { "Frames" } th scope="col" { "−log posterior above the winner" } th scope="col" { "Overlap" }
            } }
            tbody { @for hypothesis in sorted.iter().take(MOST_HYPOTHESES) { tr {
                th scope="row" { (origin(hypothesis)) }
                td { (hypothesis.keyframe) }
                td { (outcome(hypothesis)) }
                td { (hypothesis.frames_fitted) }
                td { (number(best.map(|best| energy(hypothesis) - best), 1)) }
                td { (number(hypothesis.iou, 3)) }
            } } }
        }
        p class="note" {
            (result.hypotheses.len()) " explanations were tried"
            @if sorted.len() > MOST_HYPOTHESES { "; the " (MOST_HYPOTHESES) " most probable are shown" }
            ". For a dropped one the number is a lower bound, reached when it could no longer win."
        }
    }
}

fn origin(hypothesis: &HypothesisPart) -> &'static str {
    match hypothesis.origin {
        OriginPart::Prior => "mean of people",
        OriginPart::Keyframe => "keyframe",
        OriginPart::Turned => "facing the other way",
    }
}

fn outcome(hypothesis: &HypothesisPart) -> &'static str {
    match hypothesis.outcome {
        OutcomePart::Won => "won",
        OutcomePart::Finished => "followed to the end",
        OutcomePart::Pruned => "dropped",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_in_a_row_are_written_as_a_range() {
        assert_eq!(ranges(&[]), "none");
        assert_eq!(ranges(&[3, 4, 5, 9, 11, 12]), "3–5, 9, 11–12");
    }
}
