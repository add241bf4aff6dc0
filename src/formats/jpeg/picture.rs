//! One picture of a JPEG file: its frame, and its samples.

use std::ops::Range;
use std::sync::OnceLock;

use ndarray::Array3;

use super::frame::Frame;
use super::metadata::Metadata;
use super::planes::{Model, Planes};
use super::scan;
use crate::error::{Error, Result};
use crate::formats::input::{damage, zeros};

/// One of the pictures in a file; its samples are decoded when they are first read, and kept.
#[derive(Debug)]
pub(super) struct Picture {
    /// Position in the file.
    start: usize,
    pub frame: Frame,
    pub model: Model,
    planes: OnceLock<Planes>,
}

impl Picture {
    pub fn new(start: usize, frame: Frame, metadata: &Metadata<'_>) -> Self {
        let model = metadata.model(&frame);
        Self { start, frame, model, planes: OnceLock::new() }
    }

    /// Samples of the components; decoded once.
    fn planes(&self, bytes: &[u8]) -> Result<&Planes> {
        if let Some(planes) = self.planes.get() {
            return Ok(planes);
        }
        let planes = scan::decode(bytes, self.start, &self.frame)?;
        Ok(self.planes.get_or_init(|| planes))
    }

    /// Samples of some `rows`.
    pub fn samples(&self, bytes: &[u8], rows: Range<usize>) -> Result<Array3<u8>> {
        if rows.end > self.frame.height || rows.start > rows.end {
            return Err(damage(format!("the picture has {} rows; got {rows:?}", self.frame.height)));
        }
        let planes = self.planes(bytes)?;
        let shape = (rows.len(), self.frame.width, self.model.channels());
        let mut samples = zeros(shape, shape.0 * shape.1 * shape.2)?;
        planes.write_rows(self.model, rows.start, &mut samples);
        Array3::from_shape_vec(shape, samples)
            .map_err(|_| Error::NoMemory { shape: vec![shape.0, shape.1, shape.2] })
    }
}
