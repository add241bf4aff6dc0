//! One pass over the map: luminance in fewer pixels, and the maximum of each tile of them.
//!
//! Detection is bound by memory: this pass reads every sample once, what follows reads a
//! sixteenth of them and less.

use ndarray::{Array2, ArrayView3, s};
use rayon::prelude::*;

use super::covered;
use super::lanes::dot;
use crate::error::{Error, Result};
use crate::kernels::image::{self, Grid, check_samples, weighted_mean};
use crate::kernels::sphere::{Registration, band_heights};

/// Pixels of a row that are summed at once: few enough to stay in the first cache.
const PIXELS_AT_ONCE: usize = 128;

/// Sides of a tile, in pixels of the working image.
pub const TILE: usize = 16;

/// A map in fewer pixels, each the mean of a block of the map's.
#[derive(Clone, Debug)]
pub struct Summary {
    /// Rows and columns.
    pub size: (usize, usize),
    /// Mean luminance by solid angle, row after row.
    pub luminance: Vec<f32>,
    /// Where the pixels lie on the sphere.
    pub grid: Grid,
    /// `cos theta_top - cos theta_bottom` of each row.
    pub bands: Vec<f64>,
    /// Pixels of the map along each side of a working pixel.
    pub block: usize,
    /// Largest luminance in each tile.
    pub tile_maxima: Array2<f32>,
    /// Integral of the luminance over the sphere.
    pub flux: f64,
}

/// `radiance` as luminance in at most `columns` columns.
///
/// # Errors
///
/// [`Error::NotAMap`]; [`Error::NotFinite`] and [`Error::Negative`] for samples that no light can have:
/// this pass sees them all; [`Error::TooBright`].
pub fn summarise(
    radiance: ArrayView3<'_, f32>,
    registration: Registration,
    columns: usize,
) -> Result<Summary> {
    image::check_rgb(radiance)?;
    let (height, width, _) = radiance.dim();
    let pixels = Grid::of_pixels(height, width, registration);
    let block = width.div_ceil(columns.max(1));
    let grid = pixels.in_blocks(block);
    let bands = band_heights(&grid.theta_edges);
    let reduction = Reduction::new(radiance, &pixels, &grid, block);
    let size = (grid.theta_edges.len() - 1, grid.phi_edges.len() - 1);
    let mut luminance = vec![0.0; size.0 * size.1];
    let mut tile_maxima = Array2::zeros((size.0.div_ceil(TILE), size.1.div_ceil(TILE)));
    let mut signs = vec![false; size.0.div_ceil(TILE)];
    let widths: Vec<f64> = grid.phi_edges.windows(2).map(|edge| edge[1] - edge[0]).collect();
    let mut row_sums = vec![0.0; size.0];
    luminance
        .par_chunks_mut(TILE * size.1)
        .zip(row_sums.par_chunks_mut(TILE))
        .zip(tile_maxima.outer_iter_mut().into_par_iter())
        .zip(&mut signs)
        .enumerate()
        .for_each(|(tile_row, (((rows, sums), mut maxima), signs))| {
            let mut largest = vec![0.0; size.1];
            for (i, (row, sum)) in rows.chunks_mut(size.1).zip(sums).enumerate() {
                *signs |= reduction.fill_row(tile_row * TILE + i, row);
                *sum = dot(row, &widths);
                raise(&mut largest, row);
            }
            for (maximum, columns) in maxima.iter_mut().zip(largest.chunks(TILE)) {
                *maximum = columns.iter().copied().fold(0.0, f32::max);
            }
        });
    let flux: f64 = row_sums.iter().zip(&bands).map(|(sum, band)| sum * band).sum();
    if signs.contains(&true) || !flux.is_finite() {
        check_samples(radiance)?;
    }
    if !flux.is_finite() {
        return Err(Error::TooBright);
    }
    Ok(Summary { size, luminance, grid, bands, block, tile_maxima, flux })
}

impl Summary {
    /// Height of a row, in radians; the last may be lower.
    pub fn pixel(&self) -> f64 {
        let theta = &self.grid.theta_edges;
        theta[1..].iter().zip(theta).map(|(below, above)| below - above).fold(0.0, f64::max)
    }
}

fn raise(largest: &mut [f32], row: &[f32]) {
    for (largest, &value) in largest.iter_mut().zip(row) {
        *largest = if value > *largest { value } else { *largest };
    }
}

/// How the map's pixels make the pixels of the working image.
struct Reduction<'a> {
    radiance: ArrayView3<'a, f32>,
    block: usize,
    /// Polar angles between the rows of the map.
    theta_edges: &'a [f64],
    /// Widths of the map's first and last pixel, in widths of the others.
    outer_widths: [f32; 2],
    /// One over the width of each column of the working image, in widths of the map's pixels.
    per_width: Vec<f32>,
}

impl<'a> Reduction<'a> {
    fn new(radiance: ArrayView3<'a, f32>, pixels: &'a Grid, grid: &Grid, block: usize) -> Self {
        let width = |edge: &[f64]| ((edge[1] - edge[0]) * pixels.columns_per_radian) as f32;
        let per_width = grid.phi_edges.windows(2).map(|edge| 1.0 / width(edge)).collect();
        let phi = &pixels.phi_edges;
        let outer_widths = [width(&phi[..2]), width(&phi[phi.len() - 2..])];
        Self { radiance, block, theta_edges: &pixels.theta_edges, outer_widths, per_width }
    }

    /// Luminance of one row of the working image; whether a sample of it has a minus sign.
    fn fill_row(&self, row: usize, out: &mut [f32]) -> bool {
        let rows = row * self.block..((row + 1) * self.block).min(self.theta_edges.len() - 1);
        let samples = self.radiance.slice(s![rows.clone(), .., ..]);
        let samples = samples.as_standard_layout();
        let samples = samples.as_slice().unwrap_or(&[]); // the standard layout is a slice
        if self.block == 1 {
            fill_luminance(samples, out)
        } else {
            self.reduce(samples, &band_heights(&self.theta_edges[rows.start..=rows.end]), out)
        }
    }

    /// Mean luminance of blocks of pixels, from the rows `samples` of the heights `bands`.
    fn reduce(&self, samples: &[f32], bands: &[f64], out: &mut [f32]) -> bool {
        let mut signs = false;
        let whole: f64 = bands.iter().sum();
        let weights: Vec<f32> = bands.iter().map(|band| (band / whole) as f32).collect();
        let rows: Vec<&[f32]> = samples.chunks_exact(samples.len() / bands.len()).collect();
        let cells = (PIXELS_AT_ONCE / self.block).max(1);
        let mut mean = vec![0.0; 3 * cells * self.block];
        let parts = out.chunks_mut(cells).zip(self.per_width.chunks(cells));
        for (start, (out, per_width)) in (0..).step_by(3 * cells * self.block).zip(parts) {
            let columns = start..(start + 3 * cells * self.block).min(rows[0].len());
            let mean = &mut mean[..columns.len()];
            signs |= weighted_mean(&rows, &weights, columns.clone(), mean);
            self.narrow_the_outer(mean, start == 0, columns.end == rows[0].len());
            for ((out, pixels), per_width) in out.iter_mut().zip(mean.chunks(3 * self.block)).zip(per_width) {
                *out = per_width * luminance_of_sum(pixels);
            }
        }
        signs
    }

    fn narrow_the_outer(&self, mean: &mut [f32], is_first: bool, is_last: bool) {
        let last = mean.len() - 3;
        if is_first {
            mean[..3].iter_mut().for_each(|value| *value *= self.outer_widths[0]);
        }
        if is_last {
            mean[last..].iter_mut().for_each(|value| *value *= self.outer_widths[1]);
        }
    }
}

/// Luminance of the sum of RGB pixels: four of them are twelve samples, three vectors of four lanes.
fn luminance_of_sum(samples: &[f32]) -> f32 {
    let [r, g, b] = image::LUMINANCE.map(|weight| weight as f32);
    let (fours, rest) = samples.as_chunks::<12>();
    let mut lanes = [0.0_f32; 4];
    for four in fours {
        let weights = [[r, g, b, r], [g, b, r, g], [b, r, g, b]];
        for (samples, weights) in four.as_chunks::<4>().0.iter().zip(weights) {
            for (lane, (sample, weight)) in lanes.iter_mut().zip(samples.iter().zip(weights)) {
                *lane += weight * sample;
            }
        }
    }
    let rest: f32 =
        rest.as_chunks::<3>().0.iter().map(|pixel| r * pixel[0] + g * pixel[1] + b * pixel[2]).sum();
    (lanes[0] + lanes[1]) + (lanes[2] + lanes[3]) + rest
}

/// Luminance of each pixel; whether a sample has a minus sign. (NaN and infinity show in the flux.)
fn fill_luminance(samples: &[f32], out: &mut [f32]) -> bool {
    let mut bits = 0;
    for (out, &pixel) in out.iter_mut().zip(samples.as_chunks::<3>().0) {
        // Minus zero becomes zero: floats are compared by their bits.
        *out = covered::luminance(pixel) + 0.0;
        bits |= pixel.iter().fold(0, |bits, sample| bits | sample.to_bits());
    }
    bits >> 31 == 1
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;
    use ndarray::Array3;
    use std::f64::consts::PI;

    fn map(height: usize, width: usize) -> Array3<f32> {
        Array3::from_shape_fn((height, width, 3), |(y, x, c)| ((y * 7 + x * 3 + c) % 11) as f32)
    }

    /// Sum over the map's own pixels, one by one.
    fn flux_of(map: &Array3<f32>, registration: Registration) -> f64 {
        let (height, width, _) = map.dim();
        let solid_angles = crate::kernels::sphere::pixel_solid_angles(height, width, registration).unwrap();
        let pixels = solid_angles.indexed_iter();
        let rgb = |y: usize, x: usize| [0, 1, 2].map(|c| f64::from(map[[y, x, c]]));
        pixels.map(|((y, x), solid_angle)| image::luminance(rgb(y, x)) * solid_angle).sum()
    }

    #[test]
    fn the_flux_is_that_of_the_map_whatever_the_blocks() {
        for registration in [Registration::CellCentred, Registration::BorderSampled] {
            for (height, width, columns) in
                [(30, 60, 60), (30, 60, 16), (37, 74, 10), (9, 18, 1), (150, 300, 1)]
            {
                let map = map(height, width);
                let summary = summarise(map.view(), registration, columns).unwrap();
                assert!(summary.size.1 <= columns);
                assert_relative_eq!(summary.flux, flux_of(&map, registration), max_relative = 1e-6);
            }
        }
    }

    #[test]
    fn each_pixel_is_the_mean_of_its_block_by_solid_angle() {
        for registration in [Registration::CellCentred, Registration::BorderSampled] {
            for (height, width, block) in [(30, 60, 1), (30, 60, 4), (37, 74, 5), (300, 600, 3)] {
                let map = map(height, width);
                let summary = summarise(map.view(), registration, width.div_ceil(block)).unwrap();
                assert_eq!(summary.block, block);
                let solid_angles =
                    crate::kernels::sphere::pixel_solid_angles(height, width, registration).unwrap();
                let mut sums = vec![(0.0, 0.0); summary.luminance.len()];
                for ((y, x), &solid_angle) in solid_angles.indexed_iter() {
                    let sum = &mut sums[y / block * summary.size.1 + x / block];
                    let rgb = [0, 1, 2].map(|c| f64::from(map[[y, x, c]]));
                    *sum = (sum.0 + image::luminance(rgb) * solid_angle, sum.1 + solid_angle);
                }
                for (&seen, (flux, solid_angle)) in summary.luminance.iter().zip(sums) {
                    assert_relative_eq!(f64::from(seen), flux / solid_angle, max_relative = 1e-5);
                }
            }
        }
    }

    #[test]
    fn an_even_map_stays_even() {
        let map = Array3::from_elem((50, 100, 3), 0.5_f32);
        let summary = summarise(map.view(), Registration::BorderSampled, 30).unwrap();
        assert!(summary.luminance.iter().all(|value| (value - 0.5).abs() < 1e-6));
        assert_relative_eq!(summary.flux, 0.5 * 4.0 * PI, max_relative = 1e-6);
    }

    #[test]
    fn a_tile_holds_the_maximum_of_its_pixels() {
        let summary = summarise(map(50, 100).view(), Registration::CellCentred, 100).unwrap();
        for ((row, column), &maximum) in summary.tile_maxima.indexed_iter() {
            let rows = row * TILE..((row + 1) * TILE).min(50);
            let pixels =
                rows.flat_map(|y| (column * TILE..((column + 1) * TILE).min(100)).map(move |x| y * 100 + x));
            let wanted = pixels.map(|i| summary.luminance[i]).fold(0.0, f32::max);
            assert_relative_eq!(maximum, wanted);
        }
    }

    #[test]
    fn what_is_no_number_is_refused() {
        let mut map = map(8, 16);
        map[[3, 5, 1]] = f32::NAN;
        for columns in [16, 2] {
            let seen = summarise(map.view(), Registration::CellCentred, columns);
            assert!(matches!(seen, Err(Error::UnusableSamples { row: 3, nan: 1, .. })), "{seen:?}");
        }
        // Sums of such samples are beyond f32.
        let seen = summarise(Array3::from_elem((8, 16, 3), f32::MAX).view(), Registration::CellCentred, 2);
        assert!(matches!(seen, Err(Error::TooBright)), "{seen:?}");
    }
}
