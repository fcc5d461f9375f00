//! The moving body alone: a page that fits into a frame of another one, such as a notebook's.

use maud::{DOCTYPE, html};

use super::motion::{controls, no_webgl, stage};
use super::page::{banner, program, style};
use super::scene::Scene;
use super::{Language, Words};
use crate::gait::Movement;
use crate::pipeline::{FittedBody, Verdict};

/// What the page shows.
#[derive(Debug, Clone, Copy)]
pub struct ViewerInput<'a> {
    /// The fitted body; `None` of points of another system.
    pub body: Option<&'a FittedBody>,
    /// How it moves.
    pub movement: &'a Movement,
    /// Whether it is the person: if not, the page says so.
    pub verdict: &'a Verdict,
}

/// The page as the text of one file, which asks nobody for anything. It is as high as its frame.
///
/// # Errors
/// The serialiser's, if it has any.
pub fn viewer_html(input: &ViewerInput<'_>) -> Result<String, serde_json::Error> {
    let words = Words::new(Language::English);
    let scene = serde_json::to_string(&Scene::of_body(input.movement, input.body, &words))?;
    let markup = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                title { "Fitted body" }
                (style())
            }
            body class="viewer" {
                @if let Some(banner) = banner(input.verdict, &words) { (banner) }
                (no_webgl("This browser shows no 3-D (WebGL is off): nothing is shown of the body."))
                (stage(&words))
                (controls(input.movement, &words))
                (program(&scene))
            }
        }
    };
    Ok(markup.into_string())
}
