//! Unusable samples of a map: values that no light can have.

use ndarray::ArrayView3;
use rayon::prelude::*;

use crate::error::{Error, Result};
use crate::interrupt;

/// Samples that no light can have.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Unusable {
    /// Not a number.
    pub nan: usize,
    /// Positive infinity.
    pub infinite: usize,
    /// Below zero, negative infinity among them.
    pub negative: usize,
    /// Largest finite sample.
    pub largest: Option<f32>,
}

/// Count the samples of `radiance` that are NaN, infinite or negative, and find the largest of the others.
///
/// The bits of a finite `f32` that is not negative, read as `i32`, lie in `0 ..= 0x7f7f_ffff`, in the order of their
/// values. So the least and the largest of a row find the rows whose samples must be checked one by one. (A -0.0 triggers
/// this check, too, and then counts as 0.)
///
/// # Errors
///
/// [`Error::NotAMap`] when the array is not (height, width, 3).
pub fn unusable(radiance: ArrayView3<'_, f32>) -> Result<Unusable> {
    check_rgb(radiance)?;
    let rows: Vec<Unusable> = radiance
        .outer_iter()
        .into_par_iter()
        .map(|row| {
            interrupt::check();
            match row.as_slice().and_then(largest_usable) {
                Some(largest) => Unusable { largest: Some(largest), ..Unusable::default() },
                None => Unusable::of(row),
            }
        })
        .collect();
    Ok(rows.into_iter().fold(Unusable::default(), Unusable::plus))
}

/// Largest of samples that are all usable.
pub(super) fn largest_usable(samples: &[f32]) -> Option<f32> {
    let bits = samples.iter().map(|sample| sample.to_bits().cast_signed());
    let (least, largest) =
        bits.fold((i32::MAX, 0), |(least, largest), bits| (least.min(bits), largest.max(bits)));
    let is_usable = least >= 0 && largest <= f32::MAX.to_bits().cast_signed();
    is_usable.then(|| f32::from_bits(largest.cast_unsigned()))
}

impl Unusable {
    /// Counts of these samples.
    pub(super) fn of<'a>(samples: impl IntoIterator<Item = &'a f32>) -> Self {
        samples.into_iter().fold(Self::default(), |counts, &value| counts.and(value))
    }

    fn and(mut self, value: f32) -> Self {
        self.nan += usize::from(value.is_nan());
        self.infinite += usize::from(value == f32::INFINITY);
        self.negative += usize::from(value < 0.0);
        if value.is_finite() {
            self.largest = larger(self.largest, Some(value));
        }
        self
    }

    pub(super) fn plus(self, other: Self) -> Self {
        Self {
            nan: self.nan + other.nan,
            infinite: self.infinite + other.infinite,
            negative: self.negative + other.negative,
            largest: larger(self.largest, other.largest),
        }
    }
}

fn larger(one: Option<f32>, other: Option<f32>) -> Option<f32> {
    one.into_iter().chain(other).reduce(f32::max)
}

/// Refuse samples that no light can have, and count them.
///
/// Callers use it after a sum or a sign has indicated such samples. The minus sign may be that of -0, which is valid.
pub(crate) fn check_samples(radiance: ArrayView3<'_, f32>) -> Result<()> {
    let Unusable { nan, infinite, negative, .. } = unusable(radiance)?;
    let is_unusable = |value: &&f32| !value.is_finite() || **value < 0.0;
    let mut first = radiance.outer_iter().map(|row| row.iter().find(is_unusable).copied()).enumerate();
    match first.find_map(|(row, value)| Some((row, value?))) {
        Some((row, value)) => Err(Error::UnusableSamples { row, value, nan, infinite, negative }),
        None => Ok(()),
    }
}

pub(crate) fn check_rgb(radiance: ArrayView3<'_, f32>) -> Result<()> {
    let (height, width, channels) = radiance.dim();
    if height < 2 || width < 2 || channels != 3 {
        return Err(Error::NotAMap { shape: radiance.shape().to_vec() });
    }
    Ok(())
}

/// Refuse rows of an image without three channels; they may be fewer than a map has.
pub(crate) fn check_channels<Sample>(rows: ArrayView3<'_, Sample>) -> Result<()> {
    if rows.dim().2 == 3 { Ok(()) } else { Err(Error::NotAMap { shape: rows.shape().to_vec() }) }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use ndarray::Array3;

    use super::*;

    #[test]
    fn each_kind_of_unusable_sample_is_counted() {
        let mut map = Array3::from_elem((5, 8, 3), 0.5_f32);
        map[[0, 0, 0]] = f32::NAN;
        map[[1, 2, 1]] = f32::INFINITY;
        map[[4, 7, 2]] = -1.0;
        map[[4, 6, 2]] = f32::NEG_INFINITY;
        map[[2, 0, 0]] = -0.0;
        assert_eq!(
            unusable(map.view()).unwrap(),
            Unusable { nan: 1, infinite: 1, negative: 2, largest: Some(0.5) }
        );
        let refusal = check_samples(map.slice(ndarray::s![1.., .., ..])).unwrap_err();
        let expected =
            Error::UnusableSamples { row: 0, value: f32::INFINITY, nan: 0, infinite: 1, negative: 2 };
        assert_eq!(refusal, expected);
        assert_eq!(check_samples(map.slice(ndarray::s![2..4, .., ..])), Ok(()));
    }
}
