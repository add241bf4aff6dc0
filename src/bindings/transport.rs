//! `kernels::transport` for Python.

use numpy::{IntoPyArray, PyArray1, PyArray2, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;

use super::pool::by_size;
use crate::kernels::transport;

/// Mean angle, pairs of rows, (k, 2), and moved shares, (k,).
type Plan<'py> = (f64, Bound<'py, PyArray2<i64>>, Bound<'py, PyArray1<f64>>);

/// See `envlights.kernels.transport_plan`.
#[pyfunction]
pub fn transport_plan<'py>(
    py: Python<'py>,
    from_directions: PyReadonlyArray2<'py, f64>,
    from_weights: PyReadonlyArray1<'py, f64>,
    to_directions: PyReadonlyArray2<'py, f64>,
    to_weights: PyReadonlyArray1<'py, f64>,
) -> PyResult<Plan<'py>> {
    let (from, to) = (from_directions.as_array(), to_directions.as_array());
    let (from_weights, to_weights) = (from_weights.as_array(), to_weights.as_array());
    let pairs = from.nrows().saturating_mul(to.nrows());
    let plan = by_size(py, pairs, || transport::transport_plan(from, from_weights, to, to_weights))?;
    Ok((plan.mean_angle, plan.pairs.into_pyarray(py), plan.shares.into_pyarray(py)))
}

/// Column of each row in the assignment with the least sum of costs, for a square table.
#[pyfunction]
pub fn assignment<'py>(
    py: Python<'py>,
    costs: PyReadonlyArray2<'py, f64>,
) -> PyResult<Bound<'py, PyArray1<i64>>> {
    let costs = costs.as_array();
    Ok(by_size(py, costs.len(), || transport::assignment(costs))?.into_pyarray(py))
}
