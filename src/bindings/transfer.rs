//! `kernels::transfer` for Python.

use half::f16;
use numpy::{
    IntoPyArray, PyArray1, PyArray2, PyArray3, PyReadonlyArray1, PyReadonlyArray2, PyReadonlyArray3,
};
use pyo3::prelude::*;

use super::pool::interruptible;
use crate::kernels::transfer;

/// Inner products and the mask of texels that are not black.
type Gram<'py> = (Bound<'py, PyArray2<f64>>, Bound<'py, PyArray1<bool>>);

/// Stored values of a basis: bytes or halves.
#[derive(FromPyObject)]
pub enum Values<'py> {
    Bytes(PyReadonlyArray3<'py, i8>),
    Halves(PyReadonlyArray3<'py, f16>),
}

/// See `envlights.transfer.training.gram`.
#[pyfunction]
pub fn transfer_gram<'py>(
    py: Python<'py>,
    images: PyReadonlyArray3<'py, f32>,
    scale: PyReadonlyArray1<'py, f32>,
) -> PyResult<Gram<'py>> {
    let (images, scale) = (images.as_array(), scale.as_slice()?);
    let (products, non_black) = interruptible(py, || transfer::gram(images, scale))?;
    Ok((products.into_pyarray(py), non_black.into_pyarray(py)))
}

/// See `envlights.transfer.training.basis`.
#[pyfunction]
pub fn transfer_columns<'py>(
    py: Python<'py>,
    images: PyReadonlyArray3<'py, f32>,
    scale: PyReadonlyArray1<'py, f32>,
    non_black: PyReadonlyArray1<'py, bool>,
    weights: PyReadonlyArray2<'py, f32>,
) -> PyResult<Bound<'py, PyArray2<f32>>> {
    let (images, scale, non_black, weights) =
        (images.as_array(), scale.as_slice()?, non_black.as_slice()?, weights.as_array());
    let out = interruptible(py, || transfer::columns(images, scale, non_black, weights))?;
    Ok(out.into_pyarray(py))
}

/// See `envlights.transfer.compact`.
#[pyfunction]
pub fn transfer_frames<'py>(
    py: Python<'py>,
    values: Values<'py>,
    scales: PyReadonlyArray3<'py, f32>,
    coefficients: PyReadonlyArray3<'py, f32>,
    places: PyReadonlyArray1<'py, i64>,
) -> PyResult<Bound<'py, PyArray3<f32>>> {
    let (scales, coefficients, places) = (scales.as_array(), coefficients.as_array(), places.as_slice()?);
    let out = match &values {
        Values::Bytes(values) => {
            let values = values.as_array();
            interruptible(py, || transfer::frames(values, scales, coefficients, places))
        }
        Values::Halves(values) => {
            let values = values.as_array();
            interruptible(py, || transfer::frames(values, scales, coefficients, places))
        }
    }?;
    Ok(out.into_pyarray(py))
}
