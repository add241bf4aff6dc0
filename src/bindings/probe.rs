//! `kernels::probe` for Python.

use numpy::{IntoPyArray, PyArray2, PyReadonlyArray1, PyReadonlyArray2, PyReadonlyArray3};
use pyo3::prelude::*;

use super::pool::in_pool;
use super::sphere::registration;
use crate::kernels::{image, probe};

/// See `envlights.kernels.irradiance`.
#[pyfunction]
pub fn irradiance<'py>(
    py: Python<'py>,
    radiance: PyReadonlyArray3<'py, f32>,
    normals: PyReadonlyArray2<'py, f64>,
    border_sampled: bool,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let (radiance, normals) = (radiance.as_array(), normals.as_array());
    let out = in_pool(py, || probe::irradiance(radiance, registration(border_sampled), normals))?;
    Ok(out.into_pyarray(py))
}

/// See `envlights.kernels.working_irradiance`.
#[pyfunction]
pub fn working_irradiance<'py>(
    py: Python<'py>,
    radiance: PyReadonlyArray3<'py, f32>,
    normals: PyReadonlyArray2<'py, f64>,
    border_sampled: bool,
    columns: usize,
    source_share: f64,
) -> PyResult<(Bound<'py, PyArray2<f64>>, usize)> {
    let (radiance, normals) = (radiance.as_array(), normals.as_array());
    let (out, sources) = in_pool(py, || {
        let map = image::reduce(radiance, registration(border_sampled), columns, source_share)?;
        probe::working_irradiance(&map, normals).map(|out| (out, map.sources.dim().0))
    })?;
    Ok((out.into_pyarray(py), sources))
}

/// See `envlights.kernels.sum_over_sources`.
#[pyfunction]
pub fn sum_over_sources<'py>(
    py: Python<'py>,
    normals: PyReadonlyArray2<'py, f64>,
    directions: PyReadonlyArray2<'py, f64>,
    radiance: PyReadonlyArray2<'py, f64>,
    solid_angles: PyReadonlyArray1<'py, f64>,
    k_d: f64,
    colour: [f64; 3],
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let (normals, directions) = (normals.as_array(), directions.as_array());
    let (radiance, solid_angles) = (radiance.as_array(), solid_angles.as_array());
    let out =
        in_pool(py, || probe::sum_over_sources(normals, directions, radiance, solid_angles, k_d, colour))?;
    Ok(out.into_pyarray(py))
}
