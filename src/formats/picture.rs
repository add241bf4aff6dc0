//! Picture files: one way to the samples of all formats.

use std::ops::Range;

use half::f16;
use ndarray::Array3;

use super::header::Header;
use crate::error::Result;

/// A picture file in memory whose headers were read.
pub trait PictureFile: Send + Sync {
    /// Statements about each of its images, in the order of the file; at least one.
    fn parts(&self) -> &[Header];

    /// Samples of some rows of an image, (rows, width, channels), of the channels with these numbers in this order.
    ///
    /// The samples have the type of the channels, or are floats if their types differ. Blocks are decoded on all
    /// threads, with the same bits for any number of them.
    ///
    /// # Errors
    ///
    /// If the bytes of these rows are damaged or incomplete, or there is no memory.
    fn read(&self, part: usize, channels: &[usize], rows: Range<usize>) -> Result<Samples>;
}

/// Samples in the type of the file, (rows, width, channels).
#[derive(Clone, Debug, PartialEq)]
pub enum Samples {
    /// Samples of up to 8 bits, scaled to 8.
    Bytes(Array3<u8>),
    /// Samples of 16 bits.
    Words(Array3<u16>),
    /// Half floats.
    Halves(Array3<f16>),
    /// Floats, and doubles that were rounded to floats.
    Floats(Array3<f32>),
}
