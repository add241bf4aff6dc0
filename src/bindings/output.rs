//! Large results of kernels, in memory of `NumPy`.

use std::sync::{Mutex, PoisonError};

use numpy::ndarray::ArrayViewMut3;
use numpy::{PyArray3, PyArrayMethods, PyReadwriteArray3};
use pyo3::prelude::*;

use super::pool::interruptible;
use crate::error::Result;

/// Array that `work` fills on all threads, and what `work` returns. It must write every sample.
///
/// `NumPy` asks for huge pages, with which the first write to 100 MB takes less than half the time.
pub fn fill<T: Send>(
    py: Python<'_>,
    shape: [usize; 3],
    work: impl Fn(ArrayViewMut3<'_, f32>) -> Result<T> + Send + Sync,
) -> PyResult<(Bound<'_, PyArray3<f32>>, T)> {
    let array = PyArray3::zeros(py, shape, false);
    let done = write_into(py, array.readwrite(), work)?;
    Ok((array, done))
}

/// Let `work` write every sample of `values` on all threads; return what it returns.
pub fn write_into<T: Send>(
    py: Python<'_>,
    mut values: PyReadwriteArray3<'_, f32>,
    work: impl Fn(ArrayViewMut3<'_, f32>) -> Result<T> + Send + Sync,
) -> PyResult<T> {
    let samples = Mutex::new(values.as_array_mut());
    interruptible(py, || {
        // An interrupted run poisons the lock; the next one writes all samples again.
        work(samples.lock().unwrap_or_else(PoisonError::into_inner).view_mut())
    })
}
