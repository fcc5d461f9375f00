//! Empty frames for the moving body, its curves and its cameras, which the page's program fills.

use maud::{Markup, html};

use super::joints::stand_alone;
use super::page::{Page, absent};
use super::{ReportInput, Words};
use crate::gait::Movement;

/// The page; `events` stands above the curves.
pub(super) fn page<'a>(input: &ReportInput<'a>, events: Option<Markup>) -> Page<'a> {
    let words = input.words;
    Page {
        id: "motion",
        title: words.of("Motion"),
        body: html! {
            (no_webgl(words.of("This browser shows no 3-D (WebGL is off): the curves follow the slider, the body does not.")))
            @if input.body.is_none() {
                (absent(words.of("Points of another system: lines between the points in place of a fitted body.")))
            }
            div class="player" {
                (stage(words))
                (cameras(input))
            }
            (controls(input.movement, words))
            @if !input.views.cameras.is_empty() {
                div class="sheet" id="sheet" role="img" aria-label=(words.of("The fitted body under the recorded outline, all cameras, middle frame")) {}
            }
            @if let Some(events) = events { (events) }
            div class="choice" {
                label { (words.of("curves")) " " select id="group" {} }
                span class="key" { span class="left" { (words.known("left")) } span class="right" { (words.known("right")) } }
            }
            div id="curves" role="img" aria-label=(words.of("Joint angles over time, with a line at the shown frame")) {}
        },
        is_brief: false,
    }
}

/// What is shown in the place of the body by a browser that cannot.
pub(super) fn no_webgl(why: &str) -> Markup {
    html! { p class="absent" id="no-webgl" hidden { (why) } }
}

/// The room of the moving body.
pub(super) fn stage(words: &Words) -> Markup {
    html! {
        div class="stage" {
            canvas id="stage" tabindex="0" role="img" aria-label=(words.of("The moving body in 3-D. Arrow keys turn it, plus and minus zoom.")) {}
        }
    }
}

/// What moves it.
pub(super) fn controls(movement: &Movement, words: &Words) -> Markup {
    let (first, last) = (movement.first_frame, movement.frames.saturating_sub(1));
    html! {
        div class="controls" {
            button type="button" id="play" aria-label=(words.of("Play")) { "▶" }
            input type="range" id="time" min="0" max=(last) value="0" step="1"
                aria-label=(words.fill("Frame, from {first} to {last}", &[("first", &first), ("last", &(first + last))]));
            output id="clock" for="time" {}
            label { (words.of("speed")) " " select id="speed" {
                option value="1" { "1" } option value="0.5" { "½" } option value="0.25" { "¼" } option value="0.1" { "⅒" }
            } }
        }
    }
}

fn cameras(input: &ReportInput<'_>) -> Markup {
    let (cameras, words) = (&input.views.cameras, input.words);
    let seen = match input.result.is_some_and(stand_alone) {
        true => words.of("Yellow: joints that another program saw in the picture."),
        false => words.of("Yellow: recorded outline."),
    };

    html! {
        div class="camera" {
            @if cameras.is_empty() {
                (absent(words.of("No camera views: the recording was not at hand (give --recording).")))
            } @else {
                canvas id="camera" role="img" aria-label=(words.of("The fitted body as the chosen camera sees it, with the recorded outline over it")) {}
                label { (words.of("camera")) " " select id="camera-choice" {
                    @for (i, view) in cameras.iter().enumerate() { option value=(i) { (view.name) } }
                } }
                @if input.views.has_pictures() {
                    label { input type="checkbox" id="camera-body" checked; " " (words.of("fitted body")) }
                }
                p class="note" {
                    (seen) " "
                    @if input.views.has_pictures() {
                        (words.of("Under it: the recorded picture and the fitted body over it."))
                    } @else {
                        (words.of("Under it: the fitted body."))
                    }
                    " " (words.of("All without the lens's distortion."))
                    @if input.views.every > 1 {
                        " " (words.fill("To keep this file small, one of {n} frames is shown here.", &[("n", &input.views.every)]))
                    }
                }
            }
        }
    }
}
