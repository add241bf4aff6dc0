//! Reduced maps for Python: from an array, or from rows that arrive in order.

use std::ops::Range;
use std::sync::{Arc, OnceLock};

use numpy::{PyArray1, PyReadonlyArray1, PyReadonlyArray3};
use pyo3::prelude::*;

use super::formats::RadianceFile;
use super::pool::interruptible;
use super::sphere::registration;
use crate::error::{Error, Result};
use crate::formats::Rows;
use crate::kernels::fit::Picture;
use crate::kernels::image::{self, PixelRows, ReductionOptions, RowReducer, Sample, WorkingMap};
use crate::kernels::sphere::Registration;

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
    /// True if the map is a picture of two discs in black squares.
    #[getter]
    fn has_two_discs(&self) -> bool {
        self.map.has_two_discs
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

/// Rows of a file that are decoded when they are needed.
struct FileRows<'a, File>(&'a File);

impl<File: Rows> PixelRows for FileRows<'_, File> {
    fn size(&self) -> (usize, usize) {
        self.0.size()
    }

    fn samples<'a>(&'a self, rows: Range<usize>, buffer: &'a mut Vec<f32>) -> &'a [f32] {
        buffer.resize(3 * rows.len() * self.0.size().1, 0.0);
        if self.0.read(rows, buffer).is_err() {
            // Mark the rows as no radiance, so that the file is read as a whole, which says what is wrong.
            buffer.fill(f32::NAN);
        }
        buffer
    }

    fn check_samples(&self) -> Result<()> {
        Err(Error::UnusableSamples { row: 0, value: f32::NAN, nan: 1, infinite: 0, negative: 0 })
    }
}

/// See `envlights.fit`: reduce a Radiance picture without orientation and exposure.
#[pyfunction]
pub fn reduce_radiance(
    py: Python<'_>,
    file: &RadianceFile,
    columns: usize,
    source_fraction: f64,
    floor: bool,
) -> PyResult<ReducedMap> {
    interruptible(py, || {
        let rows = FileRows(&file.picture);
        let map = image::reduce_rows(&rows, Registration::CellCentred, columns, source_fraction, floor)?;
        Ok(ReducedMap::new(map, floor))
    })
}

/// Reducer of each type of sample.
enum Reducer {
    Bytes(RowReducer<u8>),
    Words(RowReducer<u16>),
    Floats(RowReducer<f32>),
}

/// Apply one expression to the reducer of any type.
macro_rules! each {
    ($reducer:expr, $name:ident => $value:expr) => {
        match $reducer {
            Reducer::Bytes($name) => $value,
            Reducer::Words($name) => $value,
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
    /// No rows of a map of this size. The length of `table`, the linear value of each code, decides the type of the
    /// samples: 256 for uint8, 65536 for uint16, 0 for float32. `counts_codes` prepares `clipped` and `histogram`.
    #[new]
    fn new(
        size: (usize, usize, bool),
        cells: (usize, f64, bool),
        table: PyReadonlyArray1<'_, f32>,
        counts_codes: bool,
    ) -> PyResult<Self> {
        let (height, width, border_sampled) = size;
        let (columns, source_fraction, floor) = cells;
        let registration = registration(border_sampled);
        let options =
            ReductionOptions { height, width, registration, columns, source_fraction, has_floor: floor };
        let table = table.as_slice()?.to_vec();
        let reducer = match table.len() {
            0 => Reducer::Floats(RowReducer::new(options, table, counts_codes)?),
            256 => Reducer::Bytes(RowReducer::new(options, table, counts_codes)?),
            _ => Reducer::Words(RowReducer::new(options, table, counts_codes)?),
        };
        Ok(Self { reducer, floor })
    }

    /// Pixels along a cell; all additions but the last are a multiple of this number of rows.
    #[getter]
    fn block(&self) -> usize {
        each!(&self.reducer, reducer => reducer.block())
    }

    /// Bytes of the pixels that may be needed again.
    #[getter]
    fn retained_bytes(&self) -> usize {
        each!(&self.reducer, reducer => reducer.retained_bytes())
    }

    /// Number of negative samples, which count as 0.
    #[getter]
    fn negative(&self) -> usize {
        each!(&self.reducer, reducer => reducer.negative())
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

    /// Add the next rows, (rows, width, 3), C-contiguous; false if a sample is infinite or NaN.
    fn add(&mut self, py: Python<'_>, rows: &Bound<'_, PyAny>) -> PyResult<bool> {
        match &mut self.reducer {
            Reducer::Bytes(reducer) => add(py, reducer, rows.extract()?),
            Reducer::Words(reducer) => add(py, reducer, rows.extract()?),
            Reducer::Floats(reducer) => add(py, reducer, rows.extract()?),
        }
    }

    /// The reduced map; None if rows are missing, or a sample is no radiance.
    fn finish(&self, py: Python<'_>) -> PyResult<Option<ReducedMap>> {
        let map = interruptible(py, || Ok(each!(&self.reducer, reducer => reducer.finish())))?;
        Ok(map.map(|map| ReducedMap::new(map, self.floor)))
    }
}

fn add<T: Sample + numpy::Element>(
    py: Python<'_>,
    reducer: &mut RowReducer<T>,
    rows: PyReadonlyArray3<'_, T>,
) -> PyResult<bool> {
    let samples = rows.as_slice()?;
    // The integrals may be computed again after an interruption, so they are added afterwards.
    let integrals = interruptible(py, || reducer.integrals(samples))?;
    reducer.add(integrals, samples);
    Ok(reducer.is_usable())
}
