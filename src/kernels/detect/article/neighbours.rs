//! Step 5 of Loghin (2021): the brightest pixel around a sample.

use ndarray::ArrayView2;
use rayon::prelude::*;

use super::image::check_size;
use super::{Pixel, pixels_inside};
use crate::error::Result;

/// The brightest pixel within `reach` rows and columns of each of `pixels`, (n, 2), and its value.
///
/// On a `sphere`, the window crosses the seam and widens towards the poles, so that it spans the
/// same angle everywhere: `reach / sin theta` columns. Of equal pixels the first one counts.
///
/// # Errors
///
/// [`crate::error::Error::EmptyImage`], [`crate::error::Error::WrongColumns`],
/// [`crate::error::Error::OutsideImage`].
pub fn neighbour_maximum(
    luminance: ArrayView2<'_, f32>,
    pixels: ArrayView2<'_, i64>,
    reach: usize,
    sphere: bool,
) -> Result<Vec<(f32, Pixel)>> {
    check_size(luminance.dim())?;
    let pixels = pixels_inside(pixels, luminance.dim())?;
    let columns = columns_within(luminance.dim(), reach, sphere);
    Ok(pixels
        .into_par_iter()
        .map(|pixel| brightest_around(luminance, pixel, reach, &columns, sphere))
        .collect())
}

/// Columns of each row that belong to the window on either side.
fn columns_within((height, width): (usize, usize), reach: usize, sphere: bool) -> Vec<usize> {
    let sine = |row: usize| ((row as f64 + 0.5) / height as f64 * std::f64::consts::PI).sin();
    let columns = |row: usize| if sphere { (reach as f64 / sine(row)) as usize } else { reach };
    (0..height).map(|row| columns(row).min(width / 2)).collect()
}

fn brightest_around(
    luminance: ArrayView2<'_, f32>,
    [row, column]: Pixel,
    reach: usize,
    columns: &[usize],
    sphere: bool,
) -> (f32, Pixel) {
    let (height, width) = luminance.dim();
    let mut best = (f32::NEG_INFINITY, [row, column]);
    let rows = row.saturating_sub(reach)..(row + reach + 1).min(height);
    for (y, &columns) in rows.clone().zip(&columns[rows]) {
        let line = luminance.row(y);
        let mut see = |x: usize| {
            if line[x] > best.0 {
                best = (line[x], [y, x]);
            }
        };
        if sphere {
            (column + width - columns..=column + width + columns).for_each(|x| see(x % width));
        } else {
            (column.saturating_sub(columns)..(column + columns + 1).min(width)).for_each(&mut see);
        }
    }
    best
}
