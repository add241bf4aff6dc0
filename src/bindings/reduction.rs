//! Reduced maps for Python: from an array, or from rows that arrive in order.

use std::sync::{Arc, OnceLock};

use half::f16;
use numpy::{PyArray1, PyArray3, PyReadonlyArray1, PyReadonlyArray3};
use pyo3::prelude::*;

use super::image::{CleaningCounts, counts_of};
use super::pool::interruptible;
use super::sphere::registration;
use crate::kernels::fit::Picture;
use crate::kernels::image::{self, ReductionOptions, RowReducer, RowReduction, Sample, WorkingMap};

/// A map in fewer cells, for fits.
#[pyclass(frozen)]
pub struct ReducedMap {
    pub map: WorkingMap,
    /// True if light from below the horizon is left out.
    #[pyo3(get)]
    pub floor: bool,
    picture: OnceLock<Arc<Picture>>,
}

impl ReducedMap {
    fn new(map: WorkingMap, floor: bool) -> Self {
        Self { map, floor, picture: OnceLock::new() }
    }

    /// The map in harmonics, computed once for all fits to it.
    pub fn picture(&self) -> Arc<Picture> {
        // Two threads may both compute it: one that waits for the other could wait for itself.
        let new = || {
            let picture = Arc::new(Picture::new(&self.map));
            self.picture.set(picture.clone()).unwrap_or_default(); // the same numbers, if another was faster
            picture
        };
        self.picture.get().cloned().unwrap_or_else(new)
    }
}

#[pymethods]
impl ReducedMap {
    /// Mean radiance of each cell, (rows, columns, 3).
    #[getter]
    fn overview<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray3<f32>> {
        PyArray3::from_array(py, &self.map.overview)
    }
}

/// See `envlights.fit`: reduce a map in memory.
#[pyfunction]
pub fn reduce_map(
    py: Python<'_>,
    radiance: PyReadonlyArray3<'_, f32>,
    border_sampled: bool,
    columns: usize,
    source_fraction: f64,
    floor: bool,
) -> PyResult<ReducedMap> {
    let radiance = radiance.as_array();
    interruptible(py, || {
        let map = image::reduce(radiance, registration(border_sampled), columns, source_fraction, floor)?;
        Ok(ReducedMap::new(map, floor))
    })
}

/// Reducer of each type of sample.
enum Reducer {
    Bytes(RowReducer<u8>),
    Words(RowReducer<u16>),
    Halves(RowReducer<f16>),
    Floats(RowReducer<f32>),
}

/// Apply one expression to the reducer of any type.
macro_rules! each {
    ($reducer:expr, $name:ident => $value:expr) => {
        match $reducer {
            Reducer::Bytes($name) => $value,
            Reducer::Words($name) => $value,
            Reducer::Halves($name) => $value,
            Reducer::Floats($name) => $value,
        }
    };
}

/// See `envlights.fit`: reduce the rows of a file in the order in which they are decoded.
#[pyclass(name = "RowReducer")]
pub struct PyRowReducer {
    reducer: Reducer,
    floor: bool,
}

#[pymethods]
impl PyRowReducer {
    /// No rows of a map of this size, with samples of a type of `NumPy`. `table` holds the linear value of each code and
    /// is empty for floating point.
    #[new]
    fn new(
        size: (usize, usize, bool),
        cells: (usize, f64, bool),
        sample: &str,
        table: PyReadonlyArray1<'_, f32>,
    ) -> PyResult<Self> {
        let (height, width, border_sampled) = size;
        let (columns, source_fraction, floor) = cells;
        let registration = registration(border_sampled);
        let options =
            ReductionOptions { height, width, registration, columns, source_fraction, has_floor: floor };
        let table = table.as_slice()?.to_vec();
        let reducer = match sample {
            "uint8" => Reducer::Bytes(RowReducer::new(options, table)?),
            "uint16" => Reducer::Words(RowReducer::new(options, table)?),
            "float16" => Reducer::Halves(RowReducer::new(options, table)?),
            _ => Reducer::Floats(RowReducer::new(options, table)?),
        };
        Ok(Self { reducer, floor })
    }

    /// Cell size in pixels; each `add` except the last must pass a multiple of this many rows.
    #[getter]
    fn block(&self) -> usize {
        each!(&self.reducer, reducer => reducer.block())
    }

    /// Bytes of the pixels that may be needed again.
    #[getter]
    fn retained_bytes(&self) -> usize {
        each!(&self.reducer, reducer => reducer.retained_bytes())
    }

    /// Fractions of the sphere and of the flux in pixels with a sample of at least this linear value; None if unknown.
    fn clipped(&self, value: f32) -> Option<[f64; 2]> {
        each!(&self.reducer, reducer => reducer.clipped(value))
    }

    /// Solid angle of each of 256 codes of the largest channel; codes below 214 are in the first one.
    #[getter]
    fn histogram<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, &each!(&self.reducer, reducer => reducer.histogram()))
    }

    /// Add the next rows, (rows, width, 3), C-contiguous.
    fn add(&mut self, py: Python<'_>, rows: &Bound<'_, PyAny>) -> PyResult<()> {
        match &mut self.reducer {
            Reducer::Bytes(reducer) => add(py, reducer, rows.extract()?),
            Reducer::Words(reducer) => add(py, reducer, rows.extract()?),
            Reducer::Halves(reducer) => add(py, reducer, rows.extract()?),
            Reducer::Floats(reducer) => add(py, reducer, rows.extract()?),
        }
    }

    /// The reduced map, what was replaced in it, and the fraction of the flux in infinite samples.
    fn finish(&self, py: Python<'_>) -> PyResult<(ReducedMap, CleaningCounts, f64)> {
        let RowReduction { map, cleaning, clipped_flux } =
            interruptible(py, || each!(&self.reducer, reducer => reducer.finish()))?;
        Ok((ReducedMap::new(map, self.floor), counts_of(&cleaning), clipped_flux))
    }
}

fn add<T: Sample + numpy::Element>(
    py: Python<'_>,
    reducer: &mut RowReducer<T>,
    rows: PyReadonlyArray3<'_, T>,
) -> PyResult<()> {
    let samples = rows.as_slice()?;
    // Add the integrals only when complete, because an interrupted call computes them again.
    let integrals = interruptible(py, || reducer.integrals(samples))?;
    reducer.add(integrals, samples);
    Ok(())
}
