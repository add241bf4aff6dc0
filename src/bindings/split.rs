//! `kernels::split` for Python.

use std::sync::{Mutex, PoisonError};

use numpy::ndarray::{Array1, Array2, Array3};
use numpy::{
    IntoPyArray, PyArray1, PyArray2, PyArray3, PyReadonlyArray1, PyReadonlyArray2, PyReadonlyArray3,
    PyReadwriteArray3,
};
use pyo3::prelude::*;

use super::pool::interruptible;
use super::sphere::registration;
use crate::kernels::split::{self, Found, Taken};

/// What is left of a map without some lights, and what each of them was; see `envlights.split`.
#[pyclass(frozen, get_all)]
pub struct MapSplit {
    direction: Py<PyArray2<f64>>,
    irradiance: Py<PyArray2<f64>>,
    flux: Py<PyArray1<f64>>,
    solid_angle: Py<PyArray1<f64>>,
    reach: Py<PyArray1<f64>>,
    vectors: Py<PyArray3<f64>>,
}

/// See `envlights.split`.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "what was found is one struct on the other side")]
pub fn split_map(
    py: Python<'_>,
    radiance: PyReadonlyArray3<'_, f32>,
    pixel: PyReadonlyArray2<'_, i64>,
    light_of_pixel: PyReadonlyArray1<'_, i64>,
    direction: PyReadonlyArray2<'_, f64>,
    block: usize,
    threshold: f64,
    end: Option<f64>,
    luminance: Option<PyReadonlyArray1<'_, f32>>,
    border_sampled: bool,
    mut rest: PyReadwriteArray3<'_, f32>,
) -> PyResult<MapSplit> {
    let radiance = radiance.as_array();
    let rest = Mutex::new(rest.as_array_mut());
    let mut found = found(&pixel, &light_of_pixel, &direction, block, threshold, end);
    found.luminance = luminance.as_ref().map(PyReadonlyArray1::as_slice).transpose()?;
    // Work that was interrupted may run again, and writes the same again.
    let lights = interruptible(py, || {
        let mut rest = rest.lock().unwrap_or_else(PoisonError::into_inner);
        split::split(radiance, registration(border_sampled), &found, rest.view_mut())
    })?;
    let numbers =
        |of: fn(&Taken) -> f64| lights.iter().map(of).collect::<Array1<f64>>().into_pyarray(py).unbind();
    let vectors = |of: fn(&Taken) -> [f64; 3]| {
        let rows: Vec<[f64; 3]> = lights.iter().map(of).collect();
        Array2::from(rows).into_pyarray(py).unbind()
    };
    Ok(MapSplit {
        direction: vectors(|light| light.direction.to_array()),
        irradiance: vectors(|light| light.irradiance.to_array()),
        flux: numbers(|light| light.flux),
        solid_angle: numbers(|light| light.solid_angle),
        reach: numbers(|light| light.reach),
        vectors: Array3::from(
            lights.iter().map(|light| light.vectors.to_cols_array_2d()).collect::<Vec<_>>(),
        )
        .into_pyarray(py)
        .unbind(),
    })
}

/// See `envlights.split`.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "what was found is one struct on the other side")]
pub fn peaks_of_lights<'py>(
    py: Python<'py>,
    radiance: PyReadonlyArray3<'py, f32>,
    pixel: PyReadonlyArray2<'py, i64>,
    light_of_pixel: PyReadonlyArray1<'py, i64>,
    direction: PyReadonlyArray2<'py, f64>,
    block: usize,
    threshold: f64,
    end: Option<f64>,
) -> PyResult<Bound<'py, PyArray1<f32>>> {
    let radiance = radiance.as_array();
    let found = found(&pixel, &light_of_pixel, &direction, block, threshold, end);
    Ok(interruptible(py, || found.peaks(radiance))?.into_pyarray(py))
}

/// What was found in a map.
fn found<'a>(
    pixel: &'a PyReadonlyArray2<'_, i64>,
    light_of_pixel: &'a PyReadonlyArray1<'_, i64>,
    direction: &'a PyReadonlyArray2<'_, f64>,
    block: usize,
    threshold: f64,
    end: Option<f64>,
) -> Found<'a> {
    let (pixels, light_of_pixel) = (pixel.as_array(), light_of_pixel.as_array());
    Found { pixels, light_of_pixel, directions: direction.as_array(), block, threshold, end, luminance: None }
}
