//! `kernels::detect` for Python.

use numpy::ndarray::{Array1, Array2};
use numpy::{IntoPyArray, PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray3};
use pyo3::prelude::*;

use super::pool::{in_pool, interruptible};
use super::sphere::registration;
use crate::kernels::detect::clipped_share as clipped;
use crate::kernels::detect::tree::{
    self, Detection, Light, Options, Original, OriginalWhite, Rule, Run, WorkingImage, runs,
};
use crate::kernels::detect::white::{self, Ending};

/// The lights of `detect_tree`, and how they were found; see `envlights.detect_tree`.
#[pyclass(frozen, get_all)]
pub struct TreeDetection {
    direction: Py<PyArray2<f64>>,
    irradiance: Py<PyArray2<f64>>,
    peak_direction: Py<PyArray2<f64>>,
    orientation: Py<PyArray2<f64>>,
    solid_angle: Py<PyArray1<f64>>,
    elongation: Py<PyArray1<f64>>,
    peak_luminance: Py<PyArray1<f64>>,
    flux: Py<PyArray1<f64>>,
    is_clipped: Py<PyArray1<bool>>,
    pixel: Py<PyArray2<i64>>,
    light_of_pixel: Py<PyArray1<i64>>,
    luminance: Py<PyArray1<f32>>,
    panes: Vec<usize>,
    is_faint: Vec<bool>,
    widest_bar: (f64, f64),
    threshold: f64,
    threshold_rule: Option<(f64, f64, Option<f64>)>,
    map_flux: f64,
    working_size: (usize, usize),
    tiles: usize,
    opened_tiles: usize,
    dropped: usize,
    merged: usize,
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

/// See `envlights.detect_tree`.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "every option is named once more, on the Python side")]
pub fn detect_tree(
    py: Python<'_>,
    radiance: PyReadonlyArray3<'_, f32>,
    border_sampled: bool,
    working_columns: usize,
    rise: f64,
    prominence: f64,
    extent: f64,
    gap: f64,
    min_flux_share: f64,
    min_worth: f64,
    max_lights: usize,
    original: Option<OriginalNumbers>,
) -> PyResult<TreeDetection> {
    let radiance = radiance.as_array();
    let options = Options {
        working_columns,
        rise,
        prominence,
        extent,
        gap,
        min_flux_share,
        min_worth,
        max_lights,
        original: original.map(original_of),
    };
    let found = in_pool(py, || tree::detect(radiance, registration(border_sampled), &options))?;
    Ok(TreeDetection::new(py, found, None))
}

/// The lights of `detect_white`, beside those of the tree; see `envlights.detect_tree`.
#[pyclass(frozen, get_all)]
pub struct WhiteDetection {
    tree: Py<TreeDetection>,
    direction_uncertainty: Py<PyArray1<f64>>,
    plateau_radius: Py<PyArray1<f64>>,
    weight: Py<PyArray1<f64>>,
    ending: (&'static str, f64),
    clipped_share: f64,
    least_weight: f64,
}

/// See `envlights.detect_tree`.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "every option is named once more, on the Python side")]
pub fn detect_white(
    py: Python<'_>,
    radiance: PyReadonlyArray3<'_, f32>,
    border_sampled: bool,
    white: f64,
    working_columns: usize,
    rise: f64,
    prominence: f64,
    extent: f64,
    gap: f64,
    min_flux_share: f64,
    min_worth: f64,
    max_lights: usize,
    original: Option<OriginalNumbers>,
) -> PyResult<WhiteDetection> {
    let radiance = radiance.as_array();
    let options = Options {
        working_columns,
        rise,
        prominence,
        extent,
        gap,
        min_flux_share,
        min_worth,
        max_lights,
        original: original.map(original_of),
    };
    let found = interruptible(py, || white::detect(radiance, registration(border_sampled), white, &options))?;
    let numbers = |values: Vec<f64>| Array1::from(values).into_pyarray(py).unbind();
    Ok(WhiteDetection {
        tree: Py::new(py, TreeDetection::new(py, found.detection, Some(white as f32)))?,
        direction_uncertainty: numbers(found.places.iter().map(|place| place.uncertainty).collect()),
        plateau_radius: numbers(found.places.iter().map(|place| place.plateau_radius).collect()),
        weight: numbers(found.weights),
        ending: ending(found.ending),
        clipped_share: found.clipped_share,
        least_weight: found.least_weight,
    })
}

/// The fields of `envlights.envmap.Original`.
type OriginalNumbers = (f64, f64, f64, Option<f64>, f64, usize);

fn original_of((threshold, flux, peak, end, least_weight, _): OriginalNumbers) -> Original {
    Original { threshold, flux, peak, white: end.map(|end| OriginalWhite { end, least_weight }) }
}

/// See `envlights.EnvMap.clipped_share`: of the sphere, and of the flux.
#[pyfunction]
pub fn clipped_share(
    py: Python<'_>,
    radiance: PyReadonlyArray3<'_, f32>,
    border_sampled: bool,
    white: Option<f32>,
) -> PyResult<(f64, f64)> {
    let radiance = radiance.as_array();
    let share = in_pool(py, || clipped::clipped_share(radiance, registration(border_sampled), white))?;
    Ok((share.sphere, share.flux))
}

/// The share of each pixel in the light that was cut off at `white`; see `envlights.repair`.
#[pyfunction]
pub fn clipped_light_shares<'py>(
    py: Python<'py>,
    radiance: PyReadonlyArray3<'py, f32>,
    border_sampled: bool,
    white: f64,
    working_columns: usize,
    gap: f64,
) -> PyResult<Bound<'py, PyArray2<f32>>> {
    let radiance = radiance.as_array();
    let registration = registration(border_sampled);
    let shares = interruptible(py, || white::shares(radiance, registration, white, working_columns, gap))?;
    Ok(shares.into_pyarray(py))
}

/// The depth of the plateau in radians, as a working image; see `envlights.plot.plateau_picture`.
#[pyfunction]
pub fn plateau_depth<'py>(
    py: Python<'py>,
    radiance: PyReadonlyArray3<'py, f32>,
    border_sampled: bool,
    white: f64,
    working_columns: usize,
    gap: f64,
) -> PyResult<Bound<'py, PyArray2<f32>>> {
    let radiance = radiance.as_array();
    let registration = registration(border_sampled);
    let depth =
        interruptible(py, || white::plateau_depth(radiance, registration, white, working_columns, gap))?;
    Ok(depth.into_pyarray(py))
}

/// The name of an ending, and its luminance.
fn ending(ending: Ending) -> (&'static str, f64) {
    match ending {
        Ending::White(luminance) => ("white", luminance),
        Ending::Peak(luminance) => ("peak", luminance),
        Ending::Whole(luminance) => ("whole", luminance),
    }
}

/// Factor and share of the rule that set a threshold; where the cut was needed, also the share of the sphere
/// that is light. None for that of another map.
fn rule(rule: Rule) -> Option<(f64, f64, Option<f64>)> {
    match rule {
        Rule::Background { factor, share } => Some((factor, share, None)),
        Rule::BelowCut { factor, share, light_share } => Some((factor, share, Some(light_share))),
        Rule::Original => None,
    }
}

impl TreeDetection {
    fn new(py: Python<'_>, found: Detection, white: Option<f32>) -> Self {
        let lights = &found.lights;
        let numbers =
            |of: fn(&Light) -> f64| lights.iter().map(of).collect::<Array1<f64>>().into_pyarray(py).unbind();
        let vectors = |of: fn(&Light) -> [f64; 3]| {
            let rows: Vec<[f64; 3]> = lights.iter().map(of).collect();
            Array2::from(rows).into_pyarray(py).unbind()
        };
        let indices = |values: Array1<i64>| values.into_pyarray(py).unbind();
        let runs = runs(&found.pixels, found.report.working_size.1);
        let places = |Run { row, columns }: Run| columns.map(move |column| [row as i64, column as i64]);
        let pixels: Vec<[i64; 2]> = runs.into_iter().flat_map(places).collect();
        Self {
            direction: vectors(|light| light.direction().to_array()),
            irradiance: vectors(|light| light.irradiance),
            peak_direction: vectors(|light| light.peak_direction().to_array()),
            orientation: vectors(|light| light.elongation().1.to_array()),
            solid_angle: numbers(Light::solid_angle),
            elongation: numbers(|light| light.elongation().0),
            peak_luminance: numbers(|light| light.peak),
            flux: numbers(|light| light.flux),
            is_clipped: found.are_clipped(white).collect::<Array1<bool>>().into_pyarray(py).unbind(),
            pixel: Array2::from(pixels).into_pyarray(py).unbind(),
            light_of_pixel: indices(found.light_of_pixel.iter().map(|&light| i64::from(light)).collect()),
            luminance: found.luminance.into_pyarray(py).unbind(),
            panes: found.panes,
            is_faint: found.is_faint,
            widest_bar: (tree::WIDEST_BAR, tree::WIDEST_ANGLE),
            threshold: found.report.threshold.luminance,
            threshold_rule: rule(found.report.threshold.rule),
            map_flux: found.report.flux,
            working_size: found.report.working_size,
            tiles: found.report.tiles,
            opened_tiles: found.report.opened_tiles,
            dropped: found.report.dropped,
            merged: found.report.merged,
        }
    }
}
