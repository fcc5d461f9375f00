//! Stereo on scenes whose truth is known: points on planes before cameras, and what cannot be measured.

#![allow(unreachable_pub, reason = "a scene shared by the tests")]

#[path = "stereo/faults.rs"]
mod faults;
#[path = "stereo/laws.rs"]
mod laws;
#[path = "stereo/scene.rs"]
mod scene;
#[path = "stereo/surface.rs"]
mod surface;
#[path = "stereo/tracks.rs"]
mod tracks;
