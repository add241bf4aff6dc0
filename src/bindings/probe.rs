//! `kernels::probe` for Python.

use numpy::{IntoPyArray, PyArray2, PyArray3, PyReadonlyArray1, PyReadonlyArray2, PyReadonlyArray3};
use pyo3::prelude::*;

use super::pool::interruptible;
use super::sphere::registration;
use crate::kernels::disc::Discs;
use crate::kernels::{disc_map as map_of_discs, image, probe};

/// See `envlights.kernels.irradiance`.
#[pyfunction]
pub fn irradiance<'py>(
    py: Python<'py>,
    radiance: PyReadonlyArray3<'py, f32>,
    normals: PyReadonlyArray2<'py, f64>,
    border_sampled: bool,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let (radiance, normals) = (radiance.as_array(), normals.as_array());
    let out = interruptible(py, || probe::irradiance(radiance, registration(border_sampled), normals))?;
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
    source_fraction: f64,
) -> PyResult<(Bound<'py, PyArray2<f64>>, usize)> {
    let (radiance, normals) = (radiance.as_array(), normals.as_array());
    let (out, sources) = interruptible(py, || {
        let map = image::reduce(radiance, registration(border_sampled), columns, source_fraction, false)?;
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
    let out = interruptible(py, || {
        probe::sum_over_sources(normals, directions, radiance, solid_angles, k_d, colour)
    })?;
    Ok(out.into_pyarray(py))
}

/// See `envlights.kernels.disc_map`.
#[pyfunction]
pub fn disc_map<'py>(
    py: Python<'py>,
    height: usize,
    directions: PyReadonlyArray2<'py, f64>,
    irradiance: PyReadonlyArray2<'py, f64>,
    radii: PyReadonlyArray1<'py, f64>,
) -> PyResult<Bound<'py, PyArray3<f64>>> {
    let (directions, irradiance, radii) = (directions.as_array(), irradiance.as_array(), radii.as_array());
    let out = interruptible(py, || map_of_discs::draw(&Discs::new(directions, irradiance, radii)?, height))?;
    Ok(out.into_pyarray(py))
}
