//! Large results of kernels, in memory of `NumPy`.

use std::sync::{Mutex, PoisonError};

use numpy::ndarray::ArrayViewMut3;
use numpy::{Element, PyArray3, PyArrayMethods, PyReadwriteArray3, dtype};
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
    let array = zeros(py, shape)?;
    let done = write_into(py, array.readwrite(), work)?;
    Ok((array, done))
}

/// Zeros of `NumPy`, or its `MemoryError`.
pub fn zeros<S: Element>(py: Python<'_>, shape: [usize; 3]) -> PyResult<Bound<'_, PyArray3<S>>> {
    // `PyArray3::zeros` would panic without memory.
    let array = py.import("numpy")?.call_method1("zeros", (shape, dtype::<S>(py)))?;
    Ok(array.cast_into()?)
}

/// Let `work` write every sample of `values` on all threads; return what it returns.
pub fn write_into<S: Element + Send, T: Send>(
    py: Python<'_>,
    mut values: PyReadwriteArray3<'_, S>,
    work: impl Fn(ArrayViewMut3<'_, S>) -> Result<T> + Send + Sync,
) -> PyResult<T> {
    let samples = Mutex::new(values.as_array_mut());
    interruptible(py, || {
        // An interrupted run poisons the lock; the next one writes all samples again.
        work(samples.lock().unwrap_or_else(PoisonError::into_inner).view_mut())
    })
}
