//! What gait analysis reads and writes: points or a fit in; `gait.json` and tables out; norms of healthy people.

mod events;
mod norm;
mod norm_text;
mod people;
mod read;
mod schema;
mod tables;
mod trials;

pub use events::{EVENTS, EventFault, EventsError, read_events};
pub use norm::{NormError, load_norm, parse_norm, shipped_norm};
pub use norm_text::norm_text;
pub use people::{Sex, add_parameters};
pub use read::{GaitInput, GaitInputError, from_result, read_points};
pub use schema::gait_file;
pub use tables::{angles_csv, curves_csv, parameters_csv};
pub use trials::{changes_csv, curve_changes_csv, variation_csv};
