//! `kernels::repair` for Python.

use numpy::{IntoPyArray, PyArray2, PyReadonlyArray3};
use pyo3::prelude::*;

use super::pool::{in_pool, interruptible};
use super::sphere::registration;
use crate::kernels::repair::{clipped_fraction as share, missing_light};

/// See `envlights.EnvMap.clipped_fraction`: clipped fractions of the sphere and of the flux.
#[pyfunction]
pub fn clipped_fraction(
    py: Python<'_>,
    radiance: PyReadonlyArray3<'_, f32>,
    border_sampled: bool,
    white: Option<f32>,
) -> PyResult<(f64, f64)> {
    let radiance = radiance.as_array();
    let share = in_pool(py, || share::clipped_fraction(radiance, registration(border_sampled), white))?;
    Ok((share.sphere, share.flux))
}

/// Density of the light that was cut off, for each pixel; see `envlights.repair`.
#[pyfunction]
pub fn clipped_light_shares<'py>(
    py: Python<'py>,
    radiance: PyReadonlyArray3<'py, f32>,
    border_sampled: bool,
    white: f64,
    working_columns: usize,
    gap: f64,
) -> PyResult<Bound<'py, PyArray2<f32>>> {
    let radiance = radiance.as_array();
    let registration = registration(border_sampled);
    let shares =
        interruptible(py, || missing_light::shares(radiance, registration, white, working_columns, gap))?;
    Ok(shares.into_pyarray(py))
}

/// Depth of the clipped regions in radians, as a working image; see `envlights.plot.plateau_picture`.
#[pyfunction]
pub fn clipped_depth<'py>(
    py: Python<'py>,
    radiance: PyReadonlyArray3<'py, f32>,
    border_sampled: bool,
    white: f64,
    working_columns: usize,
    gap: f64,
) -> PyResult<Bound<'py, PyArray2<f32>>> {
    let radiance = radiance.as_array();
    let registration = registration(border_sampled);
    let depth = interruptible(py, || {
        missing_light::clipped_depth(radiance, registration, white, working_columns, gap)
    })?;
    Ok(depth.into_pyarray(py))
}
