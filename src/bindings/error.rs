//! Refusals of the kernels, as Python's exception.

use pyo3::exceptions::{PyMemoryError, PyValueError};
use pyo3::{PyErr, create_exception};

use crate::error::Error;

create_exception!(
    envlights,
    EnvLightsError,
    PyValueError,
    "An input that the package refuses. A `ValueError`, so old code catches it too."
);

create_exception!(
    envlights._native,
    UnusableSamplesError,
    EnvLightsError,
    "A map with samples that no light can have. Cleaning it helps."
);

create_exception!(
    envlights._native,
    DamagedBytesError,
    EnvLightsError,
    "Bytes of a file that contradict its format."
);

impl From<Error> for PyErr {
    fn from(error: Error) -> Self {
        let message = error.to_string();
        match error {
            Error::UnusableSamples { .. } => UnusableSamplesError::new_err(message),
            Error::DamagedFile { .. } => DamagedBytesError::new_err(message),
            // Raise the exception that NumPy raises for its arrays.
            Error::NoMemory { .. } => PyMemoryError::new_err(message),
            _ => EnvLightsError::new_err(message),
        }
    }
}
