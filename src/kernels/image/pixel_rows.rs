//! Rows of a map that are decoded when a kernel needs them.

use std::ops::Range;

use ndarray::{ArrayView3, s};

use super::samples::check_samples;
use crate::error::Result;

/// Rows of a map that can be decoded in any order, more than once.
pub trait PixelRows: Sync {
    /// Rows and columns.
    fn size(&self) -> (usize, usize);

    /// Linear RGB of some rows, row after row, in `buffer` unless it is in memory already.
    fn samples<'a>(&'a self, rows: Range<usize>, buffer: &'a mut Vec<f32>) -> &'a [f32];

    /// Refusal of samples that are no radiance, after a sum or a sign has indicated one.
    ///
    /// # Errors
    ///
    /// [`crate::error::Error::UnusableSamples`].
    fn check_samples(&self) -> Result<()>;
}

impl PixelRows for ArrayView3<'_, f32> {
    fn size(&self) -> (usize, usize) {
        (self.dim().0, self.dim().1)
    }

    fn samples<'a>(&'a self, rows: Range<usize>, buffer: &'a mut Vec<f32>) -> &'a [f32] {
        let part = self.slice_move(s![rows, .., ..]);
        if let Some(samples) = part.to_slice() {
            return samples;
        }
        buffer.clear();
        buffer.extend(part.iter());
        buffer
    }

    fn check_samples(&self) -> Result<()> {
        check_samples(*self)
    }
}
