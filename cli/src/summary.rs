//! What is said of a fit: tables for a person, or JSON.

use std::path::Path;

use serde_json::{Value, json};

use super::table::Table;
use maquette::io::result::{HypothesisPart, OriginPart, OutcomePart, ResultFile};
use maquette::pipeline::{CameraFound, CameraQuality, counted};

/// What a run says at its end.
#[derive(Debug)]
pub(super) struct Summary<'a> {
    pub(super) result: &'a ResultFile,
    pub(super) out: &'a Path,
    pub(super) seconds: f64,
}

impl Summary<'_> {
    /// The same as JSON, in one object.
    pub(super) fn json(&self) -> Value {
        let result = self.result;
        let hypotheses: Vec<_> = result
            .hypotheses
            .iter()
            .map(|h| {
                json!({
                    "origin": h.origin, "reading": h.reading, "keyframe": h.keyframe, "outcome": h.outcome,
                    "frames_fitted": h.frames_fitted, "minus_log_posterior": h.minus_log_posterior.total, "iou": h.iou,
                })
            })
            .collect();

        json!({
            "out": self.out.display().to_string(),
            "seconds": self.seconds,
            "verdict": result.verdict,
            "usable": result.verdict.is_usable(),
            "body": result.body,
            "frames": result.recording.frames,
            "lengths": result.shape.lengths,
            "confidence_of": result.shape.confidence_of,
            "hypotheses": hypotheses,
            "winner": result.winner,
            "cameras": result.quality.cameras,
            "warnings": result.warnings,
        })
    }

    /// Tables for a person.
    pub(super) fn text(&self) -> String {
        let recording = &self.result.recording;
        let verdict = self.result.verdict.why_unusable();
        let sections = [
            verdict.map_or(String::new(), |headline| format!("!! {headline}\n")),
            format!(
                "{} fitted to {} of {} cameras at {} Hz in {:.1} s\n",
                self.result.body,
                counted(recording.frames, "frame"),
                recording.cameras.len(),
                recording.fps,
                self.seconds
            ),
            self.hypotheses(),
            self.shape(),
            self.cameras(),
            self.warnings(),
            format!("Written into {}\n", self.out.display()),
        ];

        let filled = sections.into_iter().filter(|section| !section.is_empty());
        filled.collect::<Vec<_>>().join("\n")
    }

    fn hypotheses(&self) -> String {
        let mut table = Table::new(&["hypothesis", "keyframe", "−log posterior", "overlap"]);

        for (i, hypothesis) in self.result.hypotheses.iter().enumerate() {
            let mark = if i == self.result.winner { "▸" } else { " " };
            table.row(vec![
                format!("{mark} {}", origin(hypothesis)),
                hypothesis.keyframe.to_string(),
                match hypothesis.outcome {
                    OutcomePart::Pruned => {
                        format!("pruned after {}", counted(hypothesis.frames_fitted, "frame"))
                    }
                    _ => format!("{:.1}", hypothesis.minus_log_posterior.total),
                },
                or_dash(hypothesis.iou, |iou| format!("{iou:.3}")),
            ]);
        }

        table.text()
    }

    fn shape(&self) -> String {
        let lengths = &self.result.shape.lengths;
        let Some(first) = lengths.first() else {
            return String::new();
        };
        let keyframes = first.confidence.keyframes;
        let has_sd = lengths.iter().any(|length| length.sd_m.is_some());
        let mut table = Table::new(&["length", "cm", if has_sd { "± SD" } else { "± σ" }]);

        let cm = |metres: f64| format!("± {:.1}", 100.0 * metres);
        for length in lengths {
            let spread = if has_sd { length.sd_m } else { length.confidence.sigma };
            table.row(vec![
                length.name.clone(),
                format!("{:.1}", 100.0 * length.length_m),
                or_dash(spread, cm),
            ]);
        }

        let mut text = table.text();
        if has_sd {
            text += "  SD: standard deviation of the true length, from all frames together.\n";
        } else if keyframes > 1 {
            text += &format!(
                "  σ: spread of the {keyframes} keyframes' estimates; an error that all of them share does not show.\n"
            );
        }
        text
    }

    fn cameras(&self) -> String {
        let cameras = &self.result.quality.cameras;
        let is_found = cameras.iter().any(|c| c.found != CameraFound::default());
        let found =
            if is_found { &["turned", "displaced", "focal length", "late"][..] } else { &[] };
        let has_masks = cameras.iter().any(|c| c.frames > 0 || c.detections.is_none());
        let own: &[&str] = match has_masks {
            true => &["camera", "frames", "overlap", "border off by", "RMS"],
            false => &["camera", "frames", "joints off by", "of the person's size"],
        };
        let mut table = Table::new(&[own, found].concat());
        for camera in cameras {
            let mut cells = match has_masks {
                true => overlap_cells(camera),
                false => joint_cells(camera),
            };
            if is_found {
                cells.extend(self.found(&camera.found));
            }
            table.row(cells);
        }
        table.text()
    }

    /// Where and when a camera was.
    fn found(&self, found: &CameraFound) -> [String; 4] {
        let fps = self.result.recording.fps;
        // a standard deviation that is withheld is not 0
        let sd = |sd: Option<f64>, digits: usize| {
            sd.map_or(String::new(), |sd| format!(" ± {sd:.digits$}"))
        };
        let turned = found.pose.map(|pose| {
            let (turn, turn_sd) = pose.turn();
            format!("{turn:.2}{}°", sd(turn_sd, 2))
        });
        let displaced = found.pose.map(|pose| {
            let (way_m, way_sd_m) = pose.displacement();
            format!("{:.1}{} mm", 1e3 * way_m, sd(way_sd_m.map(|sd_m| 1e3 * sd_m), 1))
        });
        let zoomed = found.pose.map(|pose| {
            let (longer, longer_sd) = pose.longer();
            format!("{:+.2}{} %", 100.0 * longer, sd(longer_sd.map(|sd| 100.0 * sd), 2))
        });
        let late = found.clock.map(|clock| {
            let (late, late_sd) = clock.late_frames(fps);
            format!("{late:+.2}{} frames", sd(late_sd, 2))
        });
        [turned, displaced, zoomed, late].map(|text| text.unwrap_or("–".into()))
    }

    fn warnings(&self) -> String {
        let lines = self.result.warnings.iter().map(|warning| format!("  ! {warning}\n"));
        lines.collect()
    }
}

fn overlap_cells(camera: &CameraQuality) -> Vec<String> {
    vec![
        camera.camera.clone(),
        camera.frames.to_string(),
        format!("{:.3}", camera.mean_iou),
        or_dash(camera.median_px, |px| format!("{px:.1} px")),
        or_dash(camera.rms_px, |px| format!("{px:.1} px")),
    ]
}

/// Without masks the detections tell.
fn joint_cells(camera: &CameraQuality) -> Vec<String> {
    let joints = camera.detections;
    vec![
        camera.camera.clone(),
        joints.map_or(0, |joints| joints.pictures).to_string(),
        or_dash(joints, |joints| format!("{:.1} px", joints.median_px)),
        or_dash(joints, |joints| format!("{:.0} %", 100.0 * joints.median_of_size)),
    ]
}

fn origin(hypothesis: &HypothesisPart) -> String {
    match (hypothesis.origin, hypothesis.reading) {
        (OriginPart::Prior, _) => "mean body".into(),
        (OriginPart::Turned, _) => "facing the other way".into(),
        (OriginPart::Keyframe, None | Some(0)) => "keyframe".into(),
        (OriginPart::Keyframe, Some(reading)) => format!("keyframe, reading {}", reading + 1),
    }
}

fn or_dash<T>(value: Option<T>, text: impl Fn(T) -> String) -> String {
    value.map_or("–".into(), text)
}
