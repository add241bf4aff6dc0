//! `kernels::fit` for Python.

use glam::DVec3;
use numpy::ndarray::{ArrayView1, ArrayView2};
use numpy::{IntoPyArray, PyArray2, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;

use crate::kernels::fit::{self, Goal, Probe, Rig, Solution, StopReason};
use crate::kernels::sphere::{from_vectors, unit_vectors};

/// Ambient radiance, directions, irradiance, residual, steps, stop reason.
type Answer<'py> = ([f64; 3], Bound<'py, PyArray2<f64>>, Bound<'py, PyArray2<f64>>, f64, usize, &'static str);

/// Normals, weights and irradiance.
type Samples<'py> = (PyReadonlyArray2<'py, f64>, PyReadonlyArray1<'py, f64>, PyReadonlyArray2<'py, f64>);

/// See `envlights.fit`: the best rig for each number of lights.
#[pyfunction]
pub fn fit_lights<'py>(
    py: Python<'py>,
    fitted: Samples<'py>,
    start: PyReadonlyArray2<'py, f64>,
    has_ambient: bool,
    lights: usize,
    max_steps: usize,
    goal: Option<(Samples<'py>, f64)>,
) -> PyResult<Vec<Answer<'py>>> {
    let (fitted, start) = (views(&fitted), start.as_array());
    let goal = goal.as_ref().map(|(judge, error)| (views(judge), *error));
    let solutions = py.detach(|| {
        let probe = |(n, w, e)| Probe::new(n, w, e, has_ambient);
        let goal = goal.map(|(judge, error)| Ok(Goal { judge: probe(judge)?, error })).transpose()?;
        fit::fit(&probe(fitted)?, &unit_vectors("start", start)?, lights, max_steps, goal.as_ref())
    })?;
    Ok(solutions.into_iter().map(|solution| answer(py, solution)).collect())
}

type Views<'a> = (ArrayView2<'a, f64>, ArrayView1<'a, f64>, ArrayView2<'a, f64>);

fn views<'a>((normals, weights, irradiance): &'a Samples<'_>) -> Views<'a> {
    (normals.as_array(), weights.as_array(), irradiance.as_array())
}

fn answer(py: Python<'_>, solution: Solution) -> Answer<'_> {
    let Solution { rig, residual, steps, stop } = solution;
    let stop = match stop {
        StopReason::Converged => "CONVERGED",
        StopReason::Exact => "EXACT",
        StopReason::OutOfSteps => "OUT_OF_STEPS",
    };
    (
        rig.ambient.to_array(),
        from_vectors(rig.directions.into_iter()).into_pyarray(py),
        from_vectors(rig.irradiance.into_iter()).into_pyarray(py),
        residual,
        steps,
        stop,
    )
}

/// See `envlights.Rig.probe`.
#[pyfunction]
pub fn rig_irradiance<'py>(
    py: Python<'py>,
    normals: PyReadonlyArray2<'py, f64>,
    ambient: [f64; 3],
    directions: PyReadonlyArray2<'py, f64>,
    irradiance: PyReadonlyArray2<'py, f64>,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let (normals, directions, irradiance) =
        (normals.as_array(), directions.as_array(), irradiance.as_array());
    let out = py.detach(|| {
        let rig = Rig {
            ambient: DVec3::from_array(ambient),
            directions: unit_vectors("direction", directions)?,
            irradiance: irradiance.rows().into_iter().map(|row| DVec3::new(row[0], row[1], row[2])).collect(),
        };
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
