//! `kernels::near_lights` for Python.

use numpy::{IntoPyArray, PyArray3, PyReadonlyArray2};
use pyo3::prelude::*;

use super::pool::interruptible;
use crate::kernels::near_lights::{NearLights, irradiance};

/// Irradiance of spheres, cards and patches at points, from rows of numbers; see `envlights.placing.placed_lights`.
#[pyfunction]
pub fn near_irradiance<'py>(
    py: Python<'py>,
    points: PyReadonlyArray2<'py, f64>,
    normals: PyReadonlyArray2<'py, f64>,
    spheres: PyReadonlyArray2<'py, f64>,
    cards: PyReadonlyArray2<'py, f64>,
    patches: PyReadonlyArray2<'py, f64>,
) -> PyResult<Bound<'py, PyArray3<f64>>> {
    let (points, normals) = (points.as_array(), normals.as_array());
    let lights =
        NearLights { spheres: spheres.as_array(), cards: cards.as_array(), patches: patches.as_array() };
    Ok(interruptible(py, || irradiance(lights, points, normals))?.into_pyarray(py))
}
