//! The line of time on which a person corrects foot strikes and foot offs; the page's program fills it.

use maud::{Markup, html};

use super::{ReportInput, Words};
use crate::gait::{EventSource, Side};

/// What the buttons add: side and kind as `events.json` names them, and in words.
fn added(words: &Words) -> [(Side, &str, &str); 4] {
    [
        (Side::Left, "strike", words.of("left strike")),
        (Side::Left, "off", words.of("left off")),
        (Side::Right, "strike", words.of("right strike")),
        (Side::Right, "off", words.of("right off")),
    ]
}

/// The editor; none of a fit that cannot be used, which has no numbers to be corrected.
pub(super) fn editor(input: &ReportInput<'_>) -> Option<Markup> {
    let why_unusable = input.result.and_then(|result| result.verdict.why_unusable());
    if why_unusable.is_some() {
        return None;
    }

    let words = input.words;
    Some(html! {
        div class="events" id="events" {
            h3 { (words.of("Foot strikes ▼ and foot offs △")) @if is_corrected(input) { (words.of(", corrected by a person")) } }
            div id="event-lanes" {}
            div class="edit" {
                @for (side, kind, event) in added(words) {
                    button type="button" data-side=(side.name()) data-kind=(kind) aria-label=(words.fill("Add at the shown frame: {event}", &[("event", &event)])) { "+ " (event) }
                }
                button type="button" id="event-delete" aria-label=(words.of("Delete the chosen mark")) { (words.of("Delete")) }
                button type="button" id="event-undo" aria-label=(words.of("Undo all changes")) { (words.of("Undo all")) }
                button type="button" id="event-save" aria-label=(words.of("Save events.json")) { (words.of("Save events.json")) }
            }
            p class="note" id="event-says" role="status" {}
            p class="note how" {
                (words.of("Drag a mark, or choose it and press the arrow keys or Delete.")) " " (how_to_use(input))
            }
        }
    })
}

fn is_corrected(input: &ReportInput<'_>) -> bool {
    input.gait.event_source == EventSource::Person
}

/// Where the saved file belongs.
fn how_to_use<'a>(input: &ReportInput<'a>) -> &'a str {
    let words = input.words;
    match input.result {
        Some(_) => words.of(
            "Save events.json into the folder of the fit and make the report again: all numbers are then of your events.",
        ),
        None => words.of(
            "Save events.json and make the report again with --events: all numbers are then of your events.",
        ),
    }
}
