//! `kernels::rough_reflection` for Python.

use numpy::{IntoPyArray, PyArray2, PyReadonlyArray2, PyReadonlyArray3};
use pyo3::prelude::*;

use super::pool::interruptible;
use crate::kernels::rough_reflection as kernel;

/// See `envlights.kernels.rough_reflection`.
#[pyfunction]
pub fn rough_reflection<'py>(
    py: Python<'py>,
    radiance: PyReadonlyArray3<'py, f32>,
    normals: PyReadonlyArray2<'py, f64>,
    views: PyReadonlyArray2<'py, f64>,
    roughness: f64,
    specular: f64,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let (radiance, normals, views) = (radiance.as_array(), normals.as_array(), views.as_array());
    let out = interruptible(py, || kernel::rough_reflection(radiance, normals, views, roughness, specular))?;
    Ok(out.into_pyarray(py))
}
