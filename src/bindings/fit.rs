//! `kernels::fit` for Python.

use glam::DVec3;
use numpy::ndarray::{ArrayView1, ArrayView2};
use numpy::{IntoPyArray, PyArray2, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;

use crate::error::Error;
use crate::kernels::fit::{self, Ambient, Goal, Probe, Request, Rig, Solution, StopReason};
use crate::kernels::sphere::{from_vectors, unit_vectors};

/// The best rig with one number of lights.
#[pyclass(frozen, get_all)]
pub struct FitAnswer {
    lights: usize,
    ambient: Py<PyArray2<f64>>,
    directions: Py<PyArray2<f64>>,
    irradiance: Py<PyArray2<f64>>,
    condition: f64,
    direction_errors: Vec<f64>,
    irradiance_errors: Vec<[f64; 3]>,
    error: f64,
    steps: usize,
    stop: &'static str,
}

/// Normals, weights and irradiance.
type Samples<'py> = (PyReadonlyArray2<'py, f64>, PyReadonlyArray1<'py, f64>, PyReadonlyArray2<'py, f64>);

/// See `envlights.fit`: the best rig for each number of lights.
#[pyfunction]
pub fn fit_lights<'py>(
    py: Python<'py>,
    fitted: Samples<'py>,
    goal: (Samples<'py>, Option<f64>),
    ambient: usize,
    start: (PyReadonlyArray2<'py, f64>, usize),
    lights: usize,
    max_steps: usize,
) -> PyResult<Vec<FitAnswer>> {
    let ((judging, error), (start, held)) = (&goal, &start);
    let (fitted, judging, start) = (views(&fitted), views(judging), start.as_array());
    let (error, held) = (*error, *held);
    let solutions = py.detach(|| {
        let ambient = Ambient::with(ambient).ok_or(Error::NotAmbient { seen: ambient })?;
        let samples = |(normals, weights, irradiance)| fit::Samples::new(normals, weights, irradiance);
        let probe = Probe::new(samples(fitted)?, ambient);
        let goal = Goal { judge: samples(judging)?, error };
        let start = unit_vectors("start", start)?;
        fit::fit(&probe, &Request { start: &start, held, lights, max_steps, goal: &goal })
    })?;
    Ok(solutions.into_iter().map(|solution| answer(py, solution)).collect())
}

type Views<'a> = (ArrayView2<'a, f64>, ArrayView1<'a, f64>, ArrayView2<'a, f64>);

fn views<'a>((normals, weights, irradiance): &'a Samples<'_>) -> Views<'a> {
    (normals.as_array(), weights.as_array(), irradiance.as_array())
}

fn answer(py: Python<'_>, solution: Solution) -> FitAnswer {
    let Solution { lights, rig, uncertainty, error, steps, stop } = solution;
    let rows = |vectors: Vec<DVec3>| from_vectors(vectors.into_iter()).into_pyarray(py).unbind();
    FitAnswer {
        lights,
        ambient: rows(rig.ambient),
        directions: rows(rig.directions),
        irradiance: rows(rig.irradiance),
        condition: uncertainty.condition,
        direction_errors: uncertainty.direction,
        irradiance_errors: uncertainty.irradiance,
        error,
        steps,
        stop: match stop {
            StopReason::Converged => "CONVERGED",
            StopReason::Exact => "EXACT",
            StopReason::OutOfSteps => "OUT_OF_STEPS",
        },
    }
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
        let rig = Rig {
            ambient: vectors(ambient),
            directions: unit_vectors("direction", directions)?,
            irradiance: vectors(irradiance),
        };
        fit::irradiance(&rig, normals)
    })?;
    Ok(out.into_pyarray(py))
}

fn vectors(rows: ArrayView2<'_, f64>) -> Vec<DVec3> {
    rows.rows().into_iter().map(|row| DVec3::new(row[0], row[1], row[2])).collect()
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
