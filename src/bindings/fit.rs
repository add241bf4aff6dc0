//! `kernels::fit` for Python.

use std::sync::Arc;

use glam::DVec3;
use numpy::ndarray::{ArrayView1, ArrayView2};
use numpy::{IntoPyArray, PyArray2, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;

use super::pool::in_pool;
use crate::error::Error;
use crate::kernels::fit::{self, Ambient, Goal, Probe, Request, Rig, Solution, StopReason};
use crate::kernels::sphere::{from_vectors, unit_vectors};

/// The best rig with one number of lights, and the probe it was fitted to.
#[pyclass(frozen)]
pub struct FitAnswer {
    #[pyo3(get)]
    lights: usize,
    #[pyo3(get)]
    error: f64,
    #[pyo3(get)]
    steps: usize,
    #[pyo3(get)]
    stop: &'static str,
    rig: Rig,
    held: usize,
    probe: Arc<Probe>,
}

/// Condition number, and the standard errors of directions and irradiance.
type Uncertainties = (f64, Vec<f64>, Vec<[f64; 3]>);

#[pymethods]
impl FitAnswer {
    #[getter]
    fn ambient<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        rows(py, &self.rig.ambient)
    }

    #[getter]
    fn directions<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        rows(py, &self.rig.directions)
    }

    #[getter]
    fn irradiance<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        rows(py, &self.rig.irradiance)
    }

    /// How well the probe determines the lights: worth computing only for the answer that is taken.
    fn uncertainty(&self, py: Python<'_>) -> Uncertainties {
        let found = py.detach(|| fit::uncertainty(&self.probe, &self.rig, self.held));
        (found.condition, found.direction, found.irradiance)
    }
}

fn rows<'py>(py: Python<'py>, vectors: &[DVec3]) -> Bound<'py, PyArray2<f64>> {
    from_vectors(vectors.iter().copied()).into_pyarray(py)
}

/// Normals, weights and irradiance.
type Samples<'py> = (PyReadonlyArray2<'py, f64>, PyReadonlyArray1<'py, f64>, PyReadonlyArray2<'py, f64>);

/// See `envlights.fit`: the best rig for each number of lights.
#[pyfunction]
pub fn fit_lights(
    py: Python<'_>,
    fitted: Samples<'_>,
    goal: (Samples<'_>, Option<f64>),
    ambient: usize,
    start: (PyReadonlyArray2<'_, f64>, usize),
    lights: usize,
    max_steps: usize,
) -> PyResult<Vec<FitAnswer>> {
    let ((judging, error), (start, held)) = (&goal, &start);
    let (fitted, judging, start) = (views(&fitted), views(judging), start.as_array());
    let (error, held) = (*error, *held);
    in_pool(py, || {
        let ambient = Ambient::with(ambient).ok_or(Error::NotAmbient { seen: ambient })?;
        let samples = |(normals, weights, irradiance)| fit::Samples::new(normals, weights, irradiance);
        let probe = Arc::new(Probe::new(samples(fitted)?, ambient));
        let goal = Goal { judge: samples(judging)?, error };
        let start = unit_vectors("start", start)?;
        let request = Request { start: &start, held, lights, max_steps, goal: &goal };
        let solutions = fit::fit(&probe, &request)?;
        Ok(solutions.into_iter().map(|solution| answer(&probe, held, solution)).collect())
    })
}

type Views<'a> = (ArrayView2<'a, f64>, ArrayView1<'a, f64>, ArrayView2<'a, f64>);

fn views<'a>((normals, weights, irradiance): &'a Samples<'_>) -> Views<'a> {
    (normals.as_array(), weights.as_array(), irradiance.as_array())
}

fn answer(probe: &Arc<Probe>, held: usize, solution: Solution) -> FitAnswer {
    let Solution { lights, rig, error, steps, stop } = solution;
    let stop = match stop {
        StopReason::Converged => "CONVERGED",
        StopReason::Exact => "EXACT",
        StopReason::OutOfSteps => "OUT_OF_STEPS",
    };
    let held = held.min(rig.directions.len());
    FitAnswer { lights, error, steps, stop, rig, held, probe: probe.clone() }
}

/// See `envlights.Rig.probe`.
#[pyfunction]
pub fn rig_irradiance<'py>(
    py: Python<'py>,
    normals: PyReadonlyArray2<'py, f64>,
    ambient: PyReadonlyArray2<'py, f64>,
    directions: PyReadonlyArray2<'py, f64>,
    irradiance: PyReadonlyArray2<'py, f64>,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let (normals, ambient) = (normals.as_array(), ambient.as_array());
    let (directions, irradiance) = (directions.as_array(), irradiance.as_array());
    let out = py.detach(|| {
        let rig = Rig::new(ambient, directions, irradiance)?;
        fit::irradiance(&rig, normals)
    })?;
    Ok(out.into_pyarray(py))
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
    Ok(py.detach(|| fit::relative_rms(seen, wanted, weights))?)
}
