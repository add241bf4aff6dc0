//! `kernels::detect` for Python.

use numpy::ndarray::{Array1, Array2};
use numpy::{IntoPyArray, PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray2, PyReadonlyArray3};
use pyo3::prelude::*;

use super::pool::{in_pool, interruptible};
use super::sphere::registration;
use crate::kernels::detect::clipped::{ClipLevel, ClippedLights};
use crate::kernels::detect::segment::bars::BARS;
use crate::kernels::detect::segment::light_moments::LightMoments;
use crate::kernels::detect::segment::run::{Run, runs};
use crate::kernels::detect::segment::working_image::WorkingImage;
use crate::kernels::detect::{self, Detection, DetectionOptions};

/// Options of `detect_tree`: the named tuple of `envlights.detection.detect`.
#[derive(FromPyObject)]
pub struct TreeOptions {
    working_columns: usize,
    threshold: Option<f64>,
    rise: f64,
    prominence: f64,
    extent: f64,
    gap: f64,
    min_flux_fraction: f64,
    min_worth: f64,
    max_lights: usize,
    clip_level: Option<f64>,
}

impl From<TreeOptions> for DetectionOptions {
    fn from(options: TreeOptions) -> Self {
        let TreeOptions { working_columns, threshold, rise, prominence, extent, gap, .. } = options;
        let TreeOptions { min_flux_fraction, min_worth, max_lights, clip_level, .. } = options;
        Self {
            working_columns,
            threshold,
            rise,
            prominence,
            extent,
            gap,
            min_flux_fraction,
            min_worth,
            max_lights,
            clip_level,
        }
    }
}

/// Lights of `detect_tree`, and the numbers of its report; see `envlights.detect`.
#[pyclass(frozen, get_all)]
pub struct TreeDetection {
    direction: Py<PyArray2<f64>>,
    irradiance: Py<PyArray2<f64>>,
    flux: Py<PyArray2<f64>>,
    peak_direction: Py<PyArray2<f64>>,
    orientation: Py<PyArray2<f64>>,
    solid_angle: Py<PyArray1<f64>>,
    elongation: Py<PyArray1<f64>>,
    peak_luminance: Py<PyArray1<f64>>,
    flux_fraction: Py<PyArray1<f64>>,
    is_clipped: Py<PyArray1<bool>>,
    is_cut: Py<PyArray1<bool>>,
    pixel: Py<PyArray2<i64>>,
    light_of_pixel: Py<PyArray1<i64>>,
    luminance: Py<PyArray1<f32>>,
    panes: Vec<usize>,
    widest_bar: (f64, f64),
    threshold: f64,
    threshold_rule: Option<(f64, f64, Option<f64>)>,
    working_size: (usize, usize),
    tiles: usize,
    opened_tiles: usize,
    dropped: usize,
    merged: usize,
    clipped: Option<Py<ClippedDetection>>,
}

/// Properties of the lights of a clipped map.
#[pyclass(frozen, get_all)]
pub struct ClippedDetection {
    direction_uncertainty: Py<PyArray1<f64>>,
    weight: Py<PyArray1<f64>>,
    clip_level: f64,
    is_below_largest: bool,
    clipped_fraction: f64,
}

/// See `envlights.kernels.reduced_luminance`.
#[pyfunction]
pub fn reduced_luminance<'py>(
    py: Python<'py>,
    radiance: PyReadonlyArray3<'py, f32>,
    columns: usize,
    border_sampled: bool,
) -> PyResult<Bound<'py, PyArray2<f32>>> {
    let radiance = radiance.as_array();
    let working = in_pool(py, || WorkingImage::of(radiance, registration(border_sampled), columns))?;
    working.luminance.into_pyarray(py).reshape(working.size)
}

/// See `envlights.detect`.
#[pyfunction]
pub fn detect_tree(
    py: Python<'_>,
    radiance: PyReadonlyArray3<'_, f32>,
    border_sampled: bool,
    options: TreeOptions,
    seen: Option<PyReadonlyArray2<'_, f32>>,
) -> PyResult<TreeDetection> {
    let (radiance, seen) = (radiance.as_array(), seen.as_ref().map(|seen| seen.as_array()));
    let (registration, options) = (registration(border_sampled), DetectionOptions::from(options));
    let detection = interruptible(py, || detect::detect(radiance, seen, registration, &options))?;
    TreeDetection::new(py, detection, options.clip_level)
}

impl ClippedDetection {
    fn new(py: Python<'_>, lights: ClippedLights) -> PyResult<Py<Self>> {
        let uncertainty: Array1<f64> = lights.positions.iter().map(|position| position.uncertainty).collect();
        let detection = Self {
            direction_uncertainty: uncertainty.into_pyarray(py).unbind(),
            weight: Array1::from(lights.weights).into_pyarray(py).unbind(),
            clip_level: lights.level.luminance(),
            is_below_largest: matches!(lights.level, ClipLevel::Peak(_)),
            clipped_fraction: lights.clipped_fraction,
        };
        Py::new(py, detection)
    }
}

impl TreeDetection {
    fn new(py: Python<'_>, detection: Detection, clip_level: Option<f64>) -> PyResult<Self> {
        let (lights, report) = (&detection.lights, detection.report);
        let numbers = |of: &dyn Fn(&LightMoments) -> f64| {
            lights.iter().map(of).collect::<Array1<f64>>().into_pyarray(py).unbind()
        };
        let vectors = |of: fn(&LightMoments) -> [f64; 3]| {
            let rows: Vec<[f64; 3]> = lights.iter().map(of).collect();
            Array2::from(rows).into_pyarray(py).unbind()
        };
        let runs = runs(&detection.pixels, report.working_size.1);
        let pixels_of_run =
            |Run { row, columns }: Run| columns.map(move |column| [row as i64, column as i64]);
        let pixels: Vec<[i64; 2]> = runs.into_iter().flat_map(pixels_of_run).collect();
        let light_of_pixel: Vec<i64> = detection.light_of_pixel.iter().map(|&light| light.into()).collect();
        let whole = if report.flux > 0.0 { report.flux } else { 1.0 };
        Ok(Self {
            direction: vectors(|light| light.direction().to_array()),
            irradiance: vectors(LightMoments::irradiance),
            flux: vectors(|light| light.flux_rgb),
            peak_direction: vectors(|light| light.peak_direction().to_array()),
            orientation: vectors(|light| light.elongation().1.to_array()),
            solid_angle: numbers(&LightMoments::solid_angle),
            elongation: numbers(&|light| light.elongation().0),
            peak_luminance: numbers(&|light| light.peak),
            flux_fraction: numbers(&|light| light.flux / whole),
            is_clipped: detection.are_clipped(clip_level).collect::<Array1<bool>>().into_pyarray(py).unbind(),
            is_cut: Array1::from(detection.is_cut).into_pyarray(py).unbind(),
            pixel: Array2::from(pixels).into_pyarray(py).unbind(),
            light_of_pixel: Array1::from(light_of_pixel).into_pyarray(py).unbind(),
            luminance: detection.luminance.into_pyarray(py).unbind(),
            panes: detection.panes,
            widest_bar: (BARS.widest, BARS.widest_angle),
            threshold: report.threshold.luminance,
            threshold_rule: report.threshold.rule.numbers(),
            working_size: report.working_size,
            tiles: report.tiles,
            opened_tiles: report.opened_tiles,
            dropped: report.dropped,
            merged: report.merged,
            clipped: detection.clipped.map(|lights| ClippedDetection::new(py, lights)).transpose()?,
        })
    }
}
