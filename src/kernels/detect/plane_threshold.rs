//! The threshold of a plane image, such as a photograph, by the rule of `segment/threshold.rs`.

use std::f64::consts::TAU;

use ndarray::ArrayView2;

use super::segment::threshold;
use super::segment::working_image::WorkingImage;
use crate::error::{Error, Result};
use crate::kernels::image::Grid;

/// Luminance above which a pixel of a plane image is bright; every pixel counts the same.
///
/// # Errors
///
/// [`Error::EmptyImage`].
pub fn plane_threshold(luminance: ArrayView2<'_, f32>) -> Result<f64> {
    let (height, width) = luminance.dim();
    if height == 0 || width == 0 {
        return Err(Error::EmptyImage { height, width });
    }
    let pixels = luminance.iter().copied().collect();
    let image = WorkingImage::of_luminance(equal_cells(height, width), 1, pixels);
    Ok(threshold::from_histogram(&image).luminance)
}

/// A grid of cells of equal solid angle, so that the histogram counts pixels.
fn equal_cells(height: usize, width: usize) -> Grid {
    let edge = |row: usize| (1.0 - 2.0 * row as f64 / height as f64).acos();
    Grid {
        theta_edges: (0..=height).map(edge).collect(),
        phi_edges: (0..=width).map(|column| TAU * column as f64 / width as f64).collect(),
        columns_per_radian: width as f64 / TAU,
        first_column: 0.0,
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use approx::assert_relative_eq;
    use ndarray::Array2;

    use super::*;

    /// Rows from 0 on; of 10 rows the first one or two are lit.
    fn image(lit: usize, luminance: f32) -> Array2<f32> {
        Array2::from_shape_fn((10, 33), |(row, _)| if row < lit { luminance } else { 1.0 })
    }

    #[test]
    fn rows_count_the_same_wherever_they_are() {
        // On the sphere, the first row would be 2 % of the area, and the fifth 16 %.
        for lit in [0, 1] {
            let threshold = plane_threshold(image(lit, 8.0).view()).unwrap();
            assert_relative_eq!(threshold, 2.0, max_relative = 0.04); // the width of a bin
        }
        let threshold = plane_threshold(image(2, 8.0).view()).unwrap();
        assert_relative_eq!(threshold, 16.0, max_relative = 0.04);
    }

    #[test]
    fn it_is_proportional_to_the_exposure() {
        let one = plane_threshold(image(1, 50.0).view()).unwrap();
        let dim = image(1, 50.0).mapv(|value| value / 1024.0);
        assert_relative_eq!(plane_threshold(dim.view()).unwrap() * 1024.0, one);
    }

    #[test]
    fn a_black_image_has_the_threshold_0() {
        assert_relative_eq!(plane_threshold(Array2::zeros((4, 6)).view()).unwrap(), 0.0);
        assert!(plane_threshold(Array2::zeros((0, 6)).view()).is_err());
    }
}
