//! The line of time on which a person corrects foot strikes and foot offs; the page's program fills it.

use maud::{Markup, html};

use super::ReportInput;
use crate::gait::{EventSource, Side};

/// What the buttons add: side and kind as `events.json` names them, and in words.
const ADDED: [(Side, &str, &str); 4] = [
    (Side::Left, "strike", "left strike"),
    (Side::Left, "off", "left off"),
    (Side::Right, "strike", "right strike"),
    (Side::Right, "off", "right off"),
];

/// The editor; none of a fit that cannot be used, which has no numbers to be corrected.
pub(super) fn editor(input: &ReportInput<'_>) -> Option<Markup> {
    let why_unusable = input.result.and_then(|result| result.verdict.why_unusable());
    if why_unusable.is_some() {
        return None;
    }

    Some(html! {
        div class="events" id="events" {
            h3 { "Foot strikes ▼ and foot offs △" @if is_corrected(input) { ", corrected by a person" } }
            div id="event-lanes" {}
            div class="edit" {
                @for (side, kind, words) in ADDED {
                    button type="button" data-side=(side.name()) data-kind=(kind) aria-label={ "Add a " (words) " at the shown frame" } { "+ " (words) }
                }
                button type="button" id="event-delete" aria-label="Delete the chosen mark" { "Delete" }
                button type="button" id="event-undo" aria-label="Undo all changes" { "Undo all" }
                button type="button" id="event-save" aria-label="Save events.json" { "Save events.json" }
            }
            p class="note" id="event-says" role="status" {}
            p class="note how" {
                "Drag a mark, or choose it and press the arrow keys or Delete. " (how_to_use(input))
            }
        }
    })
}

fn is_corrected(input: &ReportInput<'_>) -> bool {
    input.gait.event_source == EventSource::Person
}

/// Where the saved file belongs.
fn how_to_use(input: &ReportInput<'_>) -> &'static str {
    match input.result {
        Some(_) => {
            "Save events.json into the folder of the fit and make the report again: all numbers are then of your events."
        }
        None => {
            "Save events.json and make the report again with --events: all numbers are then of your events."
        }
    }
}
