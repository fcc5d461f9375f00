//! How far detections of joints lie from the body, where no mask says how well it is covered.

use std::collections::BTreeMap;

use maud::{Markup, html};

use super::figure::{Axis, BOTH, Figure, axis_range};
use super::page::{absent, number};
use crate::io::result::ResultFile;
use crate::math::stats::mean;
use crate::pipeline::{CameraQuality, DetectedQuality};

/// Whether detections alone tell how good the fit is.
pub(super) fn stand_alone(result: &ResultFile) -> bool {
    result.quality.views.is_empty() && !result.quality.detections.is_empty()
}

pub(super) fn joint_table(cameras: &[CameraQuality]) -> Markup {
    let of = |camera: &CameraQuality, value: fn(&DetectedQuality) -> f64| {
        camera.detections.as_ref().map(value)
    };
    html! {
        table class="numbers" {
            thead { tr {
                th scope="col" { "Camera" } th scope="col" { "Pictures" } th scope="col" { "Joints off, median, px" }
                th scope="col" { "The same, % of the person's size" }
            } }
            tbody { @for camera in cameras { tr {
                th scope="row" { (camera.camera) }
                td { (camera.detections.map_or(0, |joints| joints.pictures)) }
                td { (number(of(camera, |joints| joints.median_px), 1)) }
                td { (number(of(camera, |joints| 100.0 * joints.median_of_size), 0)) }
            } } }
        }
        p class="note" {
            "There are no masks. The body was fitted to joints that another program saw in the pictures, so how thick it is comes from its "
            "bones and from what people are like. A detector means each joint a centimetre or two elsewhere, which is no error of the motion. "
            "A camera far above the others may have a wrong calibration."
        }
    }
}

/// The distance in each frame, over its cameras.
pub(super) fn joint_chart(result: &ResultFile) -> Markup {
    let mut frames: BTreeMap<usize, Vec<f64>> = BTreeMap::new();
    for picture in &result.quality.detections {
        frames.entry(picture.frame.0).or_default().push(picture.median_px);
    }
    let of = |(frame, off): (&usize, &Vec<f64>)| {
        let least = off.iter().copied().fold(f64::INFINITY, f64::min);
        let most = off.iter().copied().fold(0.0, f64::max);
        (*frame as f64, least, mean(off.iter().copied()).unwrap_or(f64::NAN), most)
    };
    let all: Vec<_> = frames.iter().map(of).collect();
    let means: Vec<_> = all.iter().map(|(frame, _, mean, _)| (*frame, *mean)).collect();
    let band: Vec<_> = all.iter().map(|(frame, least, _, most)| (*frame, *least, *most)).collect();

    let recording = &result.recording;
    let ends = (recording.first_frame as f64, recording.last_frame as f64);
    let (_, x_step) = axis_range(std::iter::empty(), ends);
    let (y_range, y_step) = axis_range(band.iter().map(|b| b.2), (0.0, 1.0));
    let x = Axis { label: "frame".into(), range: (ends.0, ends.1.max(ends.0 + 1.0)), step: x_step };
    let y = Axis { label: "joints off, px".into(), range: y_range, step: y_step };
    let figure = Figure::new("", x, y).wide().band(BOTH, 0.2, &band).line(BOTH, 1.5, &means);
    html! {
        @if figure.is_empty() {
            (absent("No chart: fewer than two frames have detections."))
        } @else {
            (figure.markup("Median distance of the detections from the body, frame by frame: mean of the cameras, and from the best to the worst of them."))
            p class="note" { "Line: mean of the cameras. Tint: from the best to the worst of them." }
        }
    }
}
