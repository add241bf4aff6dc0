//! `kernels::fit` for Python.

use glam::DVec3;
use numpy::ndarray::Array2;
use numpy::{IntoPyArray, PyArray1, PyArray2, PyReadonlyArray1, PyReadonlyArray2, PyReadonlyArray3};
use pyo3::prelude::*;

use super::pool::{by_size, interruptible};
use super::reduction::ReducedMap;
use super::sphere::registration;
use crate::error::Result;
use crate::kernels::disc::{self, Discs};
use crate::kernels::fit::{
    self, Ambient, Clock, Comparison, ContinuedRig, FitOptions, FitResult, ProbeError, Rig, Samples,
    StopReason,
};
use crate::kernels::image;
use crate::kernels::sphere::{unit_vectors, vectors};

/// Normals, weights and irradiance.
type MapSamples<'py> = (Bound<'py, PyArray2<f64>>, Bound<'py, PyArray1<f64>>, Bound<'py, PyArray2<f64>>);

/// The best rig, and how it was found; see `envlights.fit`.
#[pyclass(frozen)]
pub struct FitAnswer {
    result: FitResult,
    /// The map; absent for measured values.
    map: Option<Py<ReducedMap>>,
}

#[pymethods]
impl FitAnswer {
    #[getter]
    fn ambient<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        rows(py, &self.result.rig.ambient)
    }

    #[getter]
    fn directions<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        rows(py, &self.result.rig.directions)
    }

    #[getter]
    fn irradiance<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        rows(py, &self.result.rig.irradiance)
    }

    /// Number of lights.
    #[getter]
    fn lights(&self) -> usize {
        self.result.rig.directions.len()
    }

    /// Angular radius of each light, in radians: 0 for a point.
    #[getter]
    fn angular_radii(&self) -> Vec<f64> {
        self.result.radii.clone()
    }

    /// Number of bright cells of the working map that are exact.
    #[getter]
    fn points(&self) -> usize {
        self.map.as_ref().map_or(0, |map| map.get().map.sources.dim().0)
    }

    /// Lights whose radius is at the greatest one of the options.
    #[getter]
    fn at_bound(&self) -> Vec<usize> {
        self.result.at_bound.clone()
    }

    /// Relative RMS error of the irradiance where things stand in the way, under a map.
    #[getter]
    fn shadow_error(&self) -> f64 {
        self.result.shadow_error
    }

    /// Relative RMS error that the lights minimise.
    #[getter]
    fn objective_error(&self) -> f64 {
        self.result.objective_error
    }

    /// Energy of the map in each degree of spherical harmonics, and of its difference from the rig; empty without a map.
    #[getter]
    fn bands(&self, py: Python<'_>) -> PyResult<[Vec<f64>; 2]> {
        let Some(map) = &self.map else { return Ok([Vec::new(), Vec::new()]) };
        let FitResult { rig, radii, .. } = &self.result;
        let bands = interruptible(py, || Ok(fit::bands(&map.get().picture(), rig, radii)))?;
        Ok([bands.map, bands.difference])
    }

    /// Relative RMS error of the rig in a program that shows its lights as points.
    #[getter]
    fn points_error(&self) -> f64 {
        self.result.points_error
    }

    /// Relative RMS error of as many lights, fitted as points.
    #[getter]
    fn fitted_points_error(&self) -> f64 {
        self.result.fitted_points_error
    }

    /// Relative RMS error by number of lights.
    #[getter]
    fn errors(&self) -> Vec<(usize, f64)> {
        self.result.errors.clone()
    }

    /// Fitted channels: not black, and not equal to another.
    #[getter]
    fn channels(&self) -> usize {
        self.result.channels
    }

    /// Relative RMS error of the rig.
    #[getter]
    fn error(&self) -> f64 {
        self.result.probe_error.error
    }

    /// Normals, their weights, and the irradiance of the map there; absent for measured values.
    #[getter]
    fn map_samples<'py>(&self, py: Python<'py>) -> PyResult<Option<MapSamples<'py>>> {
        Ok(self.at_normals(py)?.map(|(samples, _)| sample_rows(py, &samples)))
    }

    #[getter]
    fn channel_errors(&self) -> [f64; 3] {
        self.result.probe_error.channels
    }

    #[getter]
    fn max_error(&self, py: Python<'_>) -> PyResult<f64> {
        let at_normals = self.at_normals(py)?.map_or(self.result.probe_error, |(_, error)| error);
        Ok(at_normals.largest)
    }

    /// Wall time of each step, in seconds.
    #[getter]
    fn seconds(&self) -> Vec<(&'static str, f64)> {
        self.result.seconds.clone()
    }

    /// Direction tolerance of each light under a map, in radians: the turn that makes the error a tenth larger.
    #[getter]
    fn tolerances(&self) -> Vec<f64> {
        self.result.tolerances.clone()
    }

    /// Condition number, for measured values.
    #[getter]
    fn condition(&self) -> f64 {
        self.result.uncertainty.condition
    }

    /// Standard errors in radians, for measured values.
    #[getter]
    fn direction_errors(&self) -> Vec<f64> {
        self.result.uncertainty.direction.clone()
    }

    /// Standard errors in each channel, for measured values.
    #[getter]
    fn irradiance_errors(&self) -> Vec<[f64; 3]> {
        self.result.uncertainty.irradiance.clone()
    }

    #[getter]
    fn steps(&self) -> usize {
        self.result.steps
    }

    #[getter]
    fn stop(&self) -> &'static str {
        match self.result.stop {
            StopReason::Converged => "CONVERGED",
            StopReason::Exact => "EXACT",
            StopReason::OutOfSteps => "OUT_OF_STEPS",
        }
    }
}

impl FitAnswer {
    /// The irradiance of the map at many normals, and the errors of the rig there.
    fn at_normals(&self, py: Python<'_>) -> PyResult<Option<(Samples, ProbeError)>> {
        let Some(map) = &self.map else { return Ok(None) };
        let FitResult { rig, radii, .. } = &self.result;
        let map = map.get();
        interruptible(py, || fit::at_normals(&map.map, &map.picture(), rig, radii)).map(Some)
    }
}

fn sample_rows<'py>(py: Python<'py>, samples: &Samples) -> MapSamples<'py> {
    let Samples { normals, weights, irradiance, .. } = samples;
    (rows(py, normals), PyArray1::from_slice(py, weights), rows(py, irradiance))
}

fn rows<'py>(py: Python<'py>, vectors: &[DVec3]) -> Bound<'py, PyArray2<f64>> {
    let rows: Vec<[f64; 3]> = vectors.iter().map(DVec3::to_array).collect();
    Array2::from(rows).into_pyarray(py)
}

/// Options of a fit: `envlights.fitting.options.FitOptions`.
#[derive(FromPyObject)]
pub struct Options<'py> {
    ambient: usize,
    start: PyReadonlyArray2<'py, f64>,
    fixed: usize,
    lights: usize,
    error: Option<f64>,
    shadow_error: Option<f64>,
    gloss_error: Option<f64>,
    gloss_factors: Vec<f64>,
    sizes: Option<String>,
    max_radius: Option<f64>,
    max_steps: usize,
    floor: bool,
    error_floor: f64,
    is_plain: bool,
}

impl Options<'_> {
    /// Options of the kernel.
    fn for_kernel(&self) -> Result<FitOptions> {
        Ok(FitOptions {
            ambient: Ambient::of(self.ambient)?,
            start: unit_vectors("start", self.start.as_array())?,
            fixed: self.fixed,
            lights: self.lights,
            error: self.error,
            shadow_error: self.shadow_error,
            gloss_error: self.gloss_error,
            gloss_factors: self.gloss_factors.clone(),
            sizes: self.sizes.as_deref().map(comparison),
            max_radius: self.max_radius,
            max_steps: self.max_steps,
            has_floor: self.floor,
            error_floor: self.error_floor,
            is_plain: self.is_plain,
        })
    }
}

/// The comparison of this name in Python, which checks it.
fn comparison(objective: &str) -> Comparison {
    match objective {
        "probe" => Comparison::Probe,
        "mixed" => Comparison::Mixed,
        _ => Comparison::Shadows,
    }
}

/// See `envlights.fit`: the best rig with at most each of `counts` lights, which are at most those of the options.
///
/// The floor of the options is that of the reduced map.
#[pyfunction]
pub fn fit_reduced(
    py: Python<'_>,
    reduced: Py<ReducedMap>,
    options: Options<'_>,
    counts: Vec<usize>,
) -> PyResult<Vec<FitAnswer>> {
    let map = reduced.get();
    let options = FitOptions { has_floor: map.floor, ..options.for_kernel()? };
    let results = interruptible(py, || {
        let clock = Clock::start();
        fit::under_map(&map.map, &map.picture(), &options, &counts, clock)
    })?;
    Ok(results.into_iter().map(|result| FitAnswer { result, map: Some(reduced.clone_ref(py)) }).collect())
}

/// Ambient, directions, irradiance and radii of a rig, its error, the error that it minimises, and the map at its normals.
type ContinuedAnswer<'py> = (
    Bound<'py, PyArray2<f64>>,
    Bound<'py, PyArray2<f64>>,
    Bound<'py, PyArray2<f64>>,
    Vec<f64>,
    f64,
    f64,
    MapSamples<'py>,
);

/// See `envlights.follow`: the rig of the minimum near the starts of the options, which have these angular radii.
#[pyfunction]
pub fn continue_reduced<'py>(
    py: Python<'py>,
    reduced: &ReducedMap,
    options: Options<'py>,
    radii: PyReadonlyArray1<'py, f64>,
) -> PyResult<ContinuedAnswer<'py>> {
    let options = FitOptions { has_floor: reduced.floor, ..options.for_kernel()? };
    let radii = radii.as_array().to_vec();
    let ContinuedRig { lights, probe_error, samples } =
        interruptible(py, || fit::continue_under_map(&reduced.map, &options, &radii))?;
    Ok((
        rows(py, &lights.rig.ambient),
        rows(py, &lights.rig.directions),
        rows(py, &lights.rig.irradiance),
        lights.radii,
        probe_error.error,
        lights.objective_error,
        sample_rows(py, &samples),
    ))
}

/// The squared irradiance under a map, integrated over all normals and summed over channels: the field of the search
/// alone, for benchmarks and tests.
#[pyfunction]
pub fn map_energy(
    py: Python<'_>,
    radiance: PyReadonlyArray3<'_, f32>,
    border_sampled: bool,
    columns: usize,
    point_share: f64,
) -> PyResult<f64> {
    let radiance = radiance.as_array();
    interruptible(py, || {
        let map = image::reduce(radiance, registration(border_sampled), columns, point_share, false)?;
        Ok(fit::energy(&map))
    })
}

/// See `envlights.fit_probe`.
#[pyfunction]
pub fn fit_samples(
    py: Python<'_>,
    normals: PyReadonlyArray2<'_, f64>,
    weights: PyReadonlyArray1<'_, f64>,
    irradiance: PyReadonlyArray2<'_, f64>,
    options: Options<'_>,
) -> PyResult<FitAnswer> {
    let (normals, weights, irradiance) = (normals.as_array(), weights.as_array(), irradiance.as_array());
    let options = options.for_kernel()?;
    let fitted =
        interruptible(py, || fit::to_samples(Samples::new(normals, weights, irradiance)?, &options))?;
    Ok(FitAnswer { result: fitted, map: None })
}

/// See `envlights.Rig.probe`.
#[pyfunction]
pub fn rig_irradiance<'py>(
    py: Python<'py>,
    normals: PyReadonlyArray2<'py, f64>,
    ambient: PyReadonlyArray2<'py, f64>,
    directions: PyReadonlyArray2<'py, f64>,
    irradiance: PyReadonlyArray2<'py, f64>,
    radii: PyReadonlyArray1<'py, f64>,
    floor: bool,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let (normals, ambient, radii) = (normals.as_array(), ambient.as_array(), radii.as_array());
    let (directions, irradiance) = (directions.as_array(), irradiance.as_array());
    let out = interruptible(py, || {
        let sky = Rig::of_ambient(ambient, floor)?;
        disc::irradiance(&Discs::new(directions, irradiance, radii)?, normals, |normal| sky.at(normal))
    })?;
    Ok(out.into_pyarray(py))
}

/// Numbers that count for each normal, so that more than one part of them enters the pool of threads.
const FEW_NUMBERS_A_NORMAL: usize = 64;

/// The relative RMS error of a rig with sizes under a map with this irradiance at normals; see `envlights.follow`.
#[pyfunction]
pub fn rig_error(
    py: Python<'_>,
    samples: (PyReadonlyArray2<'_, f64>, PyReadonlyArray1<'_, f64>, PyReadonlyArray2<'_, f64>),
    ambient: PyReadonlyArray2<'_, f64>,
    directions: PyReadonlyArray2<'_, f64>,
    irradiance: PyReadonlyArray2<'_, f64>,
    radii: Vec<f64>,
    floor: bool,
) -> PyResult<f64> {
    let (normals, weights, wanted) = (samples.0.as_array(), samples.1.as_array(), samples.2.as_array());
    let (ambient, irradiance) = (ambient.as_array(), irradiance.as_array());
    let directions = directions.as_array();
    by_size(py, FEW_NUMBERS_A_NORMAL * normals.len(), || {
        let rig = Rig {
            directions: unit_vectors("direction", directions)?,
            irradiance: vectors("irradiance", irradiance)?,
            ..Rig::of_ambient(ambient, floor)?
        };
        Ok(Samples::new(normals, weights, wanted)?.evaluate(&rig, &radii).error)
    })
}

/// See `envlights.kernels.relative_rms`.
#[pyfunction]
pub fn relative_rms(
    py: Python<'_>,
    seen: PyReadonlyArray2<'_, f64>,
    wanted: PyReadonlyArray2<'_, f64>,
    weights: PyReadonlyArray1<'_, f64>,
) -> PyResult<f64> {
    let (seen, wanted, weights) = (seen.as_array(), wanted.as_array(), weights.as_array());
    by_size(py, seen.len(), || fit::relative_rms(seen, wanted, weights))
}
