//! Steps 1 and 2 of Loghin (2021): a smaller image, its luminance, and a blur.

use ndarray::{Array2, ArrayView2, ArrayView3, Axis};
use rayon::prelude::*;

use crate::error::{Error, Result};
use crate::kernels::image::{LUMINANCE, check_rgb};

/// Rec.709 luminance, (height, width), of linear RGB, (height, width, 3).
///
/// # Errors
///
/// [`Error::NotAMap`].
pub fn luminance(radiance: ArrayView3<'_, f32>) -> Result<Array2<f32>> {
    check_rgb(radiance)?;
    let [red, green, blue] = LUMINANCE.map(|weight| weight as f32);
    let mut out = Array2::zeros((radiance.dim().0, radiance.dim().1));
    out.outer_iter_mut().into_par_iter().zip(radiance.outer_iter().into_par_iter()).for_each(
        |(mut out, row)| {
            let row = row.as_standard_layout();
            let pixels = row.as_slice().map_or(&[][..], |samples| samples.as_chunks::<3>().0);
            for (out, pixel) in out.iter_mut().zip(pixels) {
                *out = red * pixel[0] + green * pixel[1] + blue * pixel[2];
            }
        },
    );
    Ok(out)
}

/// An image of `height` x `width` pixels: at each pixel's centre, linear between the four centres
/// around it. Columns meet at the seam, rows end.
///
/// # Errors
///
/// [`Error::EmptyImage`].
pub fn resize_bilinear(image: ArrayView2<'_, f32>, height: usize, width: usize) -> Result<Array2<f32>> {
    check_size(image.dim())?;
    check_size((height, width))?;
    let (rows, columns) = image.dim();
    let across = between_centres(width, columns);
    let down = between_centres(height, rows);
    let mut out = Array2::zeros((height, width));
    out.outer_iter_mut().into_par_iter().zip(down).for_each(|(mut out, (row, low))| {
        let above = image.row(row.max(0) as usize);
        let below = image.row((row + 1).clamp(0, rows as isize - 1) as usize);
        for (out, &(column, left)) in out.iter_mut().zip(&across) {
            let first = column.rem_euclid(columns as isize) as usize;
            let second = (first + 1) % columns;
            let top = above[first] + left * (above[second] - above[first]);
            let bottom = below[first] + left * (below[second] - below[first]);
            *out = top + low * (bottom - top);
        }
    });
    Ok(out)
}

/// For each of `new` pixels the old one before its centre, and how far it lies towards the next.
fn between_centres(new: usize, old: usize) -> Vec<(isize, f32)> {
    let at = |i: usize| (i as f64 + 0.5) * old as f64 / new as f64 - 0.5;
    (0..new).map(|i| (at(i).floor() as isize, (at(i) - at(i).floor()) as f32)).collect()
}

/// A Gaussian blur of standard deviation `sigma` pixels. Columns meet at the seam, rows end.
///
/// # Errors
///
/// [`Error::EmptyImage`], [`Error::NotFinite`].
pub fn blur(image: ArrayView2<'_, f32>, sigma: f64) -> Result<Array2<f32>> {
    check_size(image.dim())?;
    if !sigma.is_finite() {
        return Err(Error::NotFinite { what: "sigma", index: 0, value: sigma });
    }
    let (height, width) = image.dim();
    let weights = gaussian(sigma);
    let reach = weights.len() as isize / 2;
    let smooth = |at: &dyn Fn(isize) -> f32| -> f32 {
        (-reach..=reach).zip(&weights).map(|(offset, weight)| weight * at(offset)).sum()
    };
    let mut across = Array2::zeros((height, width));
    across.outer_iter_mut().into_par_iter().zip(image.axis_iter(Axis(0)).into_par_iter()).for_each(
        |(mut out, row)| {
            for (column, out) in out.iter_mut().enumerate() {
                *out = smooth(&|offset| row[(column as isize + offset).rem_euclid(width as isize) as usize]);
            }
        },
    );
    let mut out = Array2::zeros((height, width));
    out.outer_iter_mut().into_par_iter().enumerate().for_each(|(row, mut out)| {
        for (column, out) in out.iter_mut().enumerate() {
            *out = smooth(&|offset| {
                across[[(row as isize + offset).clamp(0, height as isize - 1) as usize, column]]
            });
        }
    });
    Ok(out)
}

/// Weights of a Gaussian out to three standard deviations; their sum is 1.
fn gaussian(sigma: f64) -> Vec<f32> {
    let reach = (3.0 * sigma.abs()).ceil() as isize;
    let weight = |offset: isize| (-0.5 * (offset as f64 / sigma.abs().max(1e-9)).powi(2)).exp();
    let sum: f64 = (-reach..=reach).map(weight).sum();
    (-reach..=reach).map(|offset| (weight(offset) / sum) as f32).collect()
}

pub(super) fn check_size(size: (usize, usize)) -> Result<()> {
    if size.0 == 0 || size.1 == 0 { Err(Error::EmptyImage { height: size.0, width: size.1 }) } else { Ok(()) }
}
