//! `kernels::near_lights` for Python.

use numpy::{IntoPyArray, PyArray3, PyReadonlyArray1, PyReadonlyArray2, PyReadonlyArray3};
use pyo3::prelude::*;

use super::pool::interruptible;
use crate::kernels::near_lights::NearLights;

/// Irradiance of balls, cards and patches at points; see `envlights.placing.placed`.
#[pyfunction]
#[allow(clippy::type_complexity, reason = "arrays of Python")]
pub fn near_irradiance<'py>(
    py: Python<'py>,
    points: PyReadonlyArray2<'py, f64>,
    normals: PyReadonlyArray2<'py, f64>,
    balls: (PyReadonlyArray2<'py, f64>, PyReadonlyArray1<'py, f64>, PyReadonlyArray2<'py, f64>),
    cards: (PyReadonlyArray3<'py, f64>, Vec<bool>, PyReadonlyArray2<'py, f64>),
    patches: (
        PyReadonlyArray2<'py, f64>,
        PyReadonlyArray2<'py, f64>,
        PyReadonlyArray1<'py, f64>,
        PyReadonlyArray2<'py, f64>,
    ),
) -> PyResult<Bound<'py, PyArray3<f64>>> {
    let (points, normals) = (points.as_array(), normals.as_array());
    let balls = (balls.0.as_array(), balls.1.as_array(), balls.2.as_array());
    let (matrices, is_disc, shine) = (cards.0.as_array(), cards.1, cards.2.as_array());
    let (centres, faces) = (patches.0.as_array(), patches.1.as_array());
    let (areas, radiance) = (patches.2.as_array(), patches.3.as_array());
    let out = interruptible(py, || {
        let mut lights = NearLights::new();
        lights.add_balls(balls.0, balls.1, balls.2)?;
        lights.add_cards(matrices, &is_disc, shine)?;
        lights.add_patches(centres, faces, areas, radiance)?;
        lights.irradiance(points, normals)
    })?;
    Ok(out.into_pyarray(py))
}
