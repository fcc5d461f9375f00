//! The program from outside: what it reads, writes, prints and refuses.

#[path = "cli/arm.rs"]
mod arm;
#[path = "cli/fit.rs"]
mod fit;
#[path = "cli/others.rs"]
mod others;
#[path = "cli/refusals.rs"]
mod refusals;
#[path = "cli/resume.rs"]
mod resume;
#[path = "cli/segment.rs"]
mod segment;
#[path = "cli/skin.rs"]
mod skin;
