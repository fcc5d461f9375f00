//! A fitted body, as Python holds it.

use std::ffi::OsString;
use std::path::PathBuf;

use maquette::FittedRecording;
use maquette::io::result::FramePart;
use maquette::pipeline::FrameSd;
use maquette_cli::call;
use numpy::{PyArray1, PyArray2, PyArray3};
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::arrays::{of_frames, places, rows};
use crate::fault::exception;
use crate::study::Study;
use crate::watch::{Listeners, in_own_pool, unlocked, watched};

/// A fitted body: its files, and its frames as arrays.
#[pyclass(frozen, module = "maquette._maquette")]
pub(crate) struct Fitted {
    fitted: FittedRecording,
}

impl Fitted {
    pub(crate) fn new(fitted: FittedRecording) -> Self {
        Self { fitted }
    }

    fn frames(&self) -> &[FramePart] {
        &self.fitted.result.motion.frames
    }

    fn sds(&self) -> impl Iterator<Item = Option<&FrameSd>> {
        self.frames().iter().map(|frame| frame.sd.as_ref())
    }

    fn angle_count(&self) -> usize {
        self.fitted.result.motion.angles.len()
    }

    fn point_count(&self) -> usize {
        self.fitted.result.motion.points.len()
    }
}

#[pymethods]
impl Fitted {
    /// Reads the folder of a finished fit; `body` is its model, if it is not a shipped one.
    #[staticmethod]
    fn read(py: Python<'_>, folder: PathBuf, body: Option<String>) -> PyResult<Self> {
        let read = || FittedRecording::read(&folder, body.as_deref()).map_err(exception);
        py.detach(read).map(Self::new)
    }

    /// `result.json`, byte by byte.
    fn json<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let files = py.detach(|| self.fitted.result.files());
        let [_, (_, result)] = files.map_err(|fault| exception(maquette::Error::from(fault)))?;
        Ok(PyBytes::new(py, &result))
    }

    /// Writes `result.json` and `joints.trc` into a folder.
    fn save(&self, py: Python<'_>, folder: PathBuf) -> PyResult<()> {
        py.detach(|| self.fitted.save(&folder).map_err(exception))
    }

    /// Raises the verdict of a fit that cannot be used.
    fn check_usable(&self) -> PyResult<()> {
        self.fitted.usable().map_err(exception)
    }

    /// What `maquette gait` with these words finds.
    fn gait(&self, py: Python<'_>, words: Vec<OsString>) -> PyResult<Study> {
        unlocked(py, || call::gait(&self.fitted, &words)).map(Study::new)
    }

    /// The page that `maquette report` with these words writes.
    fn report(
        &self,
        py: Python<'_>,
        words: Vec<OsString>,
        listeners: Listeners,
    ) -> PyResult<String> {
        watched(py, &listeners, |progress| {
            in_own_pool(|| call::report(&self.fitted, &words, progress))
        })
    }

    /// A page that shows the body as it moves.
    fn viewer(&self, py: Python<'_>) -> PyResult<String> {
        unlocked(py, || Ok(self.fitted.viewer()?))
    }

    /// Writes what `maquette export` with these words writes, into the folder itself, and says where.
    fn export(&self, py: Python<'_>, words: Vec<OsString>) -> PyResult<Vec<PathBuf>> {
        unlocked(py, || call::export(&self.fitted, &words))
    }

    /// Numbers of the frames, of shape N.
    fn frame_numbers<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<i64>> {
        of_frames(py, self.frames().iter().map(|frame| frame.frame as i64))
    }

    /// Their times in seconds, of shape N.
    fn times_s<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        of_frames(py, self.frames().iter().map(|frame| frame.time_s))
    }

    /// How many cameras see the person in each, of shape N.
    fn views<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<i64>> {
        of_frames(py, self.frames().iter().map(|frame| frame.views as i64))
    }

    /// The joints' angles in radians, of shape N × A.
    fn angles_rad<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let angles = self.frames().iter().map(|frame| Some(frame.angles_rad.as_slice()));
        rows(py, self.angle_count(), angles)
    }

    /// Their standard deviations in radians, of shape N × A.
    fn angles_sd_rad<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let sds = self.sds().map(|sd| sd.map(|sd| sd.angles_rad.as_slice()));
        rows(py, self.angle_count(), sds)
    }

    /// The points' places in metres, of shape N × P × 3.
    fn points_m<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray3<f64>>> {
        let points = self.frames().iter().map(|frame| Some(frame.points_m.as_slice()));
        places(py, self.point_count(), points)
    }

    /// Their standard deviations in metres, of shape N × P × 3.
    fn points_sd_m<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray3<f64>>> {
        let sds = self.sds().map(|sd| sd.map(|sd| sd.points_m.as_slice()));
        places(py, self.point_count(), sds)
    }
}
