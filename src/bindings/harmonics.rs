//! `kernels::harmonics` for Python.

use numpy::{IntoPyArray, PyArray2, PyReadonlyArray2};
use pyo3::prelude::*;

use super::pool::by_size;
use crate::kernels::harmonics;

/// See `envlights.kernels.harmonic_radiance`.
#[pyfunction]
pub fn harmonic_radiance<'py>(
    py: Python<'py>,
    directions: PyReadonlyArray2<'py, f64>,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let directions = directions.as_array();
    let out = by_size(py, directions.len(), || harmonics::harmonic_radiance(directions))?;
    Ok(out.into_pyarray(py))
}

/// See `envlights.kernels.harmonic_irradiance`.
#[pyfunction]
pub fn harmonic_irradiance<'py>(
    py: Python<'py>,
    normals: PyReadonlyArray2<'py, f64>,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let normals = normals.as_array();
    let out = by_size(py, normals.len(), || harmonics::harmonic_irradiance(normals))?;
    Ok(out.into_pyarray(py))
}
