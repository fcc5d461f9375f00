//! The 2-D detections of a recording: which frames have some, and where they put the person's joints.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use nalgebra::Point2;

use super::cameras::{calibrated_name, same_number};
use super::footage::Footage;
use super::layout::numbered_files::{self, Wanted};
use super::layout::visible;
use super::manifest::CameraFiles;
use super::{Recording, RecordingError};
use crate::camera::{Camera, CameraId, Rig};
use crate::io::detections::{self, KeypointSet, NamedPerson, Person};
use crate::silhouette::{FrameIndex, FramePeople, Keypoint};

/// Where they are looked for if the manifest names no place: Pose2Sim's `pose/<camera>_json/`, or `pose/<camera>.csv` and `.json`.
const FOLDER: &str = "pose";
/// Where else FreeMoCap has its array, and what is in its name.
const ARRAY_FOLDERS: [&str; 3] = [FOLDER, "output_data/raw_data", "output_data"];
const ARRAY: &str = "2dData";
const SUFFIX: &str = "_json";
/// Files of a camera that are read to know what they hold.
const SAMPLED_FILES: usize = 12;
/// Points farther outside the picture than this share of its size are of another size of picture.
const OUTSIDE: f64 = 0.2;

/// The detections of every camera.
#[derive(Debug, Clone, Default)]
pub(super) struct DetectionFiles {
    /// By camera of the rig.
    cameras: Vec<BTreeMap<FrameIndex, PathBuf>>,
    /// The people of each frame, of cameras whose pictures are all in one file.
    tables: Vec<Option<BTreeMap<FrameIndex, Vec<NamedPerson>>>>,
    set: Option<KeypointSet>,
    /// How many of the calibration's pixels one of theirs is, if not one.
    scale: Option<f64>,
}

impl Recording {
    /// All people whom other programs see in the frames of the pictures, in undistorted pixels; none without detections.
    ///
    /// # Errors
    /// [`RecordingError`] for the first file that cannot be read or used.
    pub fn people_in(&self, footage: &Footage) -> Result<Vec<FramePeople>, RecordingError> {
        let rig = &footage.rig;
        let files = DetectionFiles::find(self, rig, &self.stated(rig), footage.fps)?;
        let all: BTreeSet<FrameIndex> =
            files.cameras.iter().flat_map(|frames| frames.keys().copied()).collect();
        all.into_iter().map(|frame| files.people(rig, frame)).collect()
    }
}

impl DetectionFiles {
    /// All people of a frame.
    pub(super) fn people(
        &self,
        rig: &Rig,
        frame: FrameIndex,
    ) -> Result<FramePeople, RecordingError> {
        let mut pictures = Vec::new();
        for (id, camera) in rig.iter() {
            let people = self.load((id, camera), frame)?;
            pictures.extend((!people.is_empty()).then_some((id, people)));
        }
        Ok(FramePeople { frame, pictures })
    }

    /// Whether a recording has detections, or its manifest names some.
    pub(super) fn are_promised(recording: &Recording) -> bool {
        let is_named = recording.manifest.cameras.iter().any(|c| c.detections.is_some());
        is_named
            || !folders_of(recording).unwrap_or_default().is_empty()
            || array_of(recording).is_ok_and(|array| array.is_some())
    }

    /// The cameras that have detections.
    pub(super) fn detected(recording: &Recording, rig: &Rig) -> Result<Rig, RecordingError> {
        let found = folders(recording, rig)?;
        let is_found = |camera: &&Camera| found.iter().any(|(name, _)| *name == camera.name);
        let cameras: Vec<Camera> = rig.cameras.iter().filter(is_found).cloned().collect();
        match cameras.as_slice() {
            [] => Err(strangers(recording, rig)?),
            [one] => Err(RecordingError::OneCamera {
                path: recording.path.clone(),
                camera: one.name.clone(),
            }),
            _ => Ok(Rig { cameras }),
        }
    }

    /// Whether there are any.
    pub(super) fn is_empty(&self) -> bool {
        self.cameras.iter().all(BTreeMap::is_empty)
    }

    /// The detections that the manifest names, else those in the folder `pose`; of the cameras of the rig, whose files are shifted as
    /// `cameras` say.
    pub(super) fn find(
        recording: &Recording,
        rig: &Rig,
        cameras: &[CameraFiles],
        fps: f64,
    ) -> Result<Self, RecordingError> {
        let folders = folders(recording, rig)?;
        let count = rig.cameras.len();
        let scale = recording.manifest.detections_scale;
        let mut found = Self {
            cameras: vec![BTreeMap::new(); count],
            tables: vec![None; count],
            set: None,
            scale,
        };
        let mut seen = Vec::new();
        for (camera, pattern) in folders {
            let Some((id, calibrated)) = rig.by_name(&camera) else { continue };
            let shift =
                cameras.iter().find(|c| c.name == camera).map_or(0, |c| c.beginning(fps).whole());
            let frame = |number: u64| {
                Some(FrameIndex(usize::try_from(number.checked_add_signed(shift)?).ok()?))
            };
            let whole = recording.folder.join(&pattern);
            let is_array = detections::is_array(&whole);
            if is_array || detections::is_table(&whole) {
                let table = match is_array {
                    true => detections::read_array(&whole, id.0, count),
                    false => detections::read_table(&whole),
                };
                let table = checked(table, &whole, calibrated, scale)?.into_iter();
                let table: BTreeMap<FrameIndex, Vec<NamedPerson>> =
                    table.filter_map(|(number, people)| Some((frame(number)?, people))).collect();
                found.cameras[id.0] = table.keys().map(|at| (*at, whole.clone())).collect();
                found.tables[id.0] = Some(table);
                continue;
            }

            let wanted =
                Wanted { key: &format!("camera {camera}: detections"), is_kind: is_detection };
            let files = numbered_files::list(&recording.folder, &pattern, &wanted)?;
            if files.of_number.is_empty() {
                let pattern = recording.folder.join(pattern);
                return Err(RecordingError::MissingDetections { pattern, camera });
            }
            seen.extend(sampled(&files.of_number, calibrated, scale)?);
            let numbered = files.of_number.into_iter();
            found.cameras[id.0] =
                numbered.filter_map(|(number, path)| Some((frame(number)?, path))).collect();
        }
        if seen.is_empty() {
            seen = found.first_people()?;
        }
        found.set = set_of(recording, &seen)?;
        Ok(found)
    }

    /// The people of the first picture that shows any.
    fn first_people(&self) -> Result<Vec<Person>, RecordingError> {
        let by_picture = self.cameras.iter().zip(&self.tables).filter(|(_, t)| t.is_none());
        for path in by_picture.flat_map(|(files, _)| files.values()) {
            let people = read(path)?;
            if !people.is_empty() {
                return Ok(people);
            }
        }
        Ok(Vec::new())
    }

    /// Every file, in the order of the rig and the frames.
    pub(super) fn of_cameras(&self) -> &[BTreeMap<FrameIndex, PathBuf>] {
        &self.cameras
    }

    /// The people whom a camera sees in a frame, in undistorted pixels.
    pub(super) fn load(
        &self,
        (id, camera): (CameraId, &Camera),
        frame: FrameIndex,
    ) -> Result<Vec<Vec<Keypoint>>, RecordingError> {
        if let Some(Some(table)) = self.tables.get(id.0) {
            let people = table.get(&frame).map_or(&[][..], Vec::as_slice).iter();
            let people = people.map(|person| self.keypoints(camera, person.iter().copied()));
            return Ok(people.filter(|person| !person.is_empty()).collect());
        }
        let path = self.cameras.get(id.0).and_then(|files| files.get(&frame));
        let (Some(path), Some(set)) = (path, self.set) else {
            return Ok(Vec::new());
        };
        let people = read(path)?;
        let of_set = people.iter().filter(|person| person.len() == set.count);
        let named =
            |person: &Person| self.keypoints(camera, set.points().zip(person.iter().copied()));
        Ok(of_set.map(named).collect())
    }

    /// The points of a person that have a name and were seen, in undistorted pixels.
    fn keypoints(
        &self,
        camera: &Camera,
        person: impl Iterator<Item = (&'static str, [f64; 3])>,
    ) -> Vec<Keypoint> {
        let scale = self.scale.unwrap_or(1.0);
        let seen = |(name, [x, y, confidence]): (&'static str, [f64; 3])| {
            let is_usable = confidence > 0.0 && x.is_finite() && y.is_finite();
            let pixel = is_usable.then(|| camera.undistort(&(Point2::new(x, y) * scale)))??;
            Some(Keypoint { name, pixel, confidence: confidence.min(1.0) })
        };
        person.filter(|(name, _)| !name.is_empty()).filter_map(seen).collect()
    }
}

/// That of the manifest, or the one that the people's points are of.
fn set_of(recording: &Recording, people: &[Person]) -> Result<Option<KeypointSet>, RecordingError> {
    let unknown = |found: String| RecordingError::KeypointSet {
        path: recording.path.clone(),
        found,
        known: KeypointSet::names().collect::<Vec<_>>().join(", "),
    };
    if let Some(name) = &recording.manifest.keypoints {
        let set = KeypointSet::by_name(name).ok_or_else(|| unknown(format!("{name:?}")))?;
        let of_others = people.iter().all(|person| person.len() != set.count);
        return match people.first().filter(|_| of_others) {
            Some(first) => {
                Err(unknown(format!("people of {} points, {name} has {}", first.len(), set.count)))
            }
            None => Ok(Some(set)),
        };
    }
    match people.first() {
        None => Ok(None),
        Some(first) => KeypointSet::of_people(people)
            .map(Some)
            .ok_or_else(|| unknown(format!("people of {} points", first.len()))),
    }
}

/// The name of each camera that has detections, and where they are.
fn folders(recording: &Recording, rig: &Rig) -> Result<Vec<(String, String)>, RecordingError> {
    let named = recording.manifest.cameras.iter();
    let named = named.filter_map(|c| Some((c.name.clone(), c.detections.clone()?)));
    let named: Vec<_> = named.collect();
    if !named.is_empty() {
        return Ok(named);
    }
    let found = folders_of(recording)?;
    if let (true, Some(array)) = (found.is_empty(), array_of(recording)?) {
        return Ok(rig.names().map(|name| (name.to_owned(), array.clone())).collect());
    }
    let names: Vec<String> = found.iter().map(|(name, _)| name.clone()).collect();
    let camera = |(name, folder): (String, String)| {
        let alike = calibrated_name(rig, &name);
        Some((alike.or_else(|| same_number(rig, &names, &name))?, folder))
    };
    Ok(found.into_iter().filter_map(camera).collect())
}

/// The folders and tables of detections of a recording whose manifest names none, each with what it is called after.
fn folders_of(recording: &Recording) -> Result<Vec<(String, String)>, RecordingError> {
    let named = |path: PathBuf| {
        let folder = path.file_name()?.to_string_lossy().into_owned();
        let stem = if path.is_dir() { folder.as_str() } else { path.file_stem()?.to_str()? };
        let name = stem.strip_suffix(SUFFIX).unwrap_or(stem).to_owned();
        (path.is_dir() || detections::is_table(&path)).then(|| (name, format!("{FOLDER}/{folder}")))
    };
    Ok(visible(&recording.folder.join(FOLDER))?.into_iter().filter_map(named).collect())
}

/// FreeMoCap's array of a recording.
fn array_of(recording: &Recording) -> Result<Option<String>, RecordingError> {
    for folder in ARRAY_FOLDERS {
        let files = visible(&recording.folder.join(folder))?.into_iter();
        let arrays = files.filter(|path| detections::is_array(path));
        let names = arrays.filter_map(|path| Some(path.file_name()?.to_str()?.to_owned()));
        let mut named = names.filter(|name| name.contains(ARRAY));
        if let Some(name) = named.next() {
            return Ok(Some(format!("{folder}/{name}")));
        }
    }
    Ok(None)
}

/// Folders of which none is called after a calibrated camera.
fn strangers(recording: &Recording, rig: &Rig) -> Result<RecordingError, RecordingError> {
    let found = folders_of(recording)?;
    let known: Vec<String> = rig.names().map(str::to_owned).collect();
    let line = |(i, (_, folder)): (usize, &(String, String))| {
        let name = known.get(i).map_or("…", String::as_str);
        format!("{{ name = {name:?}, detections = {folder:?} }}")
    };
    let lines: Vec<String> = found.iter().enumerate().map(line).collect();
    Ok(RecordingError::Strangers {
        path: recording.path.clone(),
        found: found.into_iter().map(|(name, _)| name).collect(),
        lines: lines.join(", "),
        known,
    })
}

fn is_detection(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension == "json")
}

fn read(path: &Path) -> Result<Vec<Person>, RecordingError> {
    detections::read(path)
        .map_err(|reason| RecordingError::Detections { path: path.into(), reason })
}

/// The people of some files of a camera, whose pictures must be of the calibrated size.
fn sampled(
    files: &BTreeMap<u64, PathBuf>,
    camera: &Camera,
    scale: Option<f64>,
) -> Result<Vec<Person>, RecordingError> {
    let step = files.len().div_ceil(SAMPLED_FILES).max(1);
    let mut people = Vec::new();
    for path in files.values().step_by(step) {
        people.extend(read(path)?);
    }
    check_size(camera, scale, people.iter().flatten())?;
    Ok(people)
}

/// The people of a camera all of whose pictures are in one file, which was read.
fn checked(
    table: Result<detections::Table, String>,
    path: &Path,
    camera: &Camera,
    scale: Option<f64>,
) -> Result<detections::Table, RecordingError> {
    let table = table.map_err(|reason| RecordingError::Detections { path: path.into(), reason })?;
    let people = table.values().flatten().flatten();
    check_size(camera, scale, people.map(|(_, point)| point))?;
    Ok(table)
}

/// Whether points may be of pictures of the calibrated size.
fn check_size<'a>(
    camera: &Camera,
    scale: Option<f64>,
    points: impl Iterator<Item = &'a [f64; 3]>,
) -> Result<(), RecordingError> {
    let seen = points.filter(|point| point[2] > 0.0);
    let farthest =
        seen.fold([0.0_f64; 2], |far, point| [far[0].max(point[0]), far[1].max(point[1])]);
    let farthest = farthest.map(|x| x * scale.unwrap_or(1.0));
    let size = [camera.width_px, camera.height_px];
    match (0..2).any(|k| farthest[k] > (1.0 + OUTSIDE) * f64::from(size[k])) {
        true => Err(RecordingError::DetectionSize { camera: camera.name.clone(), farthest, size }),
        false => Ok(()),
    }
}
