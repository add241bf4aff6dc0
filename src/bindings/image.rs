//! `kernels::image` for Python.

use half::f16;
use numpy::{
    Element, IntoPyArray, PyArray1, PyArray3, PyReadonlyArray1, PyReadonlyArray2, PyReadonlyArray3,
    PyReadwriteArray3,
};
use pyo3::prelude::*;

use super::output::{fill, write_into};
use super::pool::interruptible;
use super::sphere::registration;
use crate::error::Error;
use crate::kernels::image::{self, Cleaning, Sample, Unusable};

/// Numbers of NaN, infinite and negative samples, the level of infinite ones, and true for a NaN in the brightest light.
pub type CleaningCounts = (usize, usize, usize, Option<f64>, bool);

/// `cleaning` for Python.
pub fn counts_of(cleaning: &Cleaning) -> CleaningCounts {
    let Unusable { nan, infinite, negative, .. } = cleaning.unusable;
    (nan, infinite, negative, cleaning.level, cleaning.is_nan_bright)
}

/// See `envlights.environment.clean`: usable samples and what was replaced; None if all samples are usable.
#[pyfunction]
pub fn clean<'py>(
    py: Python<'py>,
    radiance: PyReadonlyArray3<'py, f32>,
    wraps: bool,
) -> PyResult<Option<(Bound<'py, PyArray3<f32>>, CleaningCounts)>> {
    let radiance = radiance.as_array();
    let unusable = interruptible(py, || image::unusable(radiance))?;
    if unusable.nan + unusable.infinite + unusable.negative == 0 {
        return Ok(None);
    }
    let (samples, cleaning) = fill(py, radiance.dim().into(), |samples| {
        let mut cleaning = Cleaning::of(unusable)?;
        cleaning.apply(radiance, wraps, samples)?;
        Ok(cleaning)
    })?;
    Ok(Some((samples, counts_of(&cleaning))))
}

/// See `envlights.environment.open`: means over the blocks of a map reduced to `columns`.
#[pyfunction]
pub fn overview<'py>(
    py: Python<'py>,
    radiance: PyReadonlyArray3<'py, f32>,
    border_sampled: bool,
    columns: usize,
) -> PyResult<Bound<'py, PyArray3<f32>>> {
    let radiance = radiance.as_array();
    let cells = interruptible(py, || image::overview(radiance, registration(border_sampled), columns))?;
    Ok(cells.into_pyarray(py))
}

/// See `envlights._common.srgb.look_up`: values of 8-bit codes by one table, or by one for each channel, in `values`.
#[pyfunction]
pub fn decode_8(
    py: Python<'_>,
    codes: PyReadonlyArray3<'_, u8>,
    tables: PyReadonlyArray2<'_, f32>,
    values: PyReadwriteArray3<'_, f32>,
) -> PyResult<()> {
    decode(py, codes, tables, values)
}

/// See `envlights._common.srgb.look_up`: values of 16-bit codes by one table, or by one for each channel, in `values`.
#[pyfunction]
pub fn decode_16(
    py: Python<'_>,
    codes: PyReadonlyArray3<'_, u16>,
    tables: PyReadonlyArray2<'_, f32>,
    values: PyReadwriteArray3<'_, f32>,
) -> PyResult<()> {
    decode(py, codes, tables, values)
}

fn decode<Code: Sample + Into<usize> + Element>(
    py: Python<'_>,
    codes: PyReadonlyArray3<'_, Code>,
    tables: PyReadonlyArray2<'_, f32>,
    values: PyReadwriteArray3<'_, f32>,
) -> PyResult<()> {
    let (codes, tables) = (codes.as_array(), tables.as_array());
    write_into(py, values, |values| image::decode(codes, tables, values))
}

/// See `envlights.environment.colour.linear`: half floats in single precision, in `values`.
#[pyfunction]
pub fn widen(
    py: Python<'_>,
    halves: PyReadonlyArray3<'_, f16>,
    values: PyReadwriteArray3<'_, f32>,
) -> PyResult<()> {
    let halves = halves.as_array();
    write_into(py, values, |values| image::widen(halves, values))
}

/// See `envlights.EnvMap`: converted colours of `image`, and the number of pixels outside Rec.709.
#[pyfunction]
pub fn apply_matrix<'py>(
    py: Python<'py>,
    image: PyReadonlyArray3<'py, f32>,
    matrix: [[f32; 3]; 3],
) -> PyResult<(Bound<'py, PyArray3<f32>>, usize)> {
    let image = image.as_array();
    fill(py, image.dim().into(), |converted| image::apply_matrix(image, &matrix, converted))
}

/// Clip level of a picture as one of 256 codes, from the solid angle of each code of the largest channel.
#[pyfunction]
pub fn white_code(histogram: PyReadonlyArray1<'_, f64>) -> PyResult<Option<usize>> {
    let sums = histogram.as_slice()?;
    let sums = sums.try_into().map_err(|_| Error::WrongShape {
        what: "histogram",
        wanted: "(256,)",
        shape: vec![sums.len()],
    })?;
    Ok(image::white_of(sums))
}

/// Weights of rows, summed over pixels by the code of their largest channel, for 8 bits.
#[pyfunction]
pub fn code_histogram_8<'py>(
    py: Python<'py>,
    codes: PyReadonlyArray3<'py, u8>,
    weights: PyReadonlyArray1<'py, f64>,
) -> PyResult<Bound<'py, PyArray1<f64>>> {
    code_histogram(py, codes, weights)
}

/// Weights of rows, summed over pixels by the code of their largest channel, for 16 bits.
#[pyfunction]
pub fn code_histogram_16<'py>(
    py: Python<'py>,
    codes: PyReadonlyArray3<'py, u16>,
    weights: PyReadonlyArray1<'py, f64>,
) -> PyResult<Bound<'py, PyArray1<f64>>> {
    code_histogram(py, codes, weights)
}

fn code_histogram<'py, Code: Sample + Element>(
    py: Python<'py>,
    codes: PyReadonlyArray3<'py, Code>,
    weights: PyReadonlyArray1<'py, f64>,
) -> PyResult<Bound<'py, PyArray1<f64>>> {
    let (codes, weights) = (codes.as_array(), weights.as_array());
    let sums = interruptible(py, || Ok(image::code_histogram(codes, weights)))?;
    Ok(PyArray1::from_slice(py, &sums))
}

/// Samples in single or in double precision.
#[derive(FromPyObject)]
pub enum Floats<'py> {
    Single(PyReadonlyArray3<'py, f32>),
    Double(PyReadonlyArray3<'py, f64>),
}

/// See `envlights.kernels.area_means`.
#[pyfunction]
pub fn area_means<'py>(
    py: Python<'py>,
    image: Floats<'py>,
    rows: usize,
    columns: usize,
) -> PyResult<Bound<'py, PyArray3<f64>>> {
    let out = match image {
        Floats::Single(image) => {
            let image = image.as_array();
            interruptible(py, || image::area_means(image, rows, columns))
        }
        Floats::Double(image) => {
            let image = image.as_array();
            interruptible(py, || image::area_means(image, rows, columns))
        }
    };
    Ok(out?.into_pyarray(py))
}
