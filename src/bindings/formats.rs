//! `formats` for Python.

use numpy::PyReadonlyArray3;
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use super::pool::interruptible;
use crate::formats::radiance::write;

/// See `envlights.io.image_output`: bytes of some rows of a Radiance picture.
#[pyfunction]
pub fn radiance_rows<'py>(
    py: Python<'py>,
    radiance: PyReadonlyArray3<'py, f32>,
) -> PyResult<Bound<'py, PyBytes>> {
    let radiance = radiance.as_array();
    let bytes = interruptible(py, || Ok(write::encode(radiance)))?;
    Ok(PyBytes::new(py, &bytes))
}
