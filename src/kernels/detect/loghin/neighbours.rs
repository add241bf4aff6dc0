//! Step 5 of Loghin (2021): the brightest pixel around a sample.

use ndarray::ArrayView2;
use rayon::prelude::*;

use super::image::Image;
use super::running::first_maxima;
use super::windows::Windows;
use crate::error::Result;
use crate::interrupt;
use crate::kernels::sphere::{Pixel, check_memory, pixels_inside};

/// The brightest pixel within `reach` rows and columns of each of `pixels`, (n, 2), and its value.
///
/// On a `sphere`, the window crosses the seam and widens towards the poles, so that it spans the
/// same angle everywhere: `reach / sin theta` columns. The first one of equal pixels counts, row by
/// row, left to right.
///
/// # Errors
///
/// [`crate::error::Error::EmptyImage`], [`crate::error::Error::BadPixel`],
/// [`crate::error::Error::WrongColumns`], [`crate::error::Error::OutsideImage`],
/// [`crate::error::Error::NoMemory`].
pub fn neighbour_maximum(
    luminance: ArrayView2<'_, f32>,
    pixels: ArrayView2<'_, i64>,
    reach: usize,
    sphere: bool,
) -> Result<Vec<(f32, Pixel)>> {
    // Count 8 numbers for each pixel: its position, and two copies of its brightest neighbour.
    check_memory(&[pixels.nrows(), 8])?;
    let samples = luminance.as_standard_layout();
    let image = Image::new("luminance", samples.view())?;
    let pixels = pixels_inside(pixels, luminance.dim())?;
    let windows = Windows::new(luminance.dim(), reach, sphere);
    let size = image.height * image.width;
    if pixels.len().saturating_mul(windows.area()) <= READS.saturating_mul(size) {
        return Ok(pixels.into_par_iter().map(|pixel| brightest_around(&image, pixel, &windows)).collect());
    }
    // For each pixel of the image the column of a maximum, and its row.
    check_memory(&[image.height, image.width])?;
    Ok(brightest_around_all(&image, &pixels, &windows))
}

/// Above this many reads per image pixel, the all-pixels method is faster.
const READS: usize = 80;

/// The brightest pixel of the window around `pixel`, and its value.
fn brightest_around(image: &Image<'_>, pixel: Pixel, windows: &Windows) -> (f32, Pixel) {
    let mut best = (f32::NEG_INFINITY, pixel);
    for row in windows.rows(pixel) {
        interrupt::check();
        let line = image.row(row);
        for columns in windows.columns(row, pixel) {
            let first = columns.start;
            for (i, &value) in line[columns].iter().enumerate() {
                if value > best.0 {
                    best = (value, [row, first + i]);
                }
            }
        }
    }
    best
}

/// Brightest neighbours of all `pixels`, at a cost that does not grow with the windows.
///
/// The width of a window in a row depends on the row alone, so maxima run along each row first, and then down the
/// columns.
fn brightest_around_all(image: &Image<'_>, pixels: &[Pixel], windows: &Windows) -> Vec<(f32, Pixel)> {
    let along = |row: usize| {
        interrupt::check();
        first_maxima(image.row(row), windows.reach_in_row[row], windows.sphere)
    };
    let across: Vec<Vec<u32>> = (0..image.height).into_par_iter().map(along).collect();
    let brightest = |row: usize, column: usize| [row, across[row][column] as usize];
    let along = |column: usize| {
        interrupt::check();
        let values: Vec<f32> = (0..image.height).map(|row| image.at(brightest(row, column))).collect();
        first_maxima(&values, windows.reach, false)
    };
    let down: Vec<Vec<u32>> = (0..image.width).into_par_iter().map(along).collect();
    let around = |&[row, column]: &Pixel| {
        let pixel = brightest(down[column][row] as usize, column);
        (image.at(pixel), pixel)
    };
    pixels.par_iter().map(around).collect()
}
