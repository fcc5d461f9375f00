//! What stands frame by frame as NumPy's arrays, which take the vectors over without a copy.

use numpy::{Element, PyArray1, PyArray2, PyArray3, PyArrayMethods, PyUntypedArrayMethods};
use pyo3::prelude::*;

/// One value a frame, of shape N.
pub(crate) fn of_frames<'py, T: Element>(
    py: Python<'py>,
    values: impl Iterator<Item = T>,
) -> Bound<'py, PyArray1<T>> {
    PyArray1::from_vec(py, values.collect())
}

/// A row a frame, of shape N × `width`; not a number where a row is not known.
pub(crate) fn rows<'py, 'a>(
    py: Python<'py>,
    width: usize,
    rows: impl Iterator<Item = Option<&'a [f64]>>,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let mut values = Vec::new();
    let mut frames = 0;
    for row in rows {
        match row {
            Some(row) => values.extend_from_slice(row),
            None => values.resize(values.len() + width, f64::NAN),
        }
        frames += 1;
    }
    PyArray1::from_vec(py, values).reshape([frames, width])
}

/// Places of some points a frame, of shape N × `points` × 3; not numbers where they are not known.
pub(crate) fn places<'py, 'a>(
    py: Python<'py>,
    points: usize,
    places: impl Iterator<Item = Option<&'a [[f64; 3]]>>,
) -> PyResult<Bound<'py, PyArray3<f64>>> {
    let flat = rows(py, 3 * points, places.map(|frame| frame.map(<[_]>::as_flattened)))?;
    let frames = flat.shape()[0];
    flat.reshape([frames, points, 3])
}
