//! Step 2 of Loghin (2021), an option: a blur against single bright pixels.

use ndarray::{Array2, ArrayView2};
use rayon::prelude::*;

use super::image::Image;
use crate::error::{Error, Result};
use crate::interrupt;
use crate::kernels::sphere::check_memory;

/// A Gaussian blur of standard deviation `sigma` pixels.
///
/// Columns meet at the seam if `wrap` is true. Beyond an end, the outer pixel continues.
///
/// # Errors
///
/// [`Error::EmptyImage`], [`Error::BadPixel`], [`Error::OutOfRange`] for a `sigma` beyond the width,
/// [`Error::NoMemory`].
pub fn blur(image: ArrayView2<'_, f32>, sigma: f64, wrap: bool) -> Result<Array2<f32>> {
    let samples = image.as_standard_layout();
    let image = Image::new("image", samples.view())?;
    if !(0.0..=image.width as f64).contains(&sigma) {
        return Err(Error::OutOfRange { what: "sigma", value: sigma, least: 0.0, most: image.width as f64 });
    }
    // Two images of 4 bytes a pixel.
    check_memory(&[image.height, image.width])?;
    let weights = gaussian(sigma);
    let across = along_rows(&image, &weights, wrap);
    Ok(along_columns(&across, &weights))
}

fn along_rows(image: &Image<'_>, weights: &[f32], wrap: bool) -> Array2<f32> {
    let reach = weights.len() / 2;
    let mut out = Array2::zeros((image.height, image.width));
    out.outer_iter_mut().into_par_iter().enumerate().for_each(|(row, mut out)| {
        let row = image.row(row);
        let around = if wrap { around_seam(row, reach) } else { beyond_ends(row, reach) };
        for (window, weight) in around.windows(row.len()).zip(weights) {
            interrupt::check();
            out.iter_mut().zip(window).for_each(|(out, value)| *out += weight * value);
        }
    });
    out
}

/// A row with `reach` more pixels on both sides: those across the seam, several times around if it must be.
fn around_seam(row: &[f32], reach: usize) -> Vec<f32> {
    let first = (row.len() - reach % row.len()) % row.len();
    row.iter().cycle().skip(first).take(row.len() + 2 * reach).copied().collect()
}

/// A row with `reach` more pixels on both sides, each a copy of the outer one.
fn beyond_ends(row: &[f32], reach: usize) -> Vec<f32> {
    let last = row.len() - 1;
    (0..row.len() + 2 * reach).map(|column| row[column.saturating_sub(reach).min(last)]).collect()
}

fn along_columns(image: &Array2<f32>, weights: &[f32]) -> Array2<f32> {
    let (reach, last) = (weights.len() / 2, image.nrows() - 1);
    let mut out = Array2::zeros(image.dim());
    out.outer_iter_mut().into_par_iter().enumerate().for_each(|(row, mut out)| {
        for (offset, &weight) in weights.iter().enumerate() {
            interrupt::check();
            out.scaled_add(weight, &image.row((row + offset).saturating_sub(reach).min(last)));
        }
    });
    out
}

/// Weights of a Gaussian out to three standard deviations; their sum is 1.
fn gaussian(sigma: f64) -> Vec<f32> {
    let reach = (3.0 * sigma).ceil() as isize;
    // For a sigma of 0 only the centre counts, but 0 / 0 has no value there.
    let weight = |offset: isize| (-0.5 * (offset as f64 / sigma.max(1e-9)).powi(2)).exp();
    let sum: f64 = (-reach..=reach).map(weight).sum();
    (-reach..=reach).map(|offset| (weight(offset) / sum) as f32).collect()
}
