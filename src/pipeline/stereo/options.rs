//! How points are found, and with which cameras.

use std::collections::BTreeSet;

use super::StereoError;
use crate::camera::{CameraId, Rig};
use crate::stereo::SideBySide;
use crate::stereo::matching::MatchOptions;

/// How the place of a point is found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum StereoMethod {
    /// Disparity of each pair by correlation: fast, a point for every pixel.
    Correlation,
    /// Least-squares matching in all images at once: more exact.
    #[default]
    Matching,
}

/// Settings of [`super::measure_surface`].
#[derive(Debug, Clone, PartialEq)]
pub struct StereoOptions {
    /// How points are found (default: by matching).
    pub method: StereoMethod,
    /// Names of the cameras, the template's first (default none: the one in the middle and those beside it).
    pub cameras: Vec<String>,
    /// Nearest and farthest depth, m (default: from a shift of a third of an image to infinity).
    pub depth_m: Option<(f64, f64)>,
    /// Distance of neighbouring points in the template's image, px (default 2); of matching alone.
    pub spacing_px: usize,
    /// Cameras besides the template's that must show a point (default all); of matching alone.
    pub least_cameras: Option<usize>,
    /// Whether matched points are followed from frame to frame (default no).
    pub tracks: bool,
}

impl Default for StereoOptions {
    fn default() -> Self {
        Self {
            method: StereoMethod::default(),
            cameras: Vec::new(),
            depth_m: None,
            spacing_px: MatchOptions::default().spacing_px,
            least_cameras: None,
            tracks: false,
        }
    }
}

impl StereoOptions {
    /// The cameras that are used, the template's first.
    ///
    /// # Errors
    /// [`StereoError`] for names that the rig does not have, and where no two cameras stand side by side.
    pub fn choose_cameras(&self, rig: &Rig) -> Result<Vec<CameraId>, StereoError> {
        if self.cameras.is_empty() {
            let SideBySide { template, others } = SideBySide::choose(rig)?;
            return Ok(std::iter::once(template).chain(others).collect());
        }
        let named = self.cameras.iter().map(|name| {
            let found = rig.by_name(name.trim()).map(|(id, _)| id);
            found.ok_or_else(|| StereoError::NoCamera {
                camera: name.clone(),
                known: rig.names().collect::<Vec<_>>().join(", "),
            })
        });
        let cameras = named.collect::<Result<Vec<_>, _>>()?;

        let different: BTreeSet<&CameraId> = cameras.iter().collect();
        if cameras.len() < 2 || different.len() < cameras.len() {
            let cameras = self.cameras.join(",");
            return Err(StereoError::FewCameras { cameras });
        }
        Ok(cameras)
    }

    /// Those of matching in the images of `others` cameras besides the template's.
    pub(super) fn matching(&self, others: usize) -> MatchOptions {
        MatchOptions {
            spacing_px: self.spacing_px,
            least_images: self.least_cameras.unwrap_or(others),
            depth: self.depth_m,
            ..MatchOptions::default()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synth::Ring;

    fn chosen(names: &[&str]) -> Result<Vec<CameraId>, String> {
        let options = StereoOptions {
            cameras: names.iter().map(ToString::to_string).collect(),
            ..StereoOptions::default()
        };
        let cameras = options.choose_cameras(&Ring::default().regular());
        cameras.map_err(|fault| fault.to_string())
    }

    #[test]
    fn cameras_are_those_that_are_named_and_two_different_ones_at_least() {
        let names = Ring::default().regular();
        let names: Vec<&str> = names.names().collect();
        assert_eq!(chosen(&[names[2], names[0]]), Ok(vec![CameraId(2), CameraId(0)]));
        let nobody = chosen(&[names[0], "nobody"]).unwrap_err();
        assert!(
            nobody.starts_with("--cameras nobody: no such camera") && nobody.contains(names[1])
        );
        for few in [&names[..1], &[names[0], names[0]]] {
            assert!(chosen(few).unwrap_err().ends_with("two different cameras or more"));
        }
    }
}
