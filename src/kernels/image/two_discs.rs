//! Two discs in black squares: the picture of a camera with two fisheye lenses, which is no map.

use std::ops::Range;

use ndarray::ArrayView3;

use super::block_layout::BlockLayout;
use super::cell_flux::CellFlux;
use super::grid::Grid;
use super::luminance::luminance;
use super::samples::check_rgb;
use crate::error::Result;
use crate::kernels::sphere::{Registration, band_heights};

/// Settings of the comparison of a disc with the corners around it.
struct TwoDiscSettings {
    /// Largest luminance of black corners, relative to the mean of the disc; codes of JPEG pictures have noise.
    black: f64,
    /// Least fraction of the corners that is black, and of the disc that is brighter than black.
    most: f64,
    /// Radius up to which a cell is of the disc, and from which it is of a corner, relative to half the square.
    radii: (f64, f64),
}

const DISC: TwoDiscSettings = TwoDiscSettings { black: 0.02, most: 0.95, radii: (0.96, 1.04) };

/// True if both halves of a picture of 2:1, read as a map and reduced to `columns`, are bright discs in black squares.
///
/// # Errors
///
/// [`crate::error::Error::NotAMap`], [`crate::error::Error::UnusableSamples`].
pub fn has_two_discs(
    radiance: ArrayView3<'_, f32>,
    registration: Registration,
    columns: usize,
) -> Result<bool> {
    check_rgb(radiance)?;
    let (height, width, _) = radiance.dim();
    let layout = BlockLayout::new(height, width, registration, columns);
    Ok(are_two_discs(&CellFlux::of_map(radiance, &layout)?, &layout.grid))
}

/// True if both halves of a reduced map are bright discs in black squares.
pub(super) fn are_two_discs(flux: &CellFlux, grid: &Grid) -> bool {
    let half = flux.cells.dim().1 / 2;
    [0..half, half..2 * half].into_iter().all(|columns| is_disc(flux, grid, columns))
}

/// True if some columns are a bright disc in a black square.
fn is_disc(flux: &CellFlux, grid: &Grid, columns: Range<usize>) -> bool {
    let (bands, widths) = (band_heights(&grid.theta_edges), grid.widths());
    let (rows, count) = (bands.len(), columns.len());
    let at = |i: usize, count: usize| i as f64 * 2.0 / count.saturating_sub(1).max(1) as f64 - 1.0;
    let (mut disc, mut corners, mut least) = (Vec::new(), Vec::new(), f64::INFINITY);
    for (row, band) in bands.iter().enumerate() {
        for (i, column) in columns.clone().enumerate() {
            let cell = [0, 1, 2].map(|c| flux.cells[[row, column, c]]);
            let value = luminance(cell) / (band * widths[column]);
            least = least.min(value);
            match at(i, count).hypot(at(row, rows)) {
                radius if radius < DISC.radii.0 => disc.push(value),
                radius if radius > DISC.radii.1 => corners.push(value),
                _ => {}
            }
        }
    }
    let mean = disc.iter().sum::<f64>() / disc.len() as f64 - least;
    let fraction = |values: &[f64], is_so: &dyn Fn(f64) -> bool| {
        values.iter().filter(|&&value| is_so(value - least)).count() as f64 / values.len() as f64
    };
    let black = DISC.black * mean;
    // Comparisons with NaN, of no cells, are false.
    fraction(&corners, &|value| value <= black) >= DISC.most
        && fraction(&disc, &|value| value > black) >= DISC.most
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use ndarray::Array3;

    use super::*;

    fn discs(size: usize) -> Array3<f32> {
        let at = |i: usize| i as f32 * 2.0 / (size - 1) as f32 - 1.0;
        let is_disc = |y: usize, x: usize| at(y).hypot(at(x % size)) < 1.0;
        Array3::from_shape_fn((size, 2 * size, 3), |(y, x, _)| if is_disc(y, x) { 0.5 } else { 0.0 })
    }

    #[test]
    fn two_discs_are_found_in_pictures_of_any_size_and_one_is_none() {
        for size in [16, 64, 300] {
            let mut picture = discs(size);
            assert!(has_two_discs(picture.view(), Registration::CellCentred, 256).unwrap(), "{size}");
            picture.slice_mut(ndarray::s![.., size.., ..]).fill(0.5);
            assert!(!has_two_discs(picture.view(), Registration::CellCentred, 256).unwrap(), "{size}");
        }
    }

    #[test]
    fn a_dark_map_and_one_with_dark_ground_are_none() {
        let mut map = Array3::zeros((64, 128, 3));
        assert!(!has_two_discs(map.view(), Registration::CellCentred, 256).unwrap());
        map.slice_mut(ndarray::s![..40, .., ..]).fill(1.0);
        assert!(!has_two_discs(map.view(), Registration::CellCentred, 256).unwrap());
    }
}
