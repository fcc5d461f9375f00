//! How far detections of joints lie from the body, where no mask says how well it is covered.

use maud::{Markup, html};

use super::Words;
use super::by_frame::{figure, spreads};
use super::figure::{Axis, axis_range};
use super::page::absent;
use crate::io::result::ResultFile;
use crate::pipeline::{CameraQuality, DetectedQuality};

/// Whether detections alone tell how good the fit is.
pub(super) fn stand_alone(result: &ResultFile) -> bool {
    result.quality.views.is_empty() && !result.quality.detections.is_empty()
}

pub(super) fn joint_table(cameras: &[CameraQuality], words: &Words) -> Markup {
    let of = |camera: &CameraQuality, value: fn(&DetectedQuality) -> f64| {
        camera.detections.as_ref().map(value)
    };
    html! {
        div class="scroll" role="group" tabindex="0" aria-label=(words.of("Table")) {
            table class="numbers" {
                thead { tr {
                    th scope="col" { (words.of("Camera")) } th scope="col" { (words.of("Pictures")) } th scope="col" { (words.of("Joints off, median, px")) }
                    th scope="col" { (words.of("The same, % of the person's size")) }
                } }
                tbody { @for camera in cameras { tr {
                    th scope="row" { (camera.camera) }
                    td { (camera.detections.map_or(0, |joints| joints.pictures)) }
                    td { (words.number(of(camera, |joints| joints.median_px), 1)) }
                    td { (words.number(of(camera, |joints| 100.0 * joints.median_of_size), 0)) }
                } } }
            }
        }
        p class="note" {
            (words.of("There are no masks. The body was fitted to joints that another program saw in the pictures, so how thick it is comes from its \
                bones and from what people are like. A detector means each joint a centimetre or two elsewhere, which is no error of the motion. \
                A camera far above the others may have a wrong calibration."))
        }
    }
}

/// The distance in each frame, over its cameras.
pub(super) fn joint_chart(result: &ResultFile, words: &Words) -> Markup {
    let pictures = result.quality.detections.iter();
    let off = spreads(result, pictures.map(|picture| (picture.frame, picture.median_px)));
    let (range, step) = axis_range(off.iter().map(|off| off.most), (0.0, 1.0));
    let y = Axis { label: words.of("joints off, px").into(), range, step };
    let figure = figure(result, &off, y, words);

    html! {
        @if figure.is_empty() {
            (absent(words.of("No chart: fewer than two frames have detections.")))
        } @else {
            (figure.markup(words.of("Median distance of the detections from the body, frame by frame: mean of the cameras, and from the best to the worst of them."), words))
            p class="note" { (words.of("Line: mean of the cameras. Tint: from the best to the worst of them. Gaps: frames without detections, or in which the body was lost.")) }
        }
    }
}
