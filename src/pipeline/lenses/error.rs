//! Why cameras cannot be placed by a person.

/// What the detections do not tell.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum LensError {
    /// No two cameras see the person at the same time.
    #[error(
        "no two cameras see the person's joints together often enough: {most} joints at most, of {least} (detections of one person are in pose/, and several people in a picture do not count)"
    )]
    NeverTogether {
        /// Joints that two cameras have in common.
        most: usize,
        /// How many there must be.
        least: usize,
    },
    /// A camera that sees the person together with none of the others.
    #[error(
        "{camera} sees the person's joints together with no camera that is placed, or its detections fit to none: {common} joints in common at most"
    )]
    Apart {
        /// The camera.
        camera: String,
        /// Joints that it has in common with another.
        common: usize,
    },
    /// Sights that do not fit together.
    #[error(
        "the detections of the cameras do not agree: they lie {spread:.1} times as far from the joints as published labels scatter; are the lenses right, are the files those of the cameras, and are the clocks together?"
    )]
    Disagreeing {
        /// How far they lie off, over what published labels scatter by.
        spread: f64,
    },
    /// A motion that does not determine a camera.
    #[error(
        "the motion does not determine where {camera} is: ± {turn_sd_deg:.1}°, ± {place_sd_mm:.0} mm; let the person walk through the whole room, to and fro and across"
    )]
    Undetermined {
        /// The camera that is known least.
        camera: String,
        /// Standard deviation of its turn.
        turn_sd_deg: f64,
        /// Standard deviation of its place.
        place_sd_mm: f64,
    },
    /// A person of whom no ankles or neck are seen.
    #[error(
        "nothing tells which way is up: the person's ankles, neck and shoulders are never seen"
    )]
    NoUp,
    /// Nothing tells how large the person is.
    #[error("nothing tells how large the person is: no bone is seen whole")]
    NoSize,
}
