//! `kernels::split` for Python.

use numpy::ndarray::{Array1, Array2, Array3};
use numpy::{
    IntoPyArray, PyArray1, PyArray2, PyArray3, PyReadonlyArray1, PyReadonlyArray2, PyReadonlyArray3,
};
use pyo3::prelude::*;

use super::output::fill;
use super::sphere::registration;
use crate::kernels::split::{self, RemovedLight};

/// Remainder of a map, and the lights that were removed; see `envlights.split`.
#[pyclass(frozen, get_all)]
pub struct MapSplit {
    remainder: Py<PyArray3<f32>>,
    map_flux: f64,
    direction: Py<PyArray2<f64>>,
    irradiance: Py<PyArray2<f64>>,
    flux: Py<PyArray2<f64>>,
    solid_angle: Py<PyArray1<f64>>,
    reach: Py<PyArray1<f64>>,
    vectors: Py<PyArray3<f64>>,
    light_of_block: Py<PyArray1<u32>>,
}

/// Pixels of detected lights: the named tuple of the same name in `envlights.splitting.split`.
#[derive(FromPyObject)]
pub struct LightPixels<'py> {
    pixel: PyReadonlyArray2<'py, i64>,
    light_of_pixel: PyReadonlyArray1<'py, i64>,
    direction: PyReadonlyArray2<'py, f64>,
    block: usize,
    threshold: f64,
    luminance: PyReadonlyArray1<'py, f32>,
}

impl LightPixels<'_> {
    fn views(&self) -> PyResult<split::LightPixels<'_>> {
        Ok(split::LightPixels {
            pixels: self.pixel.as_array(),
            light_of_pixel: self.light_of_pixel.as_array(),
            directions: self.direction.as_array(),
            block: self.block,
            threshold: self.threshold,
            luminance: self.luminance.as_slice()?,
        })
    }
}

/// See `envlights.split`.
#[pyfunction]
pub fn split_map(
    py: Python<'_>,
    radiance: PyReadonlyArray3<'_, f32>,
    border_sampled: bool,
    lights: LightPixels<'_>,
    seen: Option<PyReadonlyArray2<'_, f32>>,
) -> PyResult<MapSplit> {
    let (radiance, lights) = (radiance.as_array(), lights.views()?);
    let seen = seen.as_ref().map(PyReadonlyArray2::as_slice).transpose()?;
    let (rest, parts) = fill(py, radiance.dim().into(), |rest| {
        split::split(radiance, registration(border_sampled), &lights, seen, rest)
    })?;
    let numbers = |of: fn(&RemovedLight) -> f64| {
        parts.lights.iter().map(of).collect::<Array1<f64>>().into_pyarray(py).unbind()
    };
    let vectors = |of: fn(&RemovedLight) -> [f64; 3]| {
        Array2::from(parts.lights.iter().map(of).collect::<Vec<_>>()).into_pyarray(py).unbind()
    };
    let columns: Vec<_> = parts.lights.iter().map(|light| light.vectors.to_cols_array_2d()).collect();
    Ok(MapSplit {
        direction: vectors(|light| light.direction.to_array()),
        irradiance: vectors(|light| light.irradiance.to_array()),
        flux: vectors(|light| light.flux.to_array()),
        solid_angle: numbers(|light| light.solid_angle),
        reach: numbers(|light| light.reach),
        vectors: Array3::from(columns).into_pyarray(py).unbind(),
        map_flux: parts.map_flux,
        light_of_block: parts.light_of_block.into_pyarray(py).unbind(),
        remainder: rest.unbind(),
    })
}
