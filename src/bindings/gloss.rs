//! `kernels::gloss` for Python.

use numpy::{IntoPyArray, PyArray1};
use pyo3::prelude::*;

use super::pool::interruptible;
use crate::kernels::gloss::{self, GlossySurface};

/// See `envlights.kernels.gloss.spectrum`; without a base, of metal.
#[pyfunction]
pub fn gloss_spectrum(
    py: Python<'_>,
    roughness: f64,
    degree: usize,
    base: Option<f64>,
) -> PyResult<Bound<'_, PyArray1<f64>>> {
    let surface =
        base.map_or_else(|| GlossySurface::metal(roughness), |base| GlossySurface::plastic(roughness, base));
    let out = interruptible(py, || Ok(gloss::spectrum(&surface, degree)))?;
    Ok(out.into_pyarray(py))
}
