//! Why two images give no depth.

/// Why two images cannot be rectified, or not correlated.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum DepthError {
    /// The cameras are in one place.
    #[error(
        "cameras {left} and {right} are {distance_mm:.3} mm apart: expected a distance between them, to measure depth by"
    )]
    NoBaseline {
        /// First camera.
        left: String,
        /// Second camera.
        right: String,
        /// Distance between them.
        distance_mm: f64,
    },
    /// One camera sees the other, or they look at different things.
    #[error(
        "cameras {left} and {right} do not look side by side ({angle_deg:.0}° between their axes, or one sees the other): expected at most 60°"
    )]
    NotSideBySide {
        /// First camera.
        left: String,
        /// Second camera.
        right: String,
        /// Angle between the optical axes.
        angle_deg: f64,
    },
    /// The turned images have no rows in common.
    #[error("cameras {left} and {right} see no common rows once rectified")]
    NoCommonRows {
        /// First camera.
        left: String,
        /// Second camera.
        right: String,
    },
    /// The images have different numbers of rows.
    #[error("the rectified images have {left} and {right} rows: expected the same number")]
    Rows {
        /// Of the left image.
        left: usize,
        /// Of the right image.
        right: usize,
    },
    /// Too few or too many disparities, or none that leads into the other image.
    #[error(
        "disparities {first} to {last} px: expected 3 to 256 of them, and some that lead from an image of {left} px into one of {right} px"
    )]
    Range {
        /// The least.
        first: i64,
        /// The largest.
        last: i64,
        /// Width of the left image.
        left: usize,
        /// Width of the right image.
        right: usize,
    },
    /// Penalties too large for a byte, or P₁ larger than P₂.
    #[error("penalties {step} and {jump}: expected step ≤ jump ≤ 60")]
    Penalties {
        /// P₁.
        step: u8,
        /// P₂.
        jump: u8,
    },
}
