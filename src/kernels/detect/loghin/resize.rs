//! Step 1 of Loghin (2021): a smaller image.

use ndarray::{Array2, ArrayView2};
use rayon::prelude::*;

use super::image::Image;
use crate::error::{Error, Result};
use crate::interrupt;
use crate::kernels::sphere::check_memory;

/// Pixels of the largest image: 4 GB.
const MOST_PIXELS: usize = 1 << 30;

/// An image of `height` x `width` pixels: at each pixel's centre, linear between the four centres
/// around it.
///
/// Columns meet at the seam if `wrap` is true. Beyond an end, the outer pixel continues.
///
/// # Errors
///
/// [`Error::EmptyImage`], [`Error::BadPixel`], [`Error::HugeImage`], [`Error::NoMemory`].
pub fn resize_bilinear(
    image: ArrayView2<'_, f32>,
    height: usize,
    width: usize,
    wrap: bool,
) -> Result<Array2<f32>> {
    let samples = image.as_standard_layout();
    let image = Image::new("image", samples.view())?;
    if height == 0 || width == 0 {
        return Err(Error::EmptyImage { height, width });
    }
    if height.saturating_mul(width) > MOST_PIXELS {
        return Err(Error::HugeImage { height, width, limit: MOST_PIXELS });
    }
    // Find the old pixels around each new centre.
    let across = columns_between(width, image.width, wrap);
    let down = between_centres(height, image.height);
    check_memory(&[height, width.div_ceil(2)])?; // 4 bytes a pixel
    // Interpolate between them, first across and then down.
    let mut out = Array2::zeros((height, width));
    out.outer_iter_mut().into_par_iter().zip(down).for_each(|(mut out, (row, low))| {
        interrupt::check();
        let above = image.row(row.max(0) as usize);
        let below = image.row((row + 1).min(image.height as isize - 1) as usize);
        for (out, &(first, second, left)) in out.iter_mut().zip(&across) {
            let top = above[first] + left * (above[second] - above[first]);
            let bottom = below[first] + left * (below[second] - below[first]);
            *out = top + low * (bottom - top);
        }
    });
    Ok(out)
}

/// For each of `new` columns the two old ones around its centre, and the fraction of the way to the second.
fn columns_between(new: usize, old: usize, wrap: bool) -> Vec<(usize, usize, f32)> {
    let inside = |column: isize| {
        if wrap { column.rem_euclid(old as isize) } else { column.clamp(0, old as isize - 1) }
    };
    let pairs = between_centres(new, old).into_iter();
    pairs.map(|(column, part)| (inside(column) as usize, inside(column + 1) as usize, part)).collect()
}

/// For each of `new` pixels the last old one before its centre, and the fraction of the way to the next.
fn between_centres(new: usize, old: usize) -> Vec<(isize, f32)> {
    let at = |i: usize| (i as f64 + 0.5) * old as f64 / new as f64 - 0.5;
    (0..new).map(|i| (at(i).floor() as isize, (at(i) - at(i).floor()) as f32)).collect()
}
