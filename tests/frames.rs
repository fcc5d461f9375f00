//! Pictures from images and videos: every layout, every number, and each way to be bad.

#[path = "frames/faults.rs"]
mod faults;
#[path = "frames/layouts.rs"]
mod layouts;
#[path = "frames/tiny.rs"]
mod tiny;
