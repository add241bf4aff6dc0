//! `kernels::fill` for Python.

use numpy::{PyArray3, PyReadonlyArray2, PyReadonlyArray3};
use pyo3::prelude::*;

use super::output::fill;
use super::sphere::registration;
use crate::kernels::fill as kernel;

/// See `envlights.EnvMap.filled`.
#[pyfunction]
pub fn fill_unseen<'py>(
    py: Python<'py>,
    radiance: PyReadonlyArray3<'py, f32>,
    seen: PyReadonlyArray2<'py, f32>,
    border_sampled: bool,
    columns: usize,
    most: f32,
) -> PyResult<Bound<'py, PyArray3<f32>>> {
    let (radiance, seen, registration) = (radiance.as_array(), seen.as_array(), registration(border_sampled));
    let (filled, ()) = fill(py, radiance.dim().into(), |filled| {
        kernel::fill_unseen(radiance, seen, registration, columns, most, filled)
    })?;
    Ok(filled)
}
