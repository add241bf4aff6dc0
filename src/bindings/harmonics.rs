//! `kernels::harmonics` for Python.

use ndarray::{Array1, Array2};
use numpy::{
    IntoPyArray, PyArray1, PyArray2, PyArray3, PyReadonlyArray1, PyReadonlyArray2, PyReadonlyArray3,
};
use pyo3::prelude::*;

use super::pool::{by_size, interruptible};
use super::reduction::ReducedMap;
use super::sphere::registration;
use crate::kernels::disc::Discs;
use crate::kernels::{self, fit, harmonics};

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

/// See `envlights.EnvMap.harmonics`.
#[pyfunction]
pub fn nine_harmonics<'py>(
    py: Python<'py>,
    radiance: PyReadonlyArray3<'py, f32>,
    border_sampled: bool,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let radiance = radiance.as_array();
    let out = interruptible(py, || kernels::nine_harmonics(radiance, registration(border_sampled)))?;
    Ok(out.into_pyarray(py))
}

/// See `envlights.kernels.expand_map`.
#[pyfunction]
pub fn expand_map<'py>(
    py: Python<'py>,
    radiance: PyReadonlyArray3<'py, f32>,
    degree: usize,
    border_sampled: bool,
) -> PyResult<Bound<'py, PyArray3<f64>>> {
    let radiance = radiance.as_array();
    let out = interruptible(py, || kernels::expand_map(radiance, registration(border_sampled), degree))?;
    Ok(out.into_pyarray(py))
}

/// A reduced map as arrays: coefficients of its dull cells, and the integral of the squared radiance that they leave out.
/// Then direction, flux and spread of its bright parts.
type PictureArrays<'py> = (
    Bound<'py, PyArray3<f64>>,
    [f64; 3],
    Bound<'py, PyArray2<f64>>,
    Bound<'py, PyArray2<f64>>,
    Bound<'py, PyArray1<f64>>,
);

/// See `envlights.layers.map_terms`.
#[pyfunction]
pub fn expand_reduced<'py>(py: Python<'py>, reduced: &ReducedMap) -> PyResult<PictureArrays<'py>> {
    let picture = interruptible(py, || Ok(reduced.picture()))?;
    let parts = &picture.patches;
    let direction = Array2::from_shape_fn((parts.len(), 3), |(i, axis)| parts[i].direction[axis]);
    let flux = Array2::from_shape_fn((parts.len(), 3), |(i, c)| parts[i].flux[c]);
    let spread: Array1<f64> = parts.iter().map(|part| part.share).collect();
    let arrays = (direction.into_pyarray(py), flux.into_pyarray(py), spread.into_pyarray(py));
    Ok((picture.rest.to_array().into_pyarray(py), picture.fine, arrays.0, arrays.1, arrays.2))
}

/// See `envlights.kernels.expand_discs`.
#[pyfunction]
pub fn expand_discs<'py>(
    py: Python<'py>,
    directions: PyReadonlyArray2<'py, f64>,
    irradiance: PyReadonlyArray2<'py, f64>,
    radii: PyReadonlyArray1<'py, f64>,
    degree: usize,
) -> PyResult<Bound<'py, PyArray3<f64>>> {
    let (directions, irradiance, radii) = (directions.as_array(), irradiance.as_array(), radii.as_array());
    let out =
        interruptible(py, || kernels::expand_discs(&Discs::new(directions, irradiance, radii)?, degree))?;
    Ok(out.into_pyarray(py))
}

/// See `envlights.compare`: factors of the probe's and of the shadows' kernel, of each degree.
#[pyfunction]
pub fn kernel_spectra(py: Python<'_>, degree: usize) -> PyResult<[Bound<'_, PyArray1<f64>>; 2]> {
    let out = interruptible(py, || Ok(fit::kernel_spectra(degree + 1)))?;
    Ok(out.map(|factors| factors.into_pyarray(py)))
}
