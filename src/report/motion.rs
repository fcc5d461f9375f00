//! Empty frames for the moving body, its curves and its cameras, which the page's program fills.

use maud::{Markup, html};

use super::ReportInput;
use super::joints::stand_alone;
use super::page::{Page, absent};
use crate::gait::Movement;

/// The page; `events` stands above the curves.
pub(super) fn page(input: &ReportInput<'_>, events: Option<Markup>) -> Page {
    Page {
        id: "motion",
        title: "Motion",
        body: html! {
            (no_webgl("the curves follow the slider, the body does not"))
            @if input.body.is_none() {
                (absent("Points of another system: lines between the points in place of a fitted body."))
            }
            div class="player" {
                (stage())
                (cameras(input))
            }
            (controls(input.movement))
            @if !input.views.cameras.is_empty() {
                div class="sheet" id="sheet" role="img" aria-label="The fitted body under the recorded outline, all cameras, middle frame" {}
            }
            @if let Some(events) = events { (events) }
            div class="choice" {
                label { "curves " select id="group" {} }
                span class="key" { span class="left" { "left" } span class="right" { "right" } }
            }
            div id="curves" role="img" aria-label="Joint angles over time, with a line at the shown frame" {}
        },
        is_brief: false,
    }
}

/// What is shown in the place of the body by a browser that cannot.
pub(super) fn no_webgl(instead: &str) -> Markup {
    html! { p class="absent" id="no-webgl" hidden { "This browser shows no 3-D (WebGL is off): " (instead) "." } }
}

/// The room of the moving body.
pub(super) fn stage() -> Markup {
    html! {
        div class="stage" {
            canvas id="stage" tabindex="0" role="img" aria-label="The moving body in 3-D. Arrow keys turn it, plus and minus zoom." {}
        }
    }
}

/// What moves it.
pub(super) fn controls(movement: &Movement) -> Markup {
    let (first, last) = (movement.first_frame, movement.frames.saturating_sub(1));
    html! {
        div class="controls" {
            button type="button" id="play" aria-label="Play" { "▶" }
            input type="range" id="time" min="0" max=(last) value="0" step="1"
                aria-label={ "Frame, from " (first) " to " (first + last) };
            output id="clock" for="time" {}
            label { "speed " select id="speed" {
                option value="1" { "1" } option value="0.5" { "½" } option value="0.25" { "¼" } option value="0.1" { "⅒" }
            } }
        }
    }
}

fn cameras(input: &ReportInput<'_>) -> Markup {
    let cameras = &input.views.cameras;

    html! {
        div class="camera" {
            @if cameras.is_empty() {
                (absent("No camera views: the recording was not at hand (give --recording)."))
            } @else {
                canvas id="camera" role="img" aria-label="The fitted body as the chosen camera sees it, with the recorded outline over it" {}
                label { "camera " select id="camera-choice" {
                    @for (i, view) in cameras.iter().enumerate() { option value=(i) { (view.name) } }
                } }
                @if input.views.has_pictures() {
                    label { input type="checkbox" id="camera-body" checked; " fitted body" }
                }
                p class="note" {
                    "Yellow: " (seen(input)) ". Under it: "
                    @if input.views.has_pictures() { "the recorded picture and the fitted body over it" } @else { "the fitted body" }
                    ". All without the lens's distortion."
                    @if input.views.every > 1 { " To keep this file small, every " (input.views.every) "th frame is shown here." }
                }
            }
        }
    }
}

/// What the cameras saw.
fn seen(input: &ReportInput<'_>) -> &'static str {
    match input.result.is_some_and(stand_alone) {
        true => "joints that another program saw in the picture",
        false => "recorded outline",
    }
}
