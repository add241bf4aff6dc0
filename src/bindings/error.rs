//! Refusals of the kernels, as Python's exception.

use pyo3::exceptions::PyValueError;
use pyo3::{PyErr, create_exception};

use crate::error::Error;

create_exception!(
    envlights,
    EnvLightsError,
    PyValueError,
    "An input that the package refuses. A `ValueError`, so old code catches it too."
);

impl From<Error> for PyErr {
    fn from(error: Error) -> Self {
        EnvLightsError::new_err(error.to_string())
    }
}
