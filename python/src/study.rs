//! How a fitted body walks, as Python holds it.

use std::path::PathBuf;

use maquette::GaitStudy;
use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::fault::exception;

/// An angle of one side: the side, the angle, its radians and their standard deviations.
type Track<'py> =
    (&'static str, &'static str, Bound<'py, PyArray1<f64>>, Option<Bound<'py, PyArray1<f64>>>);

/// A gait analysis: its files, and its angles as arrays.
#[pyclass(frozen, module = "maquette._maquette")]
pub(crate) struct Study {
    study: GaitStudy,
}

impl Study {
    pub(crate) fn new(study: GaitStudy) -> Self {
        Self { study }
    }
}

#[pymethods]
impl Study {
    /// `gait.json`, byte by byte.
    fn json<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let bytes = serde_json::to_vec_pretty(&self.study.file());
        let bytes = bytes.map_err(|fault| exception(maquette::Error::from(fault)))?;
        Ok(PyBytes::new(py, &bytes))
    }

    /// Writes `gait.json`, `parameters.csv`, `curves.csv` and `angles.csv` into a folder.
    fn save(&self, py: Python<'_>, folder: PathBuf) -> PyResult<()> {
        py.detach(|| self.study.save(&folder).map_err(exception))
    }

    /// Raises the verdict of a fit that cannot be used.
    fn check_usable(&self) -> PyResult<()> {
        self.study.usable().map_err(exception)
    }

    /// Number of the first frame, and frames per second.
    fn time_base(&self) -> (usize, f64) {
        let movement = &self.study.input.movement;
        (movement.first_frame, movement.rate_hz)
    }

    /// Every angle frame by frame, each of shape N.
    fn tracks<'py>(&self, py: Python<'py>) -> PyResult<Vec<Track<'py>>> {
        let known = self.study.analysis.angles.keys();
        let track = |&(side, angle): &(maquette::gait::Side, maquette::gait::Angle)| {
            let track = self.study.angle(angle.name(), side).map_err(exception)?;
            let array = |values| PyArray1::from_vec(py, values);
            Ok((side.name(), angle.name(), array(track.radians), track.sd.map(array)))
        };
        known.map(track).collect()
    }
}
