//! `kernels::fit` for Python.

use glam::DVec3;
use numpy::{IntoPyArray, PyArray2, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;

use crate::kernels::fit::{self, Goal, Probe, Rig, Solution, StopReason};
use crate::kernels::sphere::{from_vectors, unit_vectors};

/// Ambient radiance, directions, irradiance, residual, steps, stop reason.
type Answer<'py> = ([f64; 3], Bound<'py, PyArray2<f64>>, Bound<'py, PyArray2<f64>>, f64, usize, &'static str);

/// Normals, weights and irradiance that judge, and the error that is good enough.
type Judge<'py> = (PyReadonlyArray2<'py, f64>, PyReadonlyArray1<'py, f64>, PyReadonlyArray2<'py, f64>, f64);

/// See `envlights.fit`: the best rig for each number of lights.
#[pyfunction]
pub fn fit_lights<'py>(
    py: Python<'py>,
    normals: PyReadonlyArray2<'py, f64>,
    weights: PyReadonlyArray1<'py, f64>,
    irradiance: PyReadonlyArray2<'py, f64>,
    start: PyReadonlyArray2<'py, f64>,
    has_ambient: bool,
    lights: usize,
    max_steps: usize,
    goal: Option<Judge<'py>>,
) -> PyResult<Vec<Answer<'py>>> {
    let (normals, weights, irradiance) = (normals.as_array(), weights.as_array(), irradiance.as_array());
    let start = start.as_array();
    let judge = goal.as_ref().map(|(n, w, e, error)| (n.as_array(), w.as_array(), e.as_array(), *error));
    let solutions = py.detach(|| {
        let probe = Probe::new(normals, weights, irradiance, has_ambient)?;
        let goal = match judge {
            Some((n, w, e, error)) => Some(Goal { judge: Probe::new(n, w, e, has_ambient)?, error }),
            None => None,
        };
        fit::fit(&probe, &unit_vectors("start", start)?, lights, max_steps, goal.as_ref())
    })?;
    Ok(solutions.into_iter().map(|solution| answer(py, solution)).collect())
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
