//! `kernels::sampling` for Python.

use numpy::{IntoPyArray, PyArray1, PyArray2, PyReadonlyArray2};
use pyo3::prelude::*;

use super::pool::{by_size, interruptible};
use crate::kernels::sampling;

/// See `envlights.kernels.radical_inverse`.
#[pyfunction]
pub fn radical_inverse(index: u64, base: u64) -> PyResult<f64> {
    Ok(sampling::radical_inverse(index, base)?)
}

/// See `envlights.kernels.hammersley`.
#[pyfunction]
pub fn hammersley(py: Python<'_>, count: usize) -> PyResult<Bound<'_, PyArray2<f64>>> {
    let out = interruptible(py, || sampling::hammersley(count))?;
    Ok(out.into_pyarray(py))
}

/// See `envlights.kernels.halton`.
#[pyfunction]
pub fn halton(py: Python<'_>, count: usize, bases: Vec<u64>) -> PyResult<Bound<'_, PyArray2<f64>>> {
    let out = interruptible(py, || sampling::halton(count, &bases))?;
    Ok(out.into_pyarray(py))
}

/// See `envlights.kernels.uniform_sphere`.
#[pyfunction]
pub fn uniform_sphere<'py>(
    py: Python<'py>,
    uv: PyReadonlyArray2<'py, f64>,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let uv = uv.as_array();
    let out = interruptible(py, || sampling::uniform_sphere(uv))?;
    Ok(out.into_pyarray(py))
}

/// See `envlights.fit`: even starting directions.
#[pyfunction]
pub fn even_sphere(py: Python<'_>, count: usize) -> PyResult<Bound<'_, PyArray2<f64>>> {
    let out = by_size(py, count, || Ok(sampling::even_sphere(count)))?;
    Ok(out.into_pyarray(py))
}

type Faces<'py> = (Bound<'py, PyArray2<f64>>, Bound<'py, PyArray1<f64>>);

/// See `envlights.kernels.icosphere`.
#[pyfunction]
pub fn icosphere(py: Python<'_>, faces: usize) -> PyResult<Faces<'_>> {
    let (centroids, solid_angles) = by_size(py, faces, || sampling::icosphere(faces))?;
    Ok((centroids.into_pyarray(py), solid_angles.into_pyarray(py)))
}
