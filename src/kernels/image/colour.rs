//! Conversion of colours to linear Rec.709 by a matrix.

use ndarray::{ArrayView3, ArrayViewMut3};
use rayon::prelude::*;

use super::samples::check_channels;
use crate::error::Result;
use crate::interrupt;

/// Write each pixel of a (height, width, 3) image times `matrix` into `result`, which is contiguous; return the number
/// of pixels that lay outside Rec.709.
///
/// A negative result becomes 0, because no light has negative radiance. Pixels with a sample that is infinite or not a
/// number stay as they are: infinity minus infinity would make NaN of an infinite sun.
///
/// # Errors
///
/// [`crate::error::Error::NotAMap`] when the array is not (height, width, 3).
pub fn apply_matrix(
    image: ArrayView3<'_, f32>,
    matrix: &[[f32; 3]; 3],
    mut result: ArrayViewMut3<'_, f32>,
) -> Result<usize> {
    check_channels(image)?;
    let image = image.as_standard_layout();
    let rows = result.outer_iter_mut().into_par_iter().zip(image.outer_iter());
    let outside: Vec<usize> = rows
        .map(|(mut converted, row)| {
            interrupt::check();
            let (Some(converted), Some(row)) = (converted.as_slice_mut(), row.as_slice()) else { return 0 };
            let pixels = converted.as_chunks_mut().0.iter_mut().zip(row.as_chunks().0);
            pixels.map(|(converted, rgb)| convert(converted, rgb, matrix)).sum()
        })
        .collect();
    Ok(outside.into_iter().sum())
}

/// Convert one pixel, and return 1 if a result was negative.
fn convert(converted: &mut [f32; 3], rgb: &[f32; 3], matrix: &[[f32; 3]; 3]) -> usize {
    let [r, g, b] = *rgb;
    let product = matrix.map(|row| row[0] * r + row[1] * g + row[2] * b);
    // The sum is NaN if a sample is infinite or NaN.
    let is_finite = r * 0.0 + g * 0.0 + b * 0.0 == 0.0;
    *converted = if is_finite { product.map(|value| value.max(0.0)) } else { *rgb };
    usize::from(is_finite && product.iter().any(|&value| value < 0.0))
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use ndarray::Array3;
    use proptest::prelude::*;

    use super::*;

    const MATRIX: [[f32; 3]; 3] = [[1.5, -0.5, 0.0], [0.0, 1.0, 0.0], [0.25, 0.25, 0.5]];

    fn product(image: ArrayView3<'_, f32>) -> Result<(Array3<f32>, usize)> {
        let mut result = Array3::zeros(image.dim());
        let outside = apply_matrix(image, &MATRIX, result.view_mut())?;
        Ok((result, outside))
    }

    fn one(rgb: [f32; 3]) -> ([f32; 3], usize) {
        let image = Array3::from_shape_fn((2, 3, 3), |(_, _, c)| rgb[c]);
        let (result, outside) = product(image.view()).unwrap();
        ([0, 1, 2].map(|c| result[[1, 2, c]]), outside)
    }

    #[test]
    fn a_pixel_becomes_the_product_with_the_matrix() {
        assert_eq!(one([2.0, 1.0, 4.0]), ([2.5, 1.0, 2.75], 0));
    }

    #[test]
    fn a_negative_result_becomes_black_and_its_pixel_is_counted() {
        assert_eq!(one([0.0, 2.0, 0.0]), ([0.0, 2.0, 0.5], 6));
        assert_eq!(one([0.0, 0.0, 0.0]), ([0.0, 0.0, 0.0], 0));
    }

    #[test]
    fn a_pixel_with_an_infinite_sample_stays() {
        assert_eq!(one([f32::INFINITY, f32::INFINITY, 1.0]), ([f32::INFINITY, f32::INFINITY, 1.0], 0));
        assert!(one([f32::NAN, -2.0, 1.0]).0[0].is_nan());
        assert_eq!(one([f32::NAN, -2.0, 1.0]).0[1..], [-2.0, 1.0]);
    }

    #[test]
    fn an_image_without_three_channels_is_refused() {
        assert!(product(Array3::zeros((4, 4, 4)).view()).is_err());
        assert_eq!(product(Array3::zeros((1, 1, 3)).view()).unwrap().1, 0);
    }

    proptest! {
        #[test]
        fn every_layout_gives_the_same_pixels(values in prop::collection::vec(-10.0_f32..1e4, 60)) {
            let image = Array3::from_shape_vec((4, 5, 3), values).unwrap();
            let (straight, outside) = product(image.view()).unwrap();
            let turned = image.permuted_axes([1, 0, 2]).as_standard_layout().into_owned();
            let (again, count) = product(turned.view().permuted_axes([1, 0, 2])).unwrap();
            prop_assert_eq!(outside, count);
            prop_assert_eq!(again, straight);
        }
    }
}
