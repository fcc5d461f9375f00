//! A fitted body: in memory, or read from the folder of a fit.

use std::path::Path;

use super::{Error, EventChoice, GaitStudy};
use crate::body::BodyModel;
use crate::gait::{Angle, GaitOptions, Side};
use crate::io::folder::OutFolder;
use crate::io::gait::from_result;
use crate::io::model;
use crate::io::result::ResultFile;

/// A fitted body: its lengths, its motion, and how sure both are.
#[derive(Debug, Clone, PartialEq)]
pub struct FittedRecording {
    /// Everything that the fit found, as `result.json` has it.
    pub result: ResultFile,
    /// The body model.
    pub model: BodyModel,
}

/// A length of the body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Length {
    /// The length at rest, m.
    pub metres: f64,
    /// Its standard deviation, m; `None` without the joint optimum.
    pub sd: Option<f64>,
}

/// An angle of one side, frame by frame from [`AngleTrack::first_frame`] on.
#[derive(Debug, Clone, PartialEq)]
pub struct AngleTrack {
    /// Number of the first frame.
    pub first_frame: usize,
    /// Frames per second.
    pub rate_hz: f64,
    /// The angle, rad; NaN where nobody was seen.
    pub radians: Vec<f64>,
    /// Its standard deviation, rad; `None` where it is not known in any frame.
    pub sd: Option<Vec<f64>>,
}

impl FittedRecording {
    /// Reads the folder of a finished fit; `body` is its model, if it is not a shipped one.
    ///
    /// # Errors
    /// [`Error::Result`] and [`Error::Model`].
    ///
    /// ```no_run
    /// # fn main() -> Result<(), maquette::Error> {
    /// let fit = maquette::FittedRecording::read("out/walker", None)?;
    /// println!("{} frames", fit.result.recording.frames);
    /// # Ok(())
    /// # }
    /// ```
    pub fn read(folder: impl AsRef<Path>, body: Option<&str>) -> Result<Self, Error> {
        let result = ResultFile::read(folder.as_ref())?;
        let model = model::load(body.unwrap_or(&result.body), Path::new(""))?;
        let model = result.body_of(&model)?;
        Ok(Self { result, model })
    }

    /// Whether the fit can be used.
    ///
    /// # Errors
    /// [`Error::Unusable`] has its verdict if not.
    pub fn usable(&self) -> Result<(), Error> {
        self.result.verdict.why_unusable().map_or(Ok(()), |why| Err(Error::Unusable(why)))
    }

    /// A length by its name in the model: `thigh`, `shank`, `upper_arm`, …
    ///
    /// # Errors
    /// [`Error::NoLength`] lists the names there are, [`Error::Unusable`] says why the fit has no lengths.
    pub fn length(&self, name: &str) -> Result<Length, Error> {
        self.usable()?;
        let lengths = &self.result.shape.lengths;
        let found = lengths.iter().find(|length| length.name == name);
        let names = || lengths.iter().map(|length| length.name.as_str());
        let found = found.ok_or_else(|| Error::NoLength {
            name: name.into(),
            body: self.result.body.clone(),
            known: names().collect::<Vec<_>>().join(", "),
        })?;
        Ok(Length { metres: found.length_m, sd: found.sd_m })
    }

    /// An angle of gait analysis by its name (`knee_flexion`, `hip_adduction`, …), as the fit has it, without a filter.
    ///
    /// # Errors
    /// [`Error::NoAngle`] lists the names there are, [`Error::GaitInput`] says what the body lacks, and
    /// [`Error::Unusable`] why the fit has no angles.
    pub fn angle(&self, name: &str, side: Side) -> Result<AngleTrack, Error> {
        let gait = self.gait_with(&GaitOptions { cutoff_hz: 0.0, ..GaitOptions::default() })?;
        gait.angle(name, side)
    }

    /// Analyses the gait, against the shipped norm.
    ///
    /// # Errors
    /// [`Error::GaitInput`] and [`Error::Gait`] say why there is no gait to be analysed.
    pub fn gait(&self) -> Result<GaitStudy, Error> {
        self.gait_with(&GaitOptions::default())
    }

    /// The same with options.
    ///
    /// # Errors
    /// As [`FittedRecording::gait`].
    pub fn gait_with(&self, options: &GaitOptions) -> Result<GaitStudy, Error> {
        self.gait_in(Path::new(""), EventChoice::Detected, options)
    }

    /// The same with the foot strikes and foot offs that a person states, in the folder of the fit or in a file.
    ///
    /// # Errors
    /// As [`FittedRecording::gait`], and [`Error::Events`] names file and event.
    pub fn gait_in(
        &self,
        folder: &Path,
        events: EventChoice<'_>,
        options: &GaitOptions,
    ) -> Result<GaitStudy, Error> {
        let input = from_result(&self.result, self.model.clone(), None)?;
        let events = events.read(folder, &input.movement)?;
        GaitStudy::new(input, Some(self.result.clone()), events.as_deref(), options)
    }

    /// Writes `result.json` and `joints.trc` into a folder, which is made where there is none.
    ///
    /// # Errors
    /// [`Error::Out`] for the file that cannot be written.
    pub fn save(&self, folder: impl AsRef<Path>) -> Result<(), Error> {
        let out = OutFolder::open(folder.as_ref())?;
        for (name, bytes) in self.result.files()? {
            out.write(name, &bytes)?;
        }
        Ok(())
    }
}

impl GaitStudy {
    /// An angle by its name (`knee_flexion`, `hip_adduction`, …), frame by frame.
    ///
    /// # Errors
    /// [`Error::NoAngle`] lists the names there are, [`Error::Unusable`] says why the fit has no angles.
    pub fn angle(&self, name: &str, side: Side) -> Result<AngleTrack, Error> {
        self.usable()?;
        let known = self.analysis.angles.keys().filter(|(s, _)| *s == side);
        let known = || known.clone().map(|(_, angle)| *angle);
        let angle: Angle =
            known().find(|angle| angle.name() == name).ok_or_else(|| Error::NoAngle {
                name: name.into(),
                known: known().map(Angle::name).collect::<Vec<_>>().join(", "),
            })?;

        let movement = &self.input.movement;
        // how sure an angle is that is counted from a standing pose is not known
        let pose = self.analysis.neutral.as_ref();
        let is_counted = pose.is_some_and(|pose| pose.angles.contains_key(&(side, angle)));
        let segments = movement.segments.as_ref().filter(|_| !is_counted);
        Ok(AngleTrack {
            first_frame: movement.first_frame,
            rate_hz: movement.rate_hz,
            radians: self.analysis.angles[&(side, angle)].clone(),
            sd: segments.and_then(|s| s.angle_sd.get(&(side, angle)).cloned()),
        })
    }
}
