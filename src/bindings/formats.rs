//! `formats` for Python.

use std::sync::Arc;

use numpy::ndarray::ArrayViewMut3;
use numpy::{IntoPyArray, PyArray3, PyReadonlyArray3};
use pyo3::prelude::*;
use pyo3::pybacked::PyBackedBytes;
use pyo3::types::{PyBytes, PyTuple};

use super::error::EnvLightsError;
use super::output::fill;
use super::pool::interruptible;
use crate::formats::Rows;
use crate::formats::png::{self, Samples};
use crate::formats::radiance::{Radiance, write};

/// Bytes of a Python object, without a copy.
pub(super) struct Shared(Arc<PyBackedBytes>);

impl AsRef<[u8]> for Shared {
    fn as_ref(&self) -> &[u8] {
        &self.0
    }
}

/// Radiance picture in memory, with its lines found and not decoded.
#[pyclass(frozen, module = "envlights._native")]
pub struct RadianceFile {
    pub(super) picture: Radiance<Shared>,
}

#[pymethods]
impl RadianceFile {
    #[new]
    fn new(py: Python<'_>, data: Bound<'_, PyBytes>, max_pixels: usize) -> PyResult<Self> {
        let bytes = PyBackedBytes::from(data);
        let bytes = Arc::new(bytes);
        let picture = interruptible(py, || Radiance::open(Shared(bytes.clone()), max_pixels))?;
        Ok(Self { picture })
    }

    #[getter]
    fn height(&self) -> usize {
        self.picture.header().height
    }

    #[getter]
    fn width(&self) -> usize {
        self.picture.header().width
    }

    /// EXIF orientation, 1 to 8.
    #[getter]
    fn orientation(&self) -> u8 {
        self.picture.header().orientation
    }

    #[getter]
    fn is_xyz(&self) -> bool {
        self.picture.header().is_xyz
    }

    /// Divisor of the samples of each channel.
    #[getter]
    fn exposure(&self) -> (f64, f64, f64) {
        self.picture.header().exposure.into()
    }

    /// The x and y of red, green, blue and white, if the file gives them.
    #[getter]
    fn primaries<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyTuple>>> {
        self.picture.header().primaries.map(|numbers| PyTuple::new(py, numbers)).transpose()
    }

    /// All samples, (height, width, 3), in the order of the file.
    fn read<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray3<f32>>> {
        self.rows(py, 0, self.picture.size().0)
    }

    /// Samples of the rows from `top` to `bottom`, (bottom - top, width, 3).
    fn rows<'py>(&self, py: Python<'py>, top: usize, bottom: usize) -> PyResult<Bound<'py, PyArray3<f32>>> {
        let height = self.picture.size().0;
        if top > bottom || bottom > height {
            return Err(EnvLightsError::new_err(format!(
                "rows must be from 0 to {height}, the first one first; got {top} to {bottom}"
            )));
        }
        let shape = [bottom - top, self.picture.size().1, 3];
        let read = |mut out: ArrayViewMut3<'_, f32>| {
            self.picture.read(top..bottom, out.as_slice_mut().unwrap_or_default())
        };
        Ok(fill(py, shape, read)?.0)
    }
}

/// PNG file in memory, with its header read.
#[pyclass(frozen, module = "envlights._native")]
pub struct PngFile {
    bytes: PyBackedBytes,
    header: png::Header,
    max_pixels: usize,
}

#[pymethods]
impl PngFile {
    #[new]
    fn new(py: Python<'_>, data: Bound<'_, PyBytes>, max_pixels: usize) -> PyResult<Self> {
        let bytes = PyBackedBytes::from(data);
        let header = interruptible(py, || png::header(&bytes, max_pixels))?;
        Ok(Self { bytes, header, max_pixels })
    }

    #[getter]
    fn height(&self) -> usize {
        self.header.height
    }

    #[getter]
    fn width(&self) -> usize {
        self.header.width
    }

    /// Samples of a pixel, 1 to 4; the last of 2 or 4 is alpha.
    #[getter]
    fn channels(&self) -> usize {
        self.header.channels
    }

    #[getter]
    fn is_16_bit(&self) -> bool {
        self.header.is_16_bit
    }

    /// Primaries, transfer function, matrix and full range of the chunk cICP.
    #[getter]
    fn cicp(&self) -> Option<(u8, u8, u8, u8)> {
        self.header.cicp.map(Into::into)
    }

    /// ICC profile; empty without one.
    #[getter]
    fn icc<'py>(&self, py: Python<'py>) -> Bound<'py, PyBytes> {
        PyBytes::new(py, &self.header.icc)
    }

    #[getter]
    fn is_srgb(&self) -> bool {
        self.header.is_srgb
    }

    /// Exponent of the chunk gAMA, such as 0.45455.
    #[getter]
    fn gamma(&self) -> Option<f64> {
        self.header.gamma
    }

    /// The x and y of red, green, blue and white, of the chunk cHRM.
    #[getter]
    fn chromaticities<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyTuple>>> {
        self.header.chromaticities.map(|numbers| PyTuple::new(py, numbers)).transpose()
    }

    /// EXIF orientation, 1 to 8.
    #[getter]
    fn orientation(&self) -> u8 {
        self.header.orientation
    }

    /// XMP packet; empty without one.
    #[getter]
    fn xmp<'py>(&self, py: Python<'py>) -> Bound<'py, PyBytes> {
        PyBytes::new(py, &self.header.xmp)
    }

    /// True for an animation; its first image is read.
    #[getter]
    fn is_animated(&self) -> bool {
        self.header.is_animated
    }

    /// All samples in the type of the file, (height, width, channels).
    fn read<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        Ok(match interruptible(py, || png::samples(&self.bytes, self.max_pixels))? {
            Samples::Eight(samples) => samples.into_pyarray(py).into_any(),
            Samples::Sixteen(samples) => samples.into_pyarray(py).into_any(),
        })
    }
}

/// See `envlights.environment.files.image_output`: bytes of some rows of a Radiance picture.
#[pyfunction]
pub fn radiance_rows<'py>(
    py: Python<'py>,
    radiance: PyReadonlyArray3<'py, f32>,
    rounds: bool,
) -> PyResult<Bound<'py, PyBytes>> {
    let radiance = radiance.as_array();
    let bytes = interruptible(py, || Ok(write::encode(radiance, rounds)))?;
    Ok(PyBytes::new(py, &bytes))
}
