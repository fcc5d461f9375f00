//! What a recording lacks, made of its pictures and kept in a folder: masks, contours, points.

use serde_json::{Value, json};

use super::detections::MOST_PEOPLE;
use super::given::Given;
use super::masks::{self, cut_masks};
use super::surface::measure_points;
use super::{DEFAULT_BODY, Error, FitOptions, SilhouetteSource, silhouettes};
use crate::io::folder::OutFolder;
use crate::io::folder::segmented::{self, MaskExtras};
use crate::io::folder::stereo::{self, StereoExtras, StereoFolder};
use crate::io::recording::footage::{Footage, FootageError, FootageNote};
use crate::io::recording::{DerivedFiles, Note, ObservationFiles, Recording, RecordingError};
use crate::pipeline::stereo::{StereoMethod, StereoOptions};
use crate::pipeline::{FitTo, ObservationOptions, Progress, span};
use crate::silhouette::FrameObservations;
use crate::stereo::SideBySide;

/// What is made of a recording's pictures, and where it is kept.
pub(super) struct Derived<'a> {
    /// Masks, contours and points are written here.
    pub(super) out: &'a OutFolder,
    /// Whether what an earlier run has finished there is used again.
    pub(super) is_resumed: bool,
    pub(super) progress: &'a dyn Progress,
}

/// What is said where contours are chosen.
const CONTOURS_CHOSEN: &str = "no masks, cameras side by side, no picture of the empty scene: outlines are found by a body that \
    predicts them (as `maquette silhouettes` does), which takes many times as long as masks; --silhouettes background cuts masks";
/// What is said where masks are chosen.
const MASKS_CHOSEN: &str = "no masks: the person is cut out of the pictures first (as `maquette segment` does), which reads every \
    picture twice or more; masks/<camera>/ spare that";

/// Files to read observations from, and those observations that no file holds.
type Observations = (ObservationFiles, Option<Vec<FrameObservations>>);

impl Derived<'_> {
    /// The masks and points that are fitted to; what is lacking or asked for is made of the pictures.
    pub(super) fn observations(
        &self,
        recording: &Recording,
        options: &FitOptions,
    ) -> Result<Observations, Error> {
        if options.silhouettes == Some(SilhouetteSource::Joint) {
            return self.contours(recording, &recording.footage()?, options);
        }

        // what the recording has
        let given = Given::of(recording, options)?;
        if given.is_enough(options) {
            return Ok((given.0?, None));
        }
        let Given(given) = given;
        let has_masks = given.as_ref().is_ok_and(ObservationFiles::has_masks);

        // what its pictures give
        let footage = match recording.footage() {
            Err(RecordingError::Footage(FootageError::NoPictures { .. }))
                if options.stereo.is_none() =>
            {
                return Ok((given?, None));
            }
            footage => footage?,
        };
        let is_free = options.silhouettes.is_none();
        let has_points = given.as_ref().is_ok_and(ObservationFiles::has_points);
        if is_free && !has_masks && !has_points && is_best_by_contours(&footage) {
            self.progress.note(CONTOURS_CHOSEN);
            return self.contours(recording, &footage, options);
        }
        let mut files = DerivedFiles {
            footage: &footage,
            folder: self.out.path(),
            has_masks: !has_masks,
            has_points: false,
        };
        let mut notes = lines(&footage.notes);
        if files.has_masks {
            if options.silhouettes.is_none() {
                self.progress.note(MASKS_CHOSEN);
            }
            notes.extend(self.cut_masks(recording, &footage, options)?);
        }
        if let Some(method) = options.stereo {
            let masks = recording.with_derived(files)?;
            notes.extend(self.measure_points(&footage, &masks, method, options)?);
            files.has_points = true;
        }
        Ok((noted(recording.with_derived(files)?, notes), None))
    }

    /// Cuts the person out of the pictures of the frames that are fitted, and says what was odd.
    fn cut_masks(
        &self,
        recording: &Recording,
        footage: &Footage,
        options: &FitOptions,
    ) -> Result<Vec<String>, Error> {
        if let Some(notes) = self.kept_notes(segmented::QUALITY, options) {
            return Ok(notes);
        }
        let frames = footage.frames();
        let frames = span(options.frames.select(&frames)?);
        let wanted = options.observations;
        let people = match wanted.fit_to {
            FitTo::Silhouettes => Vec::new(),
            _ => masks::people(recording, footage, wanted.people.most.unwrap_or(MOST_PEOPLE))?,
        };
        let found =
            cut_masks(footage, &people, frames, self.out, MaskExtras::default(), self.progress)?;
        self.keep_notes(segmented::QUALITY, options, found.notes)
    }

    /// Measures points in the pictures of the frames that are fitted, where the masks show the person, and says what was odd.
    fn measure_points(
        &self,
        footage: &Footage,
        masks: &ObservationFiles,
        method: StereoMethod,
        options: &FitOptions,
    ) -> Result<Vec<String>, Error> {
        if let Some(notes) = self.kept_notes(stereo::TABLE, options) {
            return Ok(notes);
        }
        let frames = footage.frames();
        let frames = options.frames.select(&frames)?;
        let settings = StereoOptions { method, ..StereoOptions::default() };
        settings.choose_cameras(&footage.rig)?;

        let folder = StereoFolder::open(self.out, footage.up, StereoExtras::default())?;
        let found = measure_points(footage, Some(masks), frames, &settings, folder, self.progress)?;
        self.keep_notes(stereo::TABLE, options, found.notes)
    }

    /// Finds the contours of the frames that are fitted by a body that predicts them (PF02, §4.3), and points with them.
    ///
    /// The points are those before the still scene and near the body that the pipeline itself fits to, and, where they are
    /// asked for, those that are measured within the contours: surer, but not on a leg of which a camera sees little
    /// behind the other.
    fn contours(
        &self,
        recording: &Recording,
        footage: &Footage,
        options: &FitOptions,
    ) -> Result<Observations, Error> {
        let all = footage.frames();
        let frames = options.frames.select(&all)?;
        let body = options.body.as_deref();
        let body = body.unwrap_or(DEFAULT_BODY);
        let found = silhouettes::observe(footage, frames, body, self.out, self.progress)?;
        let mut notes = lines(&footage.notes);
        notes.extend(found.notes);
        let mut observed = found.observations;

        let mut files =
            DerivedFiles { footage, folder: self.out.path(), has_masks: true, has_points: false };
        if let Some(method) = options.stereo {
            let masks = recording.with_derived(files)?;
            notes.extend(self.measure_points(footage, &masks, method, options)?);
            files.has_points = true;
        }
        let files = recording.with_derived(files)?;
        if options.stereo.is_some() {
            for frame in &mut observed {
                files.load_points(frame)?;
            }
        }
        Ok((noted(files, notes), Some(observed)))
    }

    /// What an earlier run that is continued found odd, if it has finished what it writes this table after, and was told the same.
    fn kept_notes(&self, table: &str, options: &FitOptions) -> Option<Vec<String>> {
        self.is_resumed.then(|| self.out.kept_notes(table, &told(options))).flatten()
    }

    /// Keeps what was odd beside a finished table, and says it at once.
    fn keep_notes(
        &self,
        table: &str,
        options: &FitOptions,
        notes: Vec<String>,
    ) -> Result<Vec<String>, Error> {
        self.out.keep_notes(table, &told(options), &notes)?;
        notes.iter().for_each(|note| self.progress.note(note));
        Ok(notes)
    }
}

/// What masks and points that are made of pictures depend on, besides the pictures.
fn told(options: &FitOptions) -> Value {
    let ObservationOptions { fit_to, people, .. } = options.observations;
    let stereo = options.stereo.map(|method| format!("{method:?}"));
    let frames = options.frames.to_string();
    json!({ "frames": frames, "fit_to": fit_to, "most_people": people.most, "stereo": stereo })
}

fn lines(notes: &[FootageNote]) -> Vec<String> {
    notes.iter().map(ToString::to_string).collect()
}

/// Adds what was odd about the pictures to what is known of the files, each line once.
fn noted(mut files: ObservationFiles, lines: Vec<String>) -> ObservationFiles {
    for line in lines {
        let note = Note::Pictures { line };
        if !files.notes.contains(&note) {
            files.notes.push(note);
        }
    }
    files
}

/// Whether, without masks, contours are the only good way: depth is seen and the empty scene is not.
fn is_best_by_contours(footage: &Footage) -> bool {
    let is_empty_seen = footage.cameras.iter().any(|c| c.background.is_some());
    !is_empty_seen && SideBySide::choose(&footage.rig).is_ok()
}
