//! `kernels::detect::loghin` for Python.

use numpy::ndarray::{Array1, Array2};
use numpy::{IntoPyArray, PyArray1, PyArray2, PyReadonlyArray1, PyReadonlyArray2, PyReadonlyArray3};
use pyo3::prelude::*;

use super::pool::{by_size, interruptible, without_gil};
use crate::kernels::detect::loghin::bresenham::{self, LineRule};
use crate::kernels::detect::loghin::{
    blur as smoothing, map_luminance, means, merge_samples, neighbours, resize, suppress as suppression,
    uv_pixels, window_clipping,
};
use crate::kernels::detect::plane_threshold as of_plane;

/// See `envlights.kernels.luminance`.
#[pyfunction]
pub fn luminance<'py>(
    py: Python<'py>,
    radiance: PyReadonlyArray3<'py, f32>,
) -> PyResult<Bound<'py, PyArray2<f32>>> {
    let radiance = radiance.as_array();
    let out = interruptible(py, || map_luminance::luminance(radiance))?;
    Ok(out.into_pyarray(py))
}

/// See `envlights.kernels.resize_bilinear`.
#[pyfunction]
pub fn resize_bilinear<'py>(
    py: Python<'py>,
    image: PyReadonlyArray2<'py, f32>,
    height: usize,
    width: usize,
    wrap: bool,
) -> PyResult<Bound<'py, PyArray2<f32>>> {
    let view = image.as_array();
    let out = interruptible(py, || resize::resize_bilinear(view, height, width, wrap))?;
    Ok(out.into_pyarray(py))
}

/// See `envlights.kernels.blur`.
#[pyfunction]
pub fn blur<'py>(
    py: Python<'py>,
    image: PyReadonlyArray2<'py, f32>,
    sigma: f64,
    wrap: bool,
) -> PyResult<Bound<'py, PyArray2<f32>>> {
    let view = image.as_array();
    let out = interruptible(py, || smoothing::blur(view, sigma, wrap))?;
    Ok(out.into_pyarray(py))
}

/// Threshold of a plane luminance image; see `envlights.detect_photograph`.
#[pyfunction]
pub fn plane_threshold(py: Python<'_>, luminance: PyReadonlyArray2<'_, f32>) -> PyResult<f64> {
    let view = luminance.as_array();
    interruptible(py, || of_plane::plane_threshold(view))
}

/// See `envlights.kernels.uv_to_pixel`.
#[pyfunction]
pub fn uv_to_pixel<'py>(
    py: Python<'py>,
    uv: PyReadonlyArray2<'py, f64>,
    height: usize,
    width: usize,
) -> PyResult<Bound<'py, PyArray2<i64>>> {
    let uv = uv.as_array();
    let out = by_size(py, uv.len(), || uv_pixels::uv_to_pixel(uv, height, width))?;
    Ok(out.into_pyarray(py))
}

/// Luminance, and row and column, of each sample's brightest neighbour.
type Neighbours<'py> = (Bound<'py, PyArray1<f32>>, Bound<'py, PyArray2<i64>>);

/// See `envlights.kernels.neighbour_maximum`.
#[pyfunction]
pub fn neighbour_maximum<'py>(
    py: Python<'py>,
    luminance: PyReadonlyArray2<'py, f32>,
    pixels: PyReadonlyArray2<'py, i64>,
    reach: usize,
    sphere: bool,
) -> PyResult<Neighbours<'py>> {
    let (luminance, pixels) = (luminance.as_array(), pixels.as_array());
    let found = interruptible(py, || neighbours::neighbour_maximum(luminance, pixels, reach, sphere))?;
    let values: Array1<f32> = found.iter().map(|(value, _)| *value).collect();
    let places: Vec<[i64; 2]> = found.iter().map(|(_, pixel)| pixel.map(|i| i as i64)).collect();
    Ok((values.into_pyarray(py), Array2::from(places).into_pyarray(py)))
}

/// See `envlights.DetectedLights.is_clipped`.
#[pyfunction]
pub fn are_clipped<'py>(
    py: Python<'py>,
    radiance: PyReadonlyArray3<'py, f32>,
    pixels: PyReadonlyArray2<'py, i64>,
    reach: usize,
    sphere: bool,
    clip_level: Option<f32>,
) -> PyResult<Bound<'py, PyArray1<bool>>> {
    let (radiance, pixels) = (radiance.as_array(), pixels.as_array());
    let out =
        interruptible(py, || window_clipping::are_clipped(radiance, pixels, reach, sphere, clip_level))?;
    Ok(out.into_pyarray(py))
}

/// See `envlights.kernels.suppress`.
#[pyfunction]
pub fn suppress<'py>(
    py: Python<'py>,
    points: PyReadonlyArray2<'py, f64>,
    distance: f64,
) -> PyResult<Bound<'py, PyArray1<i64>>> {
    let points = points.as_array();
    let out = interruptible(py, || suppression::suppress(points, distance))?;
    Ok(indices(py, &out))
}

/// See `envlights.kernels.bresenham_line`.
#[pyfunction]
pub fn bresenham_line(py: Python<'_>, start: [i64; 2], end: [i64; 2]) -> PyResult<Bound<'_, PyArray2<i64>>> {
    let pixels = without_gil(py, || bresenham::line(start, end))?;
    Ok(Array2::from(pixels).into_pyarray(py))
}

/// Options of `merge_along_lines`.
#[derive(FromPyObject)]
pub struct LineOptions {
    farthest: f64,
    tolerance: f32,
    ceiling: f32,
    bright: f32,
    sphere: bool,
}

/// See `envlights.kernels.merge_along_lines`.
#[pyfunction]
pub fn merge_along_lines<'py>(
    py: Python<'py>,
    luminance: PyReadonlyArray2<'py, f32>,
    pixels: PyReadonlyArray2<'py, i64>,
    points: PyReadonlyArray2<'py, f64>,
    rule: LineOptions,
) -> PyResult<Bound<'py, PyArray1<i64>>> {
    let (luminance, pixels, points) = (luminance.as_array(), pixels.as_array(), points.as_array());
    let LineOptions { farthest, tolerance, ceiling, bright, sphere } = rule;
    let rule = LineRule { farthest, tolerance, ceiling, bright, sphere };
    let out = interruptible(py, || merge_samples::merge(luminance, pixels, points, &rule))?;
    Ok(indices(py, &out))
}

/// See `envlights.kernels.weighted_means`.
#[pyfunction]
pub fn weighted_means<'py>(
    py: Python<'py>,
    points: PyReadonlyArray2<'py, f64>,
    weights: PyReadonlyArray1<'py, f64>,
    light: PyReadonlyArray1<'py, i64>,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let (points, weights, light) = (points.as_array(), weights.as_array(), light.as_array());
    let out = by_size(py, points.len(), || means::weighted_means(points, weights, light))?;
    Ok(out.into_pyarray(py))
}

fn indices<'py>(py: Python<'py>, values: &[usize]) -> Bound<'py, PyArray1<i64>> {
    values.iter().map(|&i| i as i64).collect::<Array1<i64>>().into_pyarray(py)
}
