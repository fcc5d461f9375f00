//! The program from outside: what it reads, writes, prints and refuses.

#![allow(unreachable_pub, reason = "a scene shared with the tests of stereo")]

#[path = "cli/arm.rs"]
mod arm;
#[path = "cli/cameras.rs"]
mod cameras;
#[path = "cli/changed.rs"]
mod changed;
#[path = "gait/events.rs"]
mod events;
#[path = "cli/fit.rs"]
mod fit;
#[path = "gait/program.rs"]
mod gait;
#[path = "cli/odd_files.rs"]
mod odd_files;
#[path = "cli/others.rs"]
mod others;
#[path = "cli/progress.rs"]
mod progress;
#[path = "cli/refusals.rs"]
mod refusals;
#[path = "gait/report.rs"]
mod report;
#[path = "cli/resume.rs"]
mod resume;
#[allow(dead_code, reason = "a scene shared with the tests of stereo")]
#[path = "../../tests/stereo/scene.rs"]
mod scene;
#[path = "cli/schema.rs"]
mod schema;
#[path = "cli/segment.rs"]
mod segment;
#[path = "cli/session.rs"]
mod session;
#[path = "cli/silhouettes.rs"]
mod silhouettes;
#[path = "cli/simulate.rs"]
mod simulate;
#[path = "cli/skin.rs"]
mod skin;
#[path = "cli/stereo.rs"]
mod stereo;
#[path = "cli/verdict.rs"]
mod verdict;
#[path = "cli/videos.rs"]
mod videos;
#[path = "cli/views.rs"]
mod views;
#[allow(dead_code, reason = "a walker shared with the tests of gait")]
#[path = "../../tests/gait/walker.rs"]
mod walker;
