//! How silhouettes are taken from masks.

use serde::{Deserialize, Serialize};

use crate::image::CleanOptions;

/// How a silhouette is taken from a mask. "Size" is the longer side of the person's box in the image.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SilhouetteOptions {
    /// Specks and holes.
    pub clean: CleanOptions,
    /// Smallest distance of neighbouring contour points, px (default 1.5).
    pub spacing_px: f64,
    /// Contour points along the person's size (default 250): the distance of neighbouring points is
    /// max(`spacing_px`, size/`points_per_size`), so a silhouette has about as many points at any resolution.
    pub points_per_size: f64,
    /// Cells of the distance map along its longer side (default 180), unless they would be smaller than a pixel.
    pub map_cells: usize,
    /// How far the distance map reaches beyond the person's box on each side, over the person's size (default 0.3).
    pub map_margin: f64,
}

impl Default for SilhouetteOptions {
    fn default() -> Self {
        Self {
            clean: CleanOptions::default(),
            spacing_px: 1.5,
            points_per_size: 250.0,
            map_cells: 180,
            map_margin: 0.3,
        }
    }
}

/// An option outside its range.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("option {name} = {value}: expected {least} to {most}")]
pub struct InvalidOption {
    /// Which option.
    pub name: &'static str,
    /// What it was set to.
    pub value: f64,
    /// Smallest value allowed.
    pub least: f64,
    /// Largest value allowed.
    pub most: f64,
}

impl SilhouetteOptions {
    /// Whether every option is in its range.
    ///
    /// # Errors
    /// [`InvalidOption`] for the first that is not.
    pub fn validate(&self) -> Result<(), InvalidOption> {
        let clean = &self.clean;
        let cells = self.map_cells as f64;
        let ranges = [
            ("part_fraction", clean.part_fraction, 0.0, 1.0),
            ("fragment_fraction", clean.fragment_fraction, 0.0, 1.0),
            ("fragment_gap", clean.fragment_gap, 0.0, 1.0),
            ("hole_fraction", clean.hole_fraction, 0.0, 1.0),
            ("spacing_px", self.spacing_px, 0.25, 100.0),
            ("points_per_size", self.points_per_size, 10.0, 10_000.0),
            ("map_cells", cells, 8.0, 2_000.0),
            ("map_margin", self.map_margin, 0.0, 10.0),
        ];

        for (name, value, least, most) in ranges {
            if !(least..=most).contains(&value) {
                return Err(InvalidOption { name, value, least, most });
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_defaults_are_valid_and_nonsense_is_named() {
        let defaults = SilhouetteOptions::default();
        assert_eq!(defaults.validate(), Ok(()));
        let fault = SilhouetteOptions { spacing_px: f64::NAN, ..defaults };
        let message = fault.validate().unwrap_err().to_string();
        assert_eq!(message, "option spacing_px = NaN: expected 0.25 to 100");
    }
}
