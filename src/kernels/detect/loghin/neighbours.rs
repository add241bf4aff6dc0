//! Step 5 of Loghin (2021): the brightest pixel around a sample.

use std::ops::Range;

use ndarray::ArrayView2;
use rayon::prelude::*;

use super::{Image, Pixel, pixels_inside};
use crate::error::Result;

/// The brightest pixel within `reach` rows and columns of each of `pixels`, (n, 2), and its value.
///
/// On a `sphere`, the window crosses the seam and widens towards the poles, so that it spans the
/// same angle everywhere: `reach / sin theta` columns. Of equal pixels the first one counts, row by
/// row from the window's left.
///
/// # Errors
///
/// [`crate::error::Error::EmptyImage`], [`crate::error::Error::BadPixel`],
/// [`crate::error::Error::WrongColumns`], [`crate::error::Error::OutsideImage`].
pub fn neighbour_maximum(
    luminance: ArrayView2<'_, f32>,
    pixels: ArrayView2<'_, i64>,
    reach: usize,
    sphere: bool,
) -> Result<Vec<(f32, Pixel)>> {
    let samples = luminance.as_standard_layout();
    let image = Image::new("luminance", samples.view())?;
    let pixels = pixels_inside(pixels, luminance.dim())?;
    let columns = columns_within(luminance.dim(), reach, sphere);
    Ok(pixels.into_par_iter().map(|pixel| brightest_around(&image, pixel, reach, &columns, sphere)).collect())
}

/// Columns of each row that belong to the window on either side.
fn columns_within((height, width): (usize, usize), reach: usize, sphere: bool) -> Vec<usize> {
    let sine = |row: usize| ((row as f64 + 0.5) / height as f64 * std::f64::consts::PI).sin();
    let columns = |row: usize| if sphere { (reach as f64 / sine(row)) as usize } else { reach };
    (0..height).map(|row| columns(row).min(width)).collect()
}

fn brightest_around(
    image: &Image<'_>,
    [row, column]: Pixel,
    reach: usize,
    columns: &[usize],
    sphere: bool,
) -> (f32, Pixel) {
    let mut best = (f32::NEG_INFINITY, [row, column]);
    let rows = row.saturating_sub(reach)..(row + reach.min(image.height) + 1).min(image.height);
    for (y, &columns) in rows.clone().zip(&columns[rows]) {
        let line = image.row(y);
        for part in window(column, columns, image.width, sphere) {
            let first = part.start;
            for (x, &value) in line[part].iter().enumerate() {
                if value > best.0 {
                    best = (value, [y, first + x]);
                }
            }
        }
    }
    best
}

/// The columns within `reach` of `column`: one run of them, or two across the seam of a `sphere`.
fn window(column: usize, reach: usize, width: usize, sphere: bool) -> [Range<usize>; 2] {
    let (left, right) = (column.saturating_sub(reach), (column + reach + 1).min(width));
    if !sphere {
        return [left..right, 0..0];
    }
    if 2 * reach >= width {
        return [0..width, 0..0];
    }
    if column < reach {
        return [column + width - reach..width, 0..right];
    }
    [left..right, 0..(column + reach + 1).saturating_sub(width)]
}
