//! Recordings on disk: good ones of every layout, each way to be bad, and the shared ones.

#[path = "recordings/detections.rs"]
mod detections;
#[path = "recordings/faults.rs"]
mod faults;
#[path = "recordings/layouts.rs"]
mod layouts;
#[path = "recordings/points.rs"]
mod points;
#[path = "recordings/shared_data.rs"]
mod shared_data;
#[path = "recordings/tiny.rs"]
mod tiny;
