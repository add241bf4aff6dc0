//! Picture files: one way to the samples of all formats.

use std::ops::Range;
use std::sync::{Mutex, PoisonError};

use half::f16;
use ndarray::{Array3, ArrayView3, Axis, s};

use super::header::{Header, SampleType};
use super::input::zeros;
use crate::error::{Error, Result};

/// A picture file in memory whose headers were read.
pub trait PictureFile: Send + Sync {
    /// Statements about each of its images, in the order of the file; at least one.
    fn parts(&self) -> &[Header];

    /// Write samples of some rows of an image into `out`, of the channels with these numbers in this order.
    ///
    /// `out` is (rows, width, channels), in the type that [`Header::sample_type`] gives. Blocks are decoded on all
    /// threads, with the same bits for any number of them.
    ///
    /// # Errors
    ///
    /// If the bytes of these rows are damaged or incomplete, there is no memory, or `out` is of another type.
    fn read(&self, part: usize, channels: &[usize], rows: Range<usize>, out: SamplesMut<'_>) -> Result<()>;

    /// Samples of some rows in new memory; see [`Self::read`].
    ///
    /// # Errors
    ///
    /// If the bytes of these rows are damaged or incomplete, or there is no memory.
    fn samples(&self, part: usize, channels: &[usize], rows: Range<usize>) -> Result<Samples> {
        let header = &self.parts()[part];
        let shape = (rows.len(), header.width, channels.len());
        let mut samples = Samples::zeros(header.sample_type(channels), shape)?;
        self.read(part, channels, rows, samples.as_mut())?;
        Ok(samples)
    }
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

/// Place for [`Samples`], row after row.
pub enum SamplesMut<'a> {
    /// Samples of up to 8 bits, scaled to 8.
    Bytes(&'a mut [u8]),
    /// Samples of 16 bits.
    Words(&'a mut [u16]),
    /// Half floats.
    Halves(&'a mut [f16]),
    /// Floats, and doubles that were rounded to floats.
    Floats(&'a mut [f32]),
}

/// A place for samples of one type.
macro_rules! place {
    ($kind:ident, $sample:ty) => {
        impl<'a> From<&'a mut [$sample]> for SamplesMut<'a> {
            fn from(samples: &'a mut [$sample]) -> Self {
                Self::$kind(samples)
            }
        }
    };
}

place!(Bytes, u8);
place!(Words, u16);
place!(Halves, f16);
place!(Floats, f32);

impl Samples {
    /// Zeros of a type.
    fn zeros(sample: SampleType, shape: (usize, usize, usize)) -> Result<Self> {
        Ok(match sample {
            SampleType::U8 => Self::Bytes(array(shape)?),
            SampleType::U16 => Self::Words(array(shape)?),
            SampleType::F16 => Self::Halves(array(shape)?),
            SampleType::F32 => Self::Floats(array(shape)?),
        })
    }

    fn as_mut(&mut self) -> SamplesMut<'_> {
        match self {
            Self::Bytes(samples) => samples.as_slice_mut().unwrap_or_default().into(),
            Self::Words(samples) => samples.as_slice_mut().unwrap_or_default().into(),
            Self::Halves(samples) => samples.as_slice_mut().unwrap_or_default().into(),
            Self::Floats(samples) => samples.as_slice_mut().unwrap_or_default().into(),
        }
    }
}

/// Zeros, or a refusal without memory.
pub(super) fn array<T: Clone + Default>(shape: (usize, usize, usize)) -> Result<Array3<T>> {
    let samples = zeros(shape, shape.0 * shape.1 * shape.2)?;
    Array3::from_shape_vec(shape, samples)
        .map_err(|_| Error::NoMemory { shape: vec![shape.0, shape.1, shape.2] })
}

/// Copy the channels with these numbers, in this order.
pub(super) fn copy_channels<T: Copy>(samples: ArrayView3<'_, T>, channels: &[usize], out: &mut [T]) {
    if let Some(samples) = samples.as_slice().filter(|_| channels.iter().copied().eq(0..samples.dim().2)) {
        out.copy_from_slice(samples);
        return;
    }
    for (pixel, out) in samples.lanes(Axis(2)).into_iter().zip(out.chunks_exact_mut(channels.len().max(1))) {
        out.iter_mut().zip(channels).for_each(|(out, &channel)| *out = pixel[channel]);
    }
}

/// Refusal of a place of another type than the samples.
pub(super) fn wrong_type() -> Error {
    Error::WrongShape {
        what: "out",
        wanted: "(rows, width, channels) in the type of the file",
        shape: vec![],
    }
}

/// Samples of a format that is decoded as a whole: at the first request, and kept.
#[derive(Debug, Default)]
pub struct WholeSamples(Mutex<Option<Samples>>);

impl WholeSamples {
    /// Copy some rows and channels of the samples into `out`; `decode` gives them until it succeeds once.
    ///
    /// # Errors
    ///
    /// If `decode` fails, or `out` is of another type.
    pub fn copy(
        &self,
        channels: &[usize],
        rows: Range<usize>,
        out: SamplesMut<'_>,
        decode: impl FnOnce() -> Result<Samples>,
    ) -> Result<()> {
        let mut kept = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let samples = match &mut *kept {
            Some(samples) => samples,
            empty => empty.insert(decode()?),
        };
        match (samples, out) {
            (Samples::Bytes(samples), SamplesMut::Bytes(out)) => {
                copy_channels(samples.slice(s![rows, .., ..]), channels, out);
            }
            (Samples::Words(samples), SamplesMut::Words(out)) => {
                copy_channels(samples.slice(s![rows, .., ..]), channels, out);
            }
            _ => return Err(wrong_type()),
        }
        Ok(())
    }
}
