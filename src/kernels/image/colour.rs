//! Conversion of colours to linear Rec.709 by a matrix.

use ndarray::{ArrayView1, ArrayViewMut3, Axis};
use rayon::prelude::*;

use super::samples::check_channels;
use crate::error::Result;
use crate::interrupt;

/// Replace each pixel of a (height, width, 3) image by `matrix` times the pixel, and return the number of pixels that
/// lay outside Rec.709.
///
/// A negative result becomes 0, because no light has negative radiance. Pixels with a sample that is infinite or not a
/// number stay as they are: infinity minus infinity would make NaN of an infinite sun.
///
/// # Errors
///
/// [`crate::error::Error::NotAMap`] when the array is not (height, width, 3).
pub fn apply_matrix(mut image: ArrayViewMut3<'_, f32>, matrix: &[[f32; 3]; 3]) -> Result<usize> {
    check_channels(image.view())?;
    let outside: Vec<usize> = image
        .axis_iter_mut(Axis(0))
        .into_par_iter()
        .map(|mut row| {
            interrupt::check();
            match row.as_slice_mut() {
                Some(samples) => samples.as_chunks_mut().0.iter_mut().map(|rgb| replace(rgb, matrix)).sum(),
                None => row.outer_iter_mut().map(|mut pixel| {
                    let mut rgb = array(pixel.view());
                    let outside = replace(&mut rgb, matrix);
                    pixel.assign(&ArrayView1::from(&rgb));
                    outside
                }).sum(),
            }
        })
        .collect();
    Ok(outside.into_iter().sum())
}

/// Replace one pixel, and return 1 if a result was negative.
fn replace(rgb: &mut [f32; 3], matrix: &[[f32; 3]; 3]) -> usize {
    let [r, g, b] = *rgb;
    let converted = matrix.map(|row| row[0] * r + row[1] * g + row[2] * b);
    // The sum of zeros is NaN if a sample is infinite or NaN.
    let is_finite = r * 0.0 + g * 0.0 + b * 0.0 == 0.0;
    *rgb = if is_finite { converted.map(|value| value.max(0.0)) } else { *rgb };
    usize::from(is_finite && converted.iter().any(|&value| value < 0.0))
}

fn array(pixel: ArrayView1<'_, f32>) -> [f32; 3] {
    [pixel[0], pixel[1], pixel[2]]
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use ndarray::{Array3, s};
    use proptest::prelude::*;

    use super::*;

    const MATRIX: [[f32; 3]; 3] = [[1.5, -0.5, 0.0], [0.0, 1.0, 0.0], [0.25, 0.25, 0.5]];

    fn one(rgb: [f32; 3]) -> ([f32; 3], usize) {
        let mut image = Array3::from_shape_fn((2, 3, 3), |(_, _, c)| rgb[c]);
        let outside = apply_matrix(image.view_mut(), &MATRIX).unwrap();
        (array(image.slice(s![1, 2, ..])), outside)
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
        assert!(apply_matrix(Array3::zeros((4, 4, 4)).view_mut(), &MATRIX).is_err());
        assert_eq!(apply_matrix(Array3::zeros((1, 1, 3)).view_mut(), &MATRIX).unwrap(), 0);
    }

    proptest! {
        #[test]
        fn every_layout_gives_the_same_pixels(values in prop::collection::vec(-10.0_f32..1e4, 60)) {
            let image = Array3::from_shape_vec((4, 5, 3), values).unwrap();
            let mut straight = image.clone();
            let outside = apply_matrix(straight.view_mut(), &MATRIX).unwrap();
            let mut turned = image.permuted_axes([1, 0, 2]).as_standard_layout().into_owned();
            let again = apply_matrix(turned.view_mut().permuted_axes([1, 0, 2]), &MATRIX).unwrap();
            prop_assert_eq!(outside, again);
            prop_assert_eq!(turned.permuted_axes([1, 0, 2]), straight);
        }
    }
}
