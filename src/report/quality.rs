//! How far to trust the numbers: what the cameras saw, how well the body covers it, and what else was tried.

use std::collections::BTreeMap;

use maud::{Markup, html};

use super::by_frame::{figure, spreads};
use super::figure::{Axis, axis_range};
use super::joints::{joint_chart, joint_table, stand_alone};
use super::label::part_name;
use super::page::{Page, absent};
use super::rig_view::rig_view;
use super::{ReportInput, Words};
use crate::io::result::{
    FramePart, HypothesisPart, MotionPart, OriginPart, OutcomePart, RecordingPart, RejectedPart,
    ResultFile, ShapePart,
};
use crate::pipeline::{CameraFound, CameraQuality, PoseFound};
use crate::silhouette::FrameIndex;

/// Most hypotheses that are listed.
const MOST_HYPOTHESES: usize = 10;

pub(super) fn page<'a>(input: &ReportInput<'a>) -> Page<'a> {
    let words = input.words;
    Page {
        id: "quality",
        title: words.of("Quality"),
        body: match input.result {
            Some(result) => fit_quality(result, words),
            None => absent(words.of(
                "Points of another system: nothing is known of its cameras, its residuals or its alternatives.",
            )),
        },
        is_brief: input.result.is_none(),
    }
}

fn fit_quality(result: &ResultFile, words: &Words) -> Markup {
    html! {
        h3 { (words.of("Cameras")) }
        @if stand_alone(result) {
            (joint_table(&result.quality.cameras, words))
        } @else {
            (camera_table(&result.quality.cameras, words))
        }
        (found_table(&result.quality.cameras, result.recording.fps, words))
        @if let Some(view) = rig_view(result, words) { (view) }
        @if stand_alone(result) {
            h3 { (words.of("Distance of the detections over time")) }
            (joint_chart(result, words))
        } @else {
            h3 { (words.of("Overlap over time")) }
            (overlap_chart(result, words))
        }
        h3 { (words.of("Missing")) }
        (missing_table(&result.recording, &result.motion, words))
        h3 { (words.of("Agreement of the keyframes")) }
        (confidence_table(&result.shape, words))
        h3 { (words.of("Hypotheses")) }
        (hypothesis_table(result, words))
    }
}

fn camera_table(cameras: &[CameraQuality], words: &Words) -> Markup {
    html! {
        div class="scroll" role="group" tabindex="0" aria-label=(words.of("Table")) {
            table class="numbers" {
                thead { tr {
                    th scope="col" { (words.of("Camera")) } th scope="col" { (words.of("Views")) } th scope="col" { (words.of("Overlap (IoU), mean")) }
                    th scope="col" { (words.of("Outline off, median, px")) } th scope="col" { (words.of("Outline off, RMS, px")) }
                } }

                tbody {
                    @for camera in cameras {
                        tr {
                            th scope="row" { (camera.camera) }
                            td { (camera.frames) }
                            td { (words.number(Some(camera.mean_iou), 3)) }
                            td { (words.number(camera.median_px, 1)) }
                            td { (words.number(camera.rms_px, 1)) }
                        }
                    }
                }
            }
        }
        p class="note" {
            (words.of("Overlap: intersection over union of the recorded outline and the fitted body; 1 is perfect.")) " "
            (words.of("A camera far below the others may have a wrong calibration or bad masks."))
        }
    }
}

/// Where and when the cameras were found to be; nothing where they were trusted.
fn found_table(cameras: &[CameraQuality], fps: f64, words: &Words) -> Markup {
    let all = cameras.iter().filter(|c| c.found != CameraFound::default());
    let all: Vec<&CameraQuality> = all.collect();
    let pose =
        |c: &CameraQuality, of: fn(&PoseFound) -> (f64, Option<f64>)| c.found.pose.as_ref().map(of);
    html! {
        @if !all.is_empty() {
            h3 { (words.of("Where and when the cameras were")) }
            div class="scroll" role="group" tabindex="0" aria-label=(words.of("Table")) {
                table class="numbers" {
                    thead { tr {
                        th scope="col" { (words.of("Camera")) } th scope="col" { (words.of("Turned, °")) } th scope="col" { (words.of("Displaced, mm")) }
                        th scope="col" { (words.of("Focal length, %")) } th scope="col" { (words.of("Late, frames")) }
                    } }
                    tbody { @for camera in all { tr {
                        th scope="row" { (camera.camera) }
                        td { (off(pose(camera, PoseFound::turn), (1.0, 2), words)) }
                        td { (off(pose(camera, PoseFound::displacement), (1e3, 1), words)) }
                        td { (off(pose(camera, PoseFound::longer), (1e2, 2), words)) }
                        td { (off(camera.found.clock.map(|clock| clock.late_frames(fps)), (1.0, 2), words)) }
                    } } }
                }
            }
            p class="note" {
                (words.of("By how much each camera is off its calibration and its clock, ± one standard deviation, relative to the rig: what all \
                    cameras have in common does not show. –: not estimated, and taken as calibrated."))
            }
        }
    }
}

/// A size and its standard deviation, if that is not withheld, in another unit with so many digits.
fn off(found: Option<(f64, Option<f64>)>, (unit, digits): (f64, usize), words: &Words) -> String {
    match found {
        None => "–".into(),
        Some((size, Some(sd))) => {
            let of = |value: f64| words.number(Some(unit * value), digits);
            format!("{} ± {}", of(size), of(sd))
        }
        Some((size, None)) => words.number(Some(unit * size), digits),
    }
}

/// Mean overlap of the views of each frame, and the band from the worst to the best view.
fn overlap_chart(result: &ResultFile, words: &Words) -> Markup {
    let overlaps = spreads(result, result.quality.views.iter().map(|view| (view.frame, view.iou)));
    let (range, step) = axis_range(overlaps.iter().map(|overlap| overlap.least), (0.7, 1.0));
    let y = Axis { label: words.of("overlap (IoU)").into(), range: (range.0.max(0.0), 1.0), step };
    let figure = figure(result, &overlaps, y, words);

    html! {
        @if figure.is_empty() {
            (absent(words.of("No chart: fewer than two frames were seen by a camera.")))
        } @else {
            (figure.markup(words.of("Overlap of body and outlines, frame by frame: mean of the cameras, and from the worst to the best of them."), words))
            p class="note" {
                (words.of("Line: mean of the cameras. Tint: from the worst to the best of them. Gaps: frames that no camera saw, or in which the body was lost."))
            }
        }
    }
}

fn missing_table(recording: &RecordingPart, motion: &MotionPart, words: &Words) -> Markup {
    let those = |is: fn(&&FramePart) -> bool| {
        let frames = motion.frames.iter().filter(is).map(|part| part.frame);
        ranges(&frames.collect::<Vec<_>>(), words)
    };
    let without =
        |frames: &[FrameIndex]| ranges(&frames.iter().map(|f| f.0).collect::<Vec<_>>(), words);

    html! {
        table class="facts" {
            tr { th scope="row" { (words.of("Frames that no camera saw")) } td { (those(|part| part.views == 0)) } }
            tr { th scope="row" { (words.of("Frames searched anew after a loss")) } td { (those(|part| part.recovered)) } }
            @for masks in &recording.missing {
                tr { th scope="row" { (words.fill("No mask of {camera}", &[("camera", &masks.camera)])) } td { (without(&masks.frames)) } }
            }
            tr {
                th scope="row" { (words.of("Masks that show nobody")) }
                td { (rejections(&recording.rejected, words)) }
            }
        }
    }
}

fn rejections(rejected: &[RejectedPart], words: &Words) -> String {
    let mut frames: BTreeMap<&str, Vec<usize>> = BTreeMap::new();
    for part in rejected {
        frames.entry(&part.camera).or_default().push(part.frame);
    }
    let texts =
        frames.iter().map(|(camera, frames)| format!("{camera}: {}", ranges(frames, words)));
    match frames.is_empty() {
        true => words.of("none").into(),
        false => texts.collect::<Vec<_>>().join("; "),
    }
}

/// `3–7, 12` of sorted numbers.
fn ranges(frames: &[usize], words: &Words) -> String {
    let runs = frames.chunk_by(|a, b| a + 1 == *b).map(|run| match run {
        [only] => only.to_string(),
        [first, .., last] => format!("{first}–{last}"),
        [] => String::new(),
    });
    match frames.is_empty() {
        true => words.of("none").into(),
        false => runs.collect::<Vec<_>>().join(", "),
    }
}

fn confidence_table(shape: &ShapePart, words: &Words) -> Markup {
    let coefficients = &shape.all_coefficients;
    let lengths =
        shape.lengths.iter().map(|length| (part_name(&length.name, words), &length.confidence));
    let all = lengths.chain([(words.of("all lengths").to_owned(), &shape.all_lengths)]);
    let in_cm = |value: Option<f64>, digits| words.number(value.map(|v| 100.0 * v), digits);

    html! {
        div class="scroll" role="group" tabindex="0" aria-label=(words.of("Table")) {
            table class="numbers" {
                thead { tr {
                    th scope="col" { (words.of("Of")) } th scope="col" { (words.of("ε, cm")) } th scope="col" { "K" } th scope="col" { (words.of("σ, cm")) }
                    th scope="col" { "p" sub { "ε,σ" } "(K)" }
                } }
                tbody {
                    @for (name, confidence) in all { tr {
                        th scope="row" { (name) }
                        td { (in_cm(Some(confidence.epsilon), 1)) }
                        td { (confidence.keyframes) }
                        td { (in_cm(confidence.sigma, 2)) }
                        td { (words.probability(confidence.p_within)) }
                    } }
                    tr {
                        th scope="row" { (words.of("all shape coefficients, without unit")) }
                        td { (words.number(Some(coefficients.epsilon), 3)) }
                        td { (coefficients.keyframes) }
                        td { (words.number(coefficients.sigma, 3)) }
                        td { (words.probability(coefficients.p_within)) }
                    }
                }
            }
        }
        p class="note" {
            (words.of("K keyframes each proposed a body of their own; σ is how far the proposals scatter,"))
            " p" sub { "ε,σ" } "(K) " (words.of("how probable it is that the best of them lies within ε of where they would settle, \
                if they err at random. That is no accuracy: an error that all keyframes share does not show; the standard \
                deviation of a length stands on the Shape page. Confidence of:")) " " (words.line(&shape.confidence_of)) ". "
            @if shape.all_lengths.p_within.is_none() { (words.of("Absent: fewer than two keyframes proposed a body.")) }
        }
    }
}

fn hypothesis_table(result: &ResultFile, words: &Words) -> Markup {
    let energy = |h: &HypothesisPart| h.minus_log_posterior.total;
    let best = result.hypotheses.get(result.winner).map(energy);
    let mut sorted: Vec<&HypothesisPart> = result.hypotheses.iter().collect();
    sorted.sort_by(|a, b| energy(a).total_cmp(&energy(b)));

    html! {
        div class="scroll" role="group" tabindex="0" aria-label=(words.of("Table")) {
            table class="numbers" {
                thead { tr {
                    th scope="col" { (words.of("Shape from")) } th scope="col" { (words.of("Keyframe")) } th scope="col" { (words.of("Outcome")) }
                    th scope="col" { (words.of("Frames")) } th scope="col" { (words.of("−log posterior above the winner")) } th scope="col" { (words.of("Overlap")) }
                } }
                tbody { @for hypothesis in sorted.iter().take(MOST_HYPOTHESES) { tr {
                    th scope="row" { (origin(hypothesis, words)) }
                    td { (hypothesis.keyframe) }
                    td { (outcome(hypothesis, words)) }
                    td { (hypothesis.frames_fitted) }
                    td { (words.number(best.map(|best| energy(hypothesis) - best), 1)) }
                    td { (words.number(hypothesis.iou, 3)) }
                } } }
            }
        }
        p class="note" {
            (words.fill("{n} explanations were tried", &[("n", &result.hypotheses.len())]))
            @if sorted.len() > MOST_HYPOTHESES { (words.fill("; the {n} most probable are shown", &[("n", &MOST_HYPOTHESES)])) }
            ". " (words.of("For a dropped one the number is a lower bound, reached when it could no longer win."))
        }
    }
}

fn origin<'a>(hypothesis: &HypothesisPart, words: &'a Words) -> &'a str {
    match hypothesis.origin {
        OriginPart::Prior => words.of("mean of people"),
        OriginPart::Keyframe => words.of("keyframe"),
        OriginPart::Turned => words.of("facing the other way"),
    }
}

fn outcome<'a>(hypothesis: &HypothesisPart, words: &'a Words) -> &'a str {
    match hypothesis.outcome {
        OutcomePart::Won => words.of("won"),
        OutcomePart::Finished => words.of("followed to the end"),
        OutcomePart::Pruned => words.of("dropped"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::Language;

    #[test]
    fn frames_in_a_row_are_written_as_a_range() {
        let words = Words::new(Language::English);
        assert_eq!(ranges(&[], &words), "none");
        assert_eq!(ranges(&[3, 4, 5, 9, 11, 12], &words), "3–5, 9, 11–12");
    }
}
