//! `kernels::image` for Python.

use numpy::PyReadonlyArray3;
use pyo3::prelude::*;

use super::pool::in_pool;
use crate::kernels::image;

/// See `envlights.EnvMap`: the numbers of NaN, infinite and negative samples.
#[pyfunction]
pub fn unusable(py: Python<'_>, radiance: PyReadonlyArray3<'_, f32>) -> PyResult<(usize, usize, usize)> {
    let radiance = radiance.as_array();
    let counts = in_pool(py, || image::unusable(radiance))?;
    Ok((counts.nan, counts.infinite, counts.negative))
}
