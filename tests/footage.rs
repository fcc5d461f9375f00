//! Pictures from images and videos: every layout, every number, and each way to be bad.

#[path = "footage/faults.rs"]
mod faults;
#[path = "footage/inputs.rs"]
mod inputs;
#[path = "footage/layouts.rs"]
mod layouts;
#[path = "footage/sound.rs"]
mod sound;
#[path = "footage/tiny.rs"]
mod tiny;
