//! One picture of a JPEG file: its frame, and its samples.

use std::ops::Range;
use std::sync::OnceLock;

use ndarray::Array3;

use super::frame::Frame;
use super::metadata::Metadata;
use super::planes::{Model, Planes};
use super::scan;
use crate::error::Result;
use crate::formats::picture::array;

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
        let mut samples = array((rows.len(), self.frame.width, self.model.channels()))?;
        self.write(bytes, rows.start, samples.as_slice_mut().unwrap_or_default())?;
        Ok(samples)
    }

    /// Write the samples of rows from `first` on into `out`.
    pub fn write(&self, bytes: &[u8], first: usize, out: &mut [u8]) -> Result<()> {
        self.planes(bytes)?.write_rows(self.model, first, out);
        Ok(())
    }
}
