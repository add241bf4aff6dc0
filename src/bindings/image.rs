//! `kernels::image` for Python.

use numpy::PyReadonlyArray3;
use pyo3::prelude::*;

use super::pool::in_pool;
use crate::kernels::image;

/// See `envlights.EnvMap`: how many samples are NaN, infinite and negative.
#[pyfunction]
pub fn unusable(py: Python<'_>, radiance: PyReadonlyArray3<'_, f32>) -> PyResult<(usize, usize, usize)> {
    let radiance = radiance.as_array();
    let seen = in_pool(py, || image::unusable(radiance))?;
    Ok((seen.nan, seen.infinite, seen.negative))
}
