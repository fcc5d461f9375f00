//! The cameras of a recording: those with files, matched by name with the calibrated ones.

use std::path::PathBuf;

use super::manifest::CameraFiles;
use super::{Recording, RecordingError, layout};
use crate::camera::Rig;
use crate::io::calibration::{self, CalibrationOptions};
use crate::io::unknown_key::nearest;

/// The cameras that have files of one kind and are calibrated.
pub(super) struct CalibratedCameras<F> {
    /// Their calibration.
    pub(super) rig: Rig,
    /// Their files, in the order of the rig.
    pub(super) cameras: Vec<(CameraFiles, F)>,
    /// Names of a folder's cameras that are not calibrated.
    pub(super) uncalibrated: Vec<UnknownCamera>,
    /// Calibrated cameras without files in the folder.
    pub(super) without_files: Vec<String>,
}

/// A name that is no calibrated camera's.
pub(super) struct UnknownCamera {
    pub(super) name: String,
    /// The calibrated camera whose name is most like it.
    pub(super) nearest: String,
}

impl Recording {
    /// Calibrates the cameras. Those of a manifest must all be calibrated; a folder's uncalibrated cameras are left out.
    ///
    /// `size` is the width and height of a camera's pictures, for calibrations that do not state it.
    pub(super) fn calibrate<F>(
        &self,
        cameras: Vec<(CameraFiles, F)>,
        size: impl Fn(&F) -> Option<[u32; 2]>,
    ) -> Result<CalibratedCameras<F>, RecordingError> {
        let sizes =
            cameras.iter().filter_map(|(camera, files)| Some((camera.name.clone(), size(files)?)));
        let calibrated = self.read_calibration(CalibrationOptions {
            image_sizes_px: sizes.collect(),
            ..self.calibration_options()
        })?;

        let mut found = CalibratedCameras {
            rig: Rig::default(),
            cameras,
            uncalibrated: Vec::new(),
            without_files: Vec::new(),
        };
        if self.manifest.cameras.is_empty() {
            found.keep_calibrated(&calibrated);
        }

        let names = found.cameras.iter().map(|(camera, _)| camera.name.as_str());
        let names: Vec<&str> = names.collect();
        found.rig = calibration::select(&calibrated, &self.calibration_source(), &names)?;
        Ok(found)
    }

    /// The cameras of the manifest or, where it lists none, of the calibration; for points without masks.
    pub(super) fn all_cameras(&self) -> Result<Rig, RecordingError> {
        let calibrated = self.read_calibration(self.calibration_options())?;
        let names: Vec<&str> = match self.manifest.cameras.as_slice() {
            [] => calibrated.names().collect(),
            cameras => cameras.iter().map(|camera| camera.name.as_str()).collect(),
        };
        Ok(calibration::select(&calibrated, &self.calibration_source(), &names)?)
    }

    /// The files or folders that the calibration is read from, each with its camera where there is one for each.
    pub(super) fn calibration_paths(&self) -> Vec<(Option<String>, PathBuf)> {
        layout::calibration_paths(&self.folder, self.manifest.calibration.as_ref())
    }

    fn calibration_options(&self) -> CalibrationOptions {
        CalibrationOptions {
            unit: self.manifest.unit,
            up: self.manifest.up,
            ..CalibrationOptions::default()
        }
    }

    fn read_calibration(&self, options: CalibrationOptions) -> Result<Rig, RecordingError> {
        Ok(layout::read_calibration(&self.calibration_paths(), &options)?)
    }

    /// The path that errors name as the calibration.
    fn calibration_source(&self) -> PathBuf {
        match self.calibration_paths().as_slice() {
            [(_, source)] => source.clone(),
            _ => self.path.clone(),
        }
    }
}

impl<F> CalibratedCameras<F> {
    /// Keeps the calibrated cameras, under their calibrated names and in that order, and lists the others.
    ///
    /// If none is calibrated they stay as they are, to be refused.
    fn keep_calibrated(&mut self, calibrated: &Rig) {
        for (camera, _) in &mut self.cameras {
            if let Some(name) = name_alike(calibrated, &camera.name) {
                camera.name = name;
            }
        }
        let position = |name: &str| calibrated.by_name(name).map(|(id, _)| id);
        if !self.cameras.iter().any(|(camera, _)| position(&camera.name).is_some()) {
            return;
        }

        let names: Vec<&str> = calibrated.names().collect();
        let (mut known, unknown): (Vec<_>, Vec<_>) = std::mem::take(&mut self.cameras)
            .into_iter()
            .partition(|(camera, _)| position(&camera.name).is_some());
        known.sort_by_key(|(camera, _)| position(&camera.name));
        self.uncalibrated = unknown
            .into_iter()
            .map(|(camera, _)| UnknownCamera {
                nearest: nearest(&camera.name, &names).unwrap_or_default().into(),
                name: camera.name,
            })
            .collect();

        let has_files = |name: &&str| known.iter().any(|(camera, _)| camera.name == **name);
        let without = names.iter().filter(|name| !has_files(name));
        self.without_files = without.map(|name| (*name).into()).collect();
        self.cameras = known;
    }
}

/// The only calibrated camera whose name has the same letters and digits (`cam_01` for `cam01`); `None` if one has exactly this name.
fn name_alike(rig: &Rig, name: &str) -> Option<String> {
    let plain = |name: &str| {
        let letters = name.chars().filter(|c| c.is_alphanumeric());
        letters.flat_map(char::to_lowercase).collect::<String>()
    };
    if rig.by_name(name).is_some() {
        return None;
    }
    let mut alike = rig.names().filter(|other| plain(other) == plain(name));
    let first = alike.next()?;
    alike.next().is_none().then(|| first.into())
}
