//! Picture files: one way to the samples of all formats.

use std::ops::Range;

use std::sync::{Mutex, PoisonError};

use half::f16;
use ndarray::{Array3, ArrayView3, Axis, s};

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

/// Apply one expression to the samples of any type, and wrap its result.
macro_rules! each {
    ($samples:expr, $name:ident => $value:expr) => {
        match $samples {
            Samples::Bytes($name) => Samples::Bytes($value),
            Samples::Words($name) => Samples::Words($value),
            Samples::Halves($name) => Samples::Halves($value),
            Samples::Floats($name) => Samples::Floats($value),
        }
    };
}

impl Samples {
    /// Some rows of whole samples, of the channels with these numbers.
    #[must_use]
    pub fn part(&self, channels: &[usize], rows: Range<usize>) -> Self {
        each!(self, samples => select_channels(samples.slice(s![rows, .., ..]), channels))
    }
}

/// Samples of the channels with these numbers, in this order.
pub fn select_channels<T: Copy>(samples: ArrayView3<'_, T>, channels: &[usize]) -> Array3<T> {
    if channels.iter().copied().eq(0..samples.dim().2) {
        return samples.to_owned();
    }
    samples.select(Axis(2), channels)
}

/// Samples of a format that is decoded as a whole: at the first request, and kept.
#[derive(Debug, Default)]
pub struct WholeSamples(Mutex<Option<Samples>>);

impl WholeSamples {
    /// Some rows and channels of the samples that `decode` gives.
    ///
    /// # Errors
    ///
    /// Those of `decode`, which runs again at the next request.
    pub fn part(
        &self,
        channels: &[usize],
        rows: Range<usize>,
        decode: impl FnOnce() -> Result<Samples>,
    ) -> Result<Samples> {
        let mut samples = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if samples.is_none() {
            *samples = Some(decode()?);
        }
        Ok(samples
            .as_ref()
            .map_or_else(|| Samples::Bytes(Array3::default((0, 0, 0))), |all| all.part(channels, rows)))
    }
}
