//! The cameras of a recording: those with files, matched by name with the calibrated ones.

use std::path::{Path, PathBuf};

use super::manifest::CameraFiles;
use super::note::CalibrationNote;
use super::{DetectionFiles, Recording, RecordingError, Stand, layout};
use crate::camera::{Camera, PoseForm, Rig, UpAxis};
use crate::io::calibration::{self, CalibrationOptions, Poses};
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
            found.refuse_strangers(&calibrated, &self.path)?;
        }

        if let Some((_, offsets)) = &self.offsets {
            offsets.apply(found.cameras.iter_mut().map(|(camera, _)| camera));
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

    /// What is stated of each camera of a rig, and when it began.
    pub(super) fn stated(&self, rig: &Rig) -> Vec<CameraFiles> {
        let stated = |name: &str| {
            let listed = self.manifest.cameras.iter().find(|c| c.name == name).cloned();
            listed.unwrap_or_else(|| CameraFiles { name: name.into(), ..CameraFiles::default() })
        };
        let mut cameras: Vec<CameraFiles> = rig.names().map(stated).collect();
        if let Some((_, offsets)) = &self.offsets {
            offsets.apply(cameras.iter_mut());
        }
        cameras
    }

    /// The files or folders that the calibration is read from, each with its camera where there is one for each.
    pub(super) fn calibration_paths(&self) -> Vec<(Option<String>, PathBuf)> {
        layout::calibration_paths(&self.folder, self.manifest.calibration.as_ref())
    }

    /// Every file of the calibration.
    pub(super) fn calibration_files(&self) -> Vec<PathBuf> {
        let paths = self.calibration_paths();
        paths.iter().flat_map(|(_, source)| calibration::files(source)).collect()
    }

    /// The whole calibration, in metres with Z up, and how its files are read: also of cameras without masks or pictures, if their size is
    /// stated.
    ///
    /// # Errors
    /// [`RecordingError`] if neither masks nor pictures are there, or the calibration is at fault.
    pub fn calibration(&self) -> Result<(Rig, CalibrationOptions), RecordingError> {
        let used = match self.masks() {
            Ok(files) if files.has_masks() || DetectionFiles::are_promised(self) => files.rig,
            _ => self.footage()?.rig,
        };
        let size = |camera: &Camera| (camera.name.clone(), [camera.width_px, camera.height_px]);
        let image_sizes_px = used.cameras.iter().map(size).collect();
        let options = CalibrationOptions { image_sizes_px, ..self.calibration_options() };
        let whole = self.read_calibration(options.clone());
        Ok((whole.unwrap_or(used), options))
    }

    /// Which axis of the calibration's world points up, if nothing is said of the form of its poses.
    pub(crate) fn up_of_plain_poses(&self) -> Option<UpAxis> {
        (self.manifest.poses == PoseForm::default()).then_some(self.manifest.up)
    }

    fn calibration_options(&self) -> CalibrationOptions {
        CalibrationOptions {
            unit: self.manifest.unit,
            up: self.manifest.up,
            pose_form: self.manifest.poses,
            ..CalibrationOptions::default()
        }
    }

    fn read_calibration(&self, options: CalibrationOptions) -> Result<Rig, RecordingError> {
        let poses = match &self.stand {
            Stand::Found(rig) => return Ok(rig.clone()),
            Stand::Unknown => Poses::Ignored,
            Stand::Calibrated => Poses::Read,
        };
        let options = CalibrationOptions { poses, ..options };
        Ok(layout::read_calibration(&self.calibration_paths(), &options)?)
    }

    /// What is to be known of where the calibration was found.
    pub(super) fn calibration_notes(&self) -> Vec<CalibrationNote> {
        let mut notes = Vec::new();
        for (_, path) in self.calibration_paths() {
            let is_below = path.starts_with(&self.folder);
            if self.manifest.calibration.is_none() && !is_below {
                notes.push(CalibrationNote::Above { path: path.clone() });
            }
            let cameras = calibration::unpaired(&path);
            if !cameras.is_empty() {
                notes.push(CalibrationNote::Unpaired { cameras });
            }
        }
        notes
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
        let names: Vec<String> = self.cameras.iter().map(|(c, _)| c.name.clone()).collect();
        for (camera, _) in &mut self.cameras {
            let alike = name_alike(calibrated, &camera.name);
            if let Some(name) = alike.or_else(|| same_number(calibrated, &names, &camera.name)) {
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

impl<F> CalibratedCameras<F> {
    /// Refuses a folder's cameras of which none is calibrated, and says what to write into `sequence.toml`.
    fn refuse_strangers(&self, calibrated: &Rig, path: &Path) -> Result<(), RecordingError> {
        let is_known = |(camera, _): &(CameraFiles, F)| calibrated.by_name(&camera.name).is_some();
        if self.cameras.is_empty() || self.cameras.iter().any(is_known) {
            return Ok(());
        }
        let quoted = |text: &str| format!("\"{}\"", text.escape_default());
        let known: Vec<&str> = calibrated.names().collect();
        // in the order of both, which is a guess
        let line = |(i, (camera, _)): (usize, &(CameraFiles, F))| {
            let name = known.get(i).copied().unwrap_or("…");
            let video = camera.video.as_ref().map(|path| ("video", path.display().to_string()));
            let images = camera.images.clone().map(|path| ("images", path));
            let masks = camera.masks.clone().map(|path| ("masks", path));
            let (key, file) = masks.or(video).or(images)?;
            Some(format!("{{ name = {}, {key} = {} }}", quoted(name), quoted(&file)))
        };
        let lines: Vec<String> = self.cameras.iter().enumerate().filter_map(line).collect();
        Err(RecordingError::Strangers {
            path: path.into(),
            found: self.cameras.iter().map(|(camera, _)| camera.name.clone()).collect(),
            known: known.into_iter().map(str::to_owned).collect(),
            lines: lines.join(", "),
        })
    }
}

/// The calibrated camera that is called so, or all but so.
pub(super) fn calibrated_name(rig: &Rig, name: &str) -> Option<String> {
    rig.by_name(name).map(|_| name.to_owned()).or_else(|| name_alike(rig, name))
}

/// The only calibrated camera with the same last number (`0` for `cam_0`), if no other of the names has that number.
pub(super) fn same_number(rig: &Rig, names: &[String], name: &str) -> Option<String> {
    let number = |name: &str| {
        let before = name.trim_end_matches(|c: char| !c.is_ascii_digit());
        let digits = before.len() - before.trim_end_matches(|c: char| c.is_ascii_digit()).len();
        before[before.len() - digits..].parse::<u64>().ok()
    };
    let wanted = number(name)?;
    if rig.by_name(name).is_some() || names.iter().filter(|n| number(n) == Some(wanted)).count() > 1
    {
        return None;
    }
    let mut same = rig.names().filter(|other| number(other) == Some(wanted));
    let first = same.next()?;
    same.next().is_none().then(|| first.into())
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::{Camera, Distortion, Intrinsics};
    use crate::math::Rigid3;

    fn rig(names: &[&str]) -> Rig {
        let camera = |name: &&str| Camera {
            name: (*name).into(),
            width_px: 10,
            height_px: 10,
            intrinsics: Intrinsics {
                fx_px: 10.0,
                fy_px: 10.0,
                cx_px: 5.0,
                cy_px: 5.0,
                skew_px: 0.0,
            },
            distortion: Distortion::None,
            camera_from_world: Rigid3::identity(),
        };
        Rig { cameras: names.iter().map(camera).collect() }
    }

    #[test]
    fn a_number_names_a_camera_if_one_camera_and_one_file_have_it() {
        let same = |rig: &Rig, names: &[&str]| {
            let names: Vec<String> = names.iter().map(ToString::to_string).collect();
            names.iter().map(|name| same_number(rig, &names, name)).collect::<Vec<_>>()
        };
        let (zero, one) = (Some("0".to_owned()), Some("1".to_owned()));
        assert_eq!(same(&rig(&["0", "1"]), &["cam_0", "port_1_synced"]), [zero, one.clone()]);
        assert_eq!(same(&rig(&["0", "1"]), &["a0", "b0", "left"]), [None, None, None]);
        assert_eq!(same(&rig(&["a1", "b1"]), &["cam_1"]), [None]);
        assert_eq!(same(&rig(&["1", "01"]), &["1"]), [None], "its own name");
    }
}
