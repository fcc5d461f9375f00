//! The sequence posterior and the joint optimum: laws, truth in and estimate out, and what nothing sees.

#[path = "joint/journal.rs"]
mod journal;
#[path = "joint/laws.rs"]
mod laws;
#[path = "joint/places.rs"]
mod places;
#[path = "joint/recovery.rs"]
mod recovery;
#[path = "joint/scene.rs"]
mod scene;
#[path = "joint/session.rs"]
mod session;
#[path = "joint/shared.rs"]
mod shared;
#[path = "joint/trials.rs"]
mod trials;
#[path = "joint/unseen.rs"]
mod unseen;
#[path = "joint/worn.rs"]
mod worn;
