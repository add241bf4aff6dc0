//! Means of a plane image over equal areas. Pixels of a map that count by solid angle are those of `block_rows.rs`.

use ndarray::{Array3, ArrayView3, Axis};
use rayon::prelude::*;

use crate::error::{Error, Result};
use crate::interrupt;
use crate::kernels::sphere::check_memory;

/// Means of an image, (height, width, channels), over `rows` x `columns` equal areas; a pixel between two counts in both.
///
/// # Errors
///
/// [`Error::EmptyImage`], [`Error::NoMemory`].
pub fn area_means<Sample: Copy + Into<f64> + Sync>(
    image: ArrayView3<'_, Sample>,
    rows: usize,
    columns: usize,
) -> Result<Array3<f64>> {
    let (height, width, channels) = image.dim();
    if image.is_empty() {
        return Err(Error::EmptyImage { height, width });
    }
    check_memory(&[rows, columns, channels])?;
    let across: Vec<_> = (0..columns).map(|i| part(i, columns, width)).collect();
    let mut out = Array3::zeros((rows, columns, channels));
    out.outer_iter_mut().into_par_iter().enumerate().for_each(|(row, mut out)| {
        interrupt::check();
        let mut mean = vec![0.0; width * channels];
        for (row, weight) in part(row, rows, height) {
            let samples = image.index_axis(Axis(0), row);
            mean.iter_mut().zip(samples).for_each(|(mean, &sample)| *mean += weight * sample.into());
        }
        for (mut cell, part) in out.outer_iter_mut().zip(&across) {
            for &(column, weight) in part {
                let pixel = &mean[column * channels..(column + 1) * channels];
                cell.iter_mut().zip(pixel).for_each(|(sum, mean)| *sum += weight * mean);
            }
        }
    });
    Ok(out)
}

/// Pixels in part `i` of `count` equal parts of a line of `pixels`, each with its fraction of the part.
fn part(i: usize, count: usize, pixels: usize) -> Vec<(usize, f64)> {
    let (start, end) = (i * pixels, (i + 1) * pixels);
    let within = |pixel: usize| end.min((pixel + 1) * count) - start.max(pixel * count);
    (start / count..end.div_ceil(count)).map(|pixel| (pixel, within(pixel) as f64 / pixels as f64)).collect()
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use ndarray::array;

    use super::*;

    #[test]
    fn a_pixel_between_two_areas_counts_in_both() {
        let image = array![[[3.0_f32], [6.0], [9.0]], [[5.0], [8.0], [11.0]]];
        assert_eq!(area_means(image.view(), 1, 2).unwrap(), array![[[5.0], [9.0]]]);
        assert_eq!(area_means(image.view(), 2, 3).unwrap(), image.mapv(f64::from));
    }
}
