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

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use ndarray::Array3;

    use super::super::{reduce, reduce_rows};
    use super::*;
    use crate::kernels::sphere::Registration;

    /// A map that is decoded into the buffer each time.
    struct DecodedRows(Array3<f32>);

    impl PixelRows for DecodedRows {
        fn size(&self) -> (usize, usize) {
            (self.0.dim().0, self.0.dim().1)
        }

        fn samples<'a>(&'a self, rows: Range<usize>, buffer: &'a mut Vec<f32>) -> &'a [f32] {
            buffer.clear();
            buffer.extend(self.0.slice(s![rows, .., ..]).iter());
            buffer
        }

        fn check_samples(&self) -> Result<()> {
            check_samples(self.0.view())
        }
    }

    #[test]
    fn decoded_rows_and_arrays_of_any_order_give_the_same_bits() {
        let mut map = Array3::from_shape_fn((37, 75, 3), |(y, x, c)| ((y * 7 + x * 3 + c) % 11) as f32);
        for (y, x) in [(0, 0), (36, 74), (20, 74), (21, 0), (21, 33)] {
            map.slice_mut(s![y, x, ..]).fill(900.0);
        }
        let text = |map: Result<super::super::WorkingMap>| format!("{:?}", map.unwrap());
        for registration in [Registration::CellCentred, Registration::BorderSampled] {
            let expected = text(reduce(map.view(), registration, 16, 5e-3, false));
            let decoded = DecodedRows(map.clone());
            assert_eq!(text(reduce_rows(&decoded, registration, 16, 5e-3, false)), expected);
            let flipped = map.slice(s![..;-1, .., ..]).to_owned();
            let view = flipped.slice(s![..;-1, .., ..]);
            assert_eq!(text(reduce(view, registration, 16, 5e-3, false)), expected);
        }
        let mut dark = map.clone();
        dark[[3, 3, 0]] = f32::NAN;
        assert!(reduce_rows(&DecodedRows(dark), Registration::CellCentred, 16, 5e-3, false).is_err());
    }
}
