//! `kernels::sphere` for Python.

use numpy::{IntoPyArray, PyArray2, PyArray3, PyReadonlyArray2};
use pyo3::prelude::*;

use super::pool::by_size;
use crate::kernels::sphere::{self, Registration};

/// Registration of a map from the flag of Python.
pub fn registration(border_sampled: bool) -> Registration {
    if border_sampled { Registration::BorderSampled } else { Registration::CellCentred }
}

/// See `envlights.kernels.uv_to_direction`.
#[pyfunction]
pub fn uv_to_direction<'py>(
    py: Python<'py>,
    uv: PyReadonlyArray2<'py, f64>,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let uv = uv.as_array();
    let out = by_size(py, uv.len(), || sphere::uv_to_direction(uv))?;
    Ok(out.into_pyarray(py))
}

/// See `envlights.kernels.direction_to_uv`.
#[pyfunction]
pub fn direction_to_uv<'py>(
    py: Python<'py>,
    direction: PyReadonlyArray2<'py, f64>,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let direction = direction.as_array();
    let out = by_size(py, direction.len(), || sphere::direction_to_uv(direction))?;
    Ok(out.into_pyarray(py))
}

/// See `envlights.kernels.pixel_directions`; only rows from `top` to before `bottom`.
#[pyfunction]
pub fn pixel_directions(
    py: Python<'_>,
    height: usize,
    width: usize,
    border_sampled: bool,
    top: usize,
    bottom: usize,
) -> PyResult<Bound<'_, PyArray3<f64>>> {
    let pixels = bottom.saturating_sub(top).saturating_mul(width);
    let out = by_size(py, pixels, || {
        sphere::row_directions(height, width, registration(border_sampled), top..bottom)
    })?;
    Ok(out.into_pyarray(py))
}

/// See `envlights.kernels.pixel_solid_angles`.
#[pyfunction]
pub fn pixel_solid_angles(
    py: Python<'_>,
    height: usize,
    width: usize,
    border_sampled: bool,
) -> PyResult<Bound<'_, PyArray2<f64>>> {
    let pixels = height.saturating_mul(width);
    let out =
        by_size(py, pixels, || sphere::pixel_solid_angles(height, width, registration(border_sampled)))?;
    Ok(out.into_pyarray(py))
}
