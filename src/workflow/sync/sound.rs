//! What the sound of videos says of their clocks: a check from another source.

use super::{SoundCheck, SyncedRecording};
use crate::camera::Rig;
use crate::io::recording::footage::{Loudness, Source};
use crate::io::recording::{Recording, RecordingError};
use crate::pipeline::{Progress, sound_delay_s};
use crate::workflow::Error;

/// Metres that sound travels in a second, at 20 °C.
const SOUND_M_S: f64 = 343.0;
/// The sound of a video begins within one of its steps.
const SOUND_STEP_S: f64 = 0.001;
/// Delays of sound that are looked for, seconds.
const MOST_DELAY_S: f64 = 60.0;
/// What differs by more standard deviations does not agree.
const SURE: f64 = 3.0;

impl SyncedRecording {
    /// Compares the sound of the videos, if there is any.
    pub(super) fn listen(
        &mut self,
        recording: &Recording,
        progress: &dyn Progress,
    ) -> Result<(), Error> {
        // masks alone make no sound
        let Ok(footage) = recording.footage() else {
            return Ok(());
        };
        progress.begin("sound", footage.cameras.len());
        let mut heard: Vec<(String, Loudness)> = Vec::new();
        for (name, camera) in footage.rig.names().zip(&footage.cameras) {
            if let Source::Video { path, .. } = &camera.source
                && let Some(loudness) = Loudness::of(path).map_err(RecordingError::from)?
            {
                heard.push((name.into(), loudness));
            }
            progress.step();
        }
        progress.end();
        let Some(((against, first), others)) = heard.split_first() else {
            return Ok(());
        };
        for (name, loudness) in others {
            self.compare((against, first), (name, loudness), &footage.rig);
        }
        Ok(())
    }

    fn compare(
        &mut self,
        (against, a): (&String, &Loudness),
        (name, b): (&String, &Loudness),
        rig: &Rig,
    ) {
        let Some(delay_s) = sound_delay_s(&a.energy, &b.energy, MOST_DELAY_S) else {
            self.notes.push(format!(
                "camera {name}: its sound tells nothing against {against}'s: no delay is distinct"
            ));
            return;
        };
        // what is heard later in a video began earlier
        let after_frames = -(delay_s + b.start_s - a.start_s) * self.fps;
        let centre = |name: &str| rig.by_name(name).map(|(_, camera)| camera.centre_world());
        let apart_m = centre(name).zip(centre(against)).map_or(0.0, |(a, b)| (a - b).norm());
        // from wherever it comes, it is later in one of them by no more than the way between them
        let travel_s = apart_m / SOUND_M_S / 3.0_f64.sqrt();
        let sd_frames = travel_s.hypot(SOUND_STEP_S) * self.fps;

        let of = |name: &str| self.cameras.iter().find(|camera| camera.camera == name);
        let began = |name: &str| {
            let camera = of(name)?;
            let was = (camera.was_frames, 0.0);
            Some(camera.found.map_or(was, |found| (found.offset_frames, found.sd_frames)))
        };
        let Some((own, other)) = began(name).zip(began(against)) else {
            return;
        };
        let difference = own.0 - other.0 - after_frames;
        let check = SoundCheck {
            against: against.clone(),
            after_frames,
            sd_frames,
            agrees: difference.abs() <= SURE * own.1.hypot(other.1).hypot(sd_frames),
        };
        let camera = self.cameras.iter_mut().find(|camera| camera.camera == *name);
        camera.into_iter().for_each(|camera| camera.sound = Some(check.clone()));
    }
}
