//! The clinical report: one file of HTML that needs nothing else, to read, to play and to print.
//!
//! [`html`] writes its text; nothing here touches a file. Pages and their words are explained in docs/report.md.
//!
//! | file                | holds                                                                |
//! |---------------------|----------------------------------------------------------------------|
//! | `page.rs`           | the document around the pages                                        |
//! | `identity.rs`       | who was recorded, and how                                             |
//! | `quality.rs`        | how far to trust it: cameras, missing views, confidence, hypotheses   |
//! | `rig_view.rs`       | the cameras from above, as calibrated and as found                    |
//! | `spatiotemporal.rs` | parameters of steps and strides                                       |
//! | `kinematics.rs`     | the grids of joint angles                                             |
//! | `scores.rs`         | key points of the curves, and scores against healthy people           |
//! | `shape.rs`          | lengths and girths of the body                                        |
//! | `motion.rs`         | empty frames for the moving body, its curves and its cameras          |
//! | `event_editor.rs`   | the line of time on which foot strikes and offs are corrected         |
//! | `scene.rs`          | what the page's program draws in them                                 |
//! | `views.rs`          | cameras and the outlines that they saw                                |
//! | `picture.rs`        | the pictures under the outlines, in few bytes                         |
//! | `viewer.rs`         | the moving body alone: [`viewer_html`]                                |
//! | `session.rs`        | several trials: [`session_html`]                                      |
//! | `drawing.rs`        | places in a drawing, as SVG writes them                               |
//! | `glance.rs`         | a walk at a glance, from the side                                     |
//! | `comparison.rs`     | two sessions, or two sides: [`comparison_html`]                       |
//! | `comparison_words.rs` | what its page says of each                                          |
//! | `variation.rs`      | how far numbers vary between strides and between trials               |
//! | `figure.rs`         | one chart                                                             |
//! | `label.rs`          | clinical names and signs                                              |
//! | `words.rs`          | what a page says, in the language of its reader; `language/` has it   |
//! | `bundle/`           | the page's program and style, built from `web/`                       |

mod by_frame;
mod comparison;
mod comparison_words;
mod drawing;
mod event_editor;
mod figure;
mod glance;
mod identity;
mod joints;
mod kinematics;
mod label;
mod motion;
mod page;
mod picture;
mod quality;
mod rig_view;
mod scene;
mod scores;
mod session;
mod shape;
mod spatiotemporal;
mod variation;
mod viewer;
mod views;
mod words;

use crate::gait::{Footwear, GaitAnalysis, Movement, Norm};
use crate::io::gait::Sex;
use crate::io::result::ResultFile;
use crate::pipeline::FittedBody;

pub use comparison::{Compared, ComparisonInput, comparison_html};
pub use picture::{FramePicture, ImagePart, PictureBudget};
pub use session::{ReportedTrial, SessionInput, session_html};
pub use viewer::{ViewerInput, viewer_html};
pub use views::{CameraOutlines, Views, joint_marks, outline_points};
pub use words::{Language, Words};

/// Who was recorded, when and how, as the report shall state it.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Subject {
    /// The recording: name of its folder or file.
    pub recording: String,
    /// Name or number of the person.
    pub name: Option<String>,
    /// Their age, completed years.
    pub age_years: Option<u32>,
    /// Their sex.
    pub sex: Option<Sex>,
    /// Date of the recording.
    pub date: Option<String>,
    /// With an orthosis, on a slope, …
    pub condition: Option<String>,
    /// What they wore on their feet.
    pub footwear: Option<Footwear>,
}

/// Everything that a report shows.
#[derive(Debug, Clone, Copy)]
pub struct ReportInput<'a> {
    /// Who and when.
    pub subject: &'a Subject,
    /// The fit; `None` of points of another system.
    pub result: Option<&'a ResultFile>,
    /// Its body; `None` of points of another system.
    pub body: Option<&'a FittedBody>,
    /// The movement that was analysed.
    pub movement: &'a Movement,
    /// Its analysis.
    pub gait: &'a GaitAnalysis,
    /// Healthy people.
    pub norm: Option<&'a Norm>,
    /// What the cameras saw; empty if the recording is not at hand.
    pub views: &'a Views,
    /// What the page says.
    pub words: &'a Words,
}

/// The report as the text of one file.
///
/// # Errors
/// The serialiser's, if it has any.
pub fn html(input: &ReportInput<'_>) -> Result<String, serde_json::Error> {
    let scene = serde_json::to_string(&scene::Scene::new(input))?;
    let pages = [
        identity::page(input),
        quality::page(input),
        spatiotemporal::page(input),
        kinematics::page(input),
        kinematics::consistency(input),
        scores::page(input),
        shape::page(input),
        motion::page(input, event_editor::editor(input)),
    ];
    let banner = input.result.and_then(|result| page::banner(&result.verdict, input.words));
    Ok(page::document(input.subject, banner.as_ref(), &pages, Some(&scene), input.words))
}
