//! The clinical report: one page of HTML that needs nothing else, to be read, moved and printed.
//!
//! [`html`] makes the text; nothing here touches a file. Pages and their words are explained in docs/report.md.
//!
//! | file                | holds                                                                |
//! |---------------------|----------------------------------------------------------------------|
//! | `page.rs`           | the document around the pages                                        |
//! | `identity.rs`       | who, how measured                                                     |
//! | `quality.rs`        | whether to trust it: cameras, missing views, confidence, hypotheses   |
//! | `spatiotemporal.rs` | parameters of steps and strides                                       |
//! | `kinematics.rs`     | the grids of joint angles                                             |
//! | `scores.rs`         | key points of the curves, and scores against healthy people           |
//! | `shape.rs`          | lengths and girths of the body                                        |
//! | `motion.rs`         | places for the body that moves, its curves and cameras                |
//! | `scene.rs`          | what the page's program shows there                                   |
//! | `views.rs`          | cameras and the outlines that they saw                                |
//! | `figure.rs`         | one chart                                                             |
//! | `label.rs`          | clinical names and signs                                              |
//! | `bundle/`           | the page's program and style, built from `web/`                       |

mod figure;
mod identity;
mod kinematics;
mod label;
mod motion;
mod page;
mod quality;
mod scene;
mod scores;
mod shape;
mod spatiotemporal;
mod views;

use crate::gait::{GaitAnalysis, Norm};
use crate::io::gait::{GaitFile, GaitInput, Sex};
use crate::io::result::ResultFile;

pub use views::{CameraOutlines, outline_points};

/// What the person who makes the report says about it.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Identity {
    /// What was recorded: name of the folder or file.
    pub recording: String,
    /// Who was recorded.
    pub subject: Option<String>,
    /// Their age, completed years, and their sex.
    pub person: (Option<u32>, Option<Sex>),
    /// When.
    pub date: Option<String>,
    /// Barefoot, with an orthosis, …
    pub condition: Option<String>,
}

/// Everything that a report shows.
#[derive(Debug, Clone, Copy)]
pub struct ReportInput<'a> {
    /// Who and when.
    pub identity: &'a Identity,
    /// The fit; `None` of points of another system.
    pub result: Option<&'a ResultFile>,
    /// What was analysed.
    pub input: &'a GaitInput,
    /// What was found.
    pub gait: &'a GaitAnalysis,
    /// The same in units of files.
    pub file: &'a GaitFile,
    /// Healthy people.
    pub norm: Option<&'a Norm>,
    /// What the cameras saw; empty if the recording is not at hand.
    pub views: &'a [CameraOutlines],
}

/// The report as the text of one file.
///
/// # Errors
/// The serialiser's, if it has any.
pub fn html(input: &ReportInput<'_>) -> Result<String, serde_json::Error> {
    let scene = serde_json::to_string(&scene::Scene::of(input))?;
    let pages = [
        identity::page(input),
        quality::page(input),
        spatiotemporal::page(input),
        kinematics::page(input),
        kinematics::consistency(input),
        scores::page(input),
        shape::page(input),
        motion::page(input),
    ];
    Ok(page::document(input.identity, &pages, &scene))
}
