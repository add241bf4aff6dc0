//! `formats` for Python.

use std::ops::Range;
use std::sync::{Arc, Mutex, PoisonError};

use half::f16;
use numpy::{Element, PyArrayMethods, PyReadonlyArray3, PyReadwriteArray3};
use pyo3::prelude::*;
use pyo3::pybacked::PyBackedBytes;
use pyo3::types::{PyBytes, PyDict, PyTuple};

use super::error::EnvLightsError;
use super::output::{write_into, zeros};
use super::pool::{in_pool, interruptible};
use crate::formats::header::{Alpha, Header, SampleType};
use crate::formats::picture::SamplesMut;
use crate::formats::radiance::write;
use crate::formats::{self, exr, gain_map, picture, png, tiff};

/// Bytes of a Python object, without a copy.
#[derive(Clone)]
struct Shared(Arc<PyBackedBytes>);

impl AsRef<[u8]> for Shared {
    fn as_ref(&self) -> &[u8] {
        &self.0
    }
}

/// A picture file in memory, with its headers read.
#[pyclass(frozen, module = "envlights._native")]
pub struct PictureFile {
    file: Box<dyn picture::PictureFile>,
}

#[pymethods]
impl PictureFile {
    /// File of a `kind` of `envlights.environment.decoders.source`.
    #[new]
    fn new(py: Python<'_>, data: Bound<'_, PyBytes>, kind: &str, max_pixels: usize) -> PyResult<Self> {
        let bytes = Shared(Arc::new(PyBackedBytes::from(data)));
        let file = interruptible(py, || formats::open(kind, bytes.clone(), max_pixels))?;
        Ok(Self { file })
    }

    /// Statements about each image, by the names of `formats::header`.
    #[getter]
    fn parts<'py>(&self, py: Python<'py>) -> PyResult<Vec<Bound<'py, PyDict>>> {
        self.file.parts().iter().map(|header| dictionary(py, header)).collect()
    }

    /// Raise linear values in place by the gain map of the first part, if it has one.
    ///
    /// `values` are those of some rows from `top` on, (rows, width, 1 or 3).
    fn apply_gain_map(
        &self,
        py: Python<'_>,
        mut values: PyReadwriteArray3<'_, f32>,
        top: usize,
    ) -> PyResult<()> {
        let header = &self.file.parts()[0];
        let Some(map) = &header.gain_map else { return Ok(()) };
        let values = Mutex::new(values.as_array_mut());
        in_pool(py, || {
            // Nothing interrupts this run, so it is not repeated.
            let mut values = values.lock().unwrap_or_else(PoisonError::into_inner);
            gain_map::apply(map, values.view_mut(), top, header.height);
            Ok(())
        })
    }

    /// Samples of rows from `top` to `bottom` in the type of the file, (bottom - top, width, channels), of the channels
    /// with these numbers.
    fn rows<'py>(
        &self,
        py: Python<'py>,
        part: usize,
        channels: Vec<usize>,
        top: usize,
        bottom: usize,
    ) -> PyResult<Bound<'py, PyAny>> {
        let rows = self.checked_rows(part, &channels, top, bottom)?;
        let request = Request { file: &*self.file, part, channels: &channels, rows };
        match self.file.parts()[part].sample_type(&channels) {
            SampleType::U8 => request.read::<u8>(py),
            SampleType::U16 => request.read::<u16>(py),
            SampleType::F16 => request.read::<f16>(py),
            SampleType::F32 => request.read::<f32>(py),
        }
    }
}

/// Samples of a file that are to be read.
struct Request<'a> {
    file: &'a dyn picture::PictureFile,
    part: usize,
    channels: &'a [usize],
    rows: Range<usize>,
}

impl Request<'_> {
    /// Array of `NumPy` with the samples.
    fn read<'py, T: Element + Send>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>>
    where
        for<'a> SamplesMut<'a>: From<&'a mut [T]>,
    {
        let width = self.file.parts()[self.part].width;
        let array = zeros::<T>(py, [self.rows.len(), width, self.channels.len()])?;
        write_into(py, array.readwrite(), |mut samples| {
            let out = samples.as_slice_mut().unwrap_or_default();
            self.file.read(self.part, self.channels, self.rows.clone(), out.into())
        })?;
        Ok(array.into_any())
    }
}

impl PictureFile {
    /// The rows from `top` to `bottom`, or a refusal of numbers that the file does not have.
    fn checked_rows(
        &self,
        part: usize,
        channels: &[usize],
        top: usize,
        bottom: usize,
    ) -> PyResult<Range<usize>> {
        let parts = self.file.parts();
        let Some(header) = parts.get(part) else {
            let count = parts.len();
            return Err(EnvLightsError::new_err(format!("part must be below {count}; got {part}")));
        };
        let (height, count) = (header.height, header.channels.len());
        if let Some(channel) = channels.iter().find(|&&channel| channel >= count) {
            return Err(EnvLightsError::new_err(format!("channels must be below {count}; got {channel}")));
        }
        if top > bottom || bottom > height {
            return Err(EnvLightsError::new_err(format!(
                "rows must be from 0 to {height}, the first one first; got {top} to {bottom}"
            )));
        }
        Ok(top..bottom)
    }
}

fn dictionary<'py>(py: Python<'py>, header: &Header) -> PyResult<Bound<'py, PyDict>> {
    let said = PyDict::new(py);
    let channels = header.channels.iter().map(|channel| (&*channel.name, type_name(channel.sample)));
    said.set_item("kind", header.kind)?;
    said.set_item("name", &header.name)?;
    said.set_item("view", &header.view)?;
    said.set_item("height", header.height)?;
    said.set_item("width", header.width)?;
    said.set_item("channels", channels.collect::<Vec<_>>())?;
    said.set_item("alpha", alpha_name(header.alpha))?;
    said.set_item("block", header.block)?;
    said.set_item("colour", colour(py, header)?)?;
    said.set_item("orientation", header.orientation)?;
    said.set_item("data_window", header.data_window)?;
    said.set_item("display_window", header.display_window)?;
    said.set_item("exposure", <(f64, f64, f64)>::from(header.exposure))?;
    said.set_item("white_luminance", header.white_luminance)?;
    said.set_item("environment", header.environment)?;
    said.set_item("border_sampled", header.border_sampled)?;
    said.set_item("exif", &header.exif)?;
    let packets: Vec<_> = header.xmp.iter().map(|packet| PyBytes::new(py, packet)).collect();
    said.set_item("xmp", PyTuple::new(py, packets)?)?;
    said.set_item("has_gain_map", header.gain_map.is_some())?;
    said.set_item("description", &header.description)?;
    said.set_item("notes", &header.notes)?;
    Ok(said)
}

fn colour<'py>(py: Python<'py>, header: &Header) -> PyResult<Bound<'py, PyDict>> {
    let (said, colour) = (PyDict::new(py), &header.colour);
    said.set_item("cicp", colour.cicp.map(<(u8, u8, u8, u8)>::from))?;
    said.set_item("icc", PyBytes::new(py, &colour.icc))?;
    said.set_item("is_srgb", colour.is_srgb)?;
    said.set_item("gamma", colour.gamma)?;
    said.set_item(
        "chromaticities",
        colour.chromaticities.map(<(f64, f64, f64, f64, f64, f64, f64, f64)>::from),
    )?;
    said.set_item("is_xyz", colour.is_xyz)?;
    said.set_item("name", &colour.name)?;
    Ok(said)
}

/// Name of a type in `NumPy`.
fn type_name(sample: SampleType) -> &'static str {
    match sample {
        SampleType::U8 => "uint8",
        SampleType::U16 => "uint16",
        SampleType::F16 => "float16",
        SampleType::F32 => "float32",
    }
}

fn alpha_name(alpha: Alpha) -> &'static str {
    match alpha {
        Alpha::None => "none",
        Alpha::Straight => "straight",
        Alpha::Premultiplied => "premultiplied",
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

/// Chromaticities, luminance of white, environment attribute and comments of an OpenEXR file.
type Statements = ([f32; 8], Option<f32>, String, String);

/// See `envlights.environment.files.image_output`: an OpenEXR file of RGB or grey, perhaps with alpha.
#[pyfunction]
pub fn exr_file<'py>(
    py: Python<'py>,
    radiance: PyReadonlyArray3<'py, f32>,
    half: bool,
    compression: &str,
    statements: Statements,
) -> PyResult<Bound<'py, PyBytes>> {
    let radiance = radiance.as_array();
    let names: &[&str] = match radiance.dim().2 {
        1 => &["Y"],
        2 => &["Y", "A"],
        3 => &["R", "G", "B"],
        _ => &["R", "G", "B", "A"],
    };
    let known = exr::write::COMPRESSIONS.iter().find(|(name, _)| *name == compression);
    let (chromaticities, white_luminance, environment, comments) = statements;
    let options = exr::write::Options {
        channels: names,
        is_half: half,
        compression: known.unwrap_or(&exr::write::COMPRESSIONS[0]).1,
        chromaticities: Some(chromaticities),
        white_luminance,
        environment: &environment,
        comments: &comments,
    };
    let bytes = interruptible(py, || exr::write::write(radiance, &options))?;
    Ok(PyBytes::new(py, &bytes))
}

/// Codes of a picture in either type.
#[derive(FromPyObject)]
pub enum Codes<'py> {
    Bytes(PyReadonlyArray3<'py, u8>),
    Words(PyReadonlyArray3<'py, u16>),
}

/// See `envlights.environment.files.image_output`: a PNG file of sRGB codes.
#[pyfunction]
pub fn png_file<'py>(py: Python<'py>, codes: Codes<'py>, description: &str) -> PyResult<Bound<'py, PyBytes>> {
    let bytes = match &codes {
        Codes::Bytes(codes) => {
            let codes = codes.as_array();
            interruptible(py, || Ok(png::write::encode_8(codes, description)))
        }
        Codes::Words(codes) => {
            let codes = codes.as_array();
            interruptible(py, || Ok(png::write::encode_16(codes, description)))
        }
    };
    Ok(PyBytes::new(py, &bytes?))
}

/// See `envlights.environment.files.image_output`: a TIFF file of floats.
#[pyfunction]
pub fn tiff_file<'py>(
    py: Python<'py>,
    radiance: PyReadonlyArray3<'py, f32>,
    description: &str,
) -> PyResult<Bound<'py, PyBytes>> {
    let radiance = radiance.as_array();
    let bytes = interruptible(py, || Ok(tiff::write::encode(radiance, description)))?;
    Ok(PyBytes::new(py, &bytes))
}
