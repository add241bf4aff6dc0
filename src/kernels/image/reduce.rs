//! A map in fewer cells, for probes that need not be exact.
#![allow(clippy::inline_always, reason = "what is not inlined is compiled for the oldest of processors")]

use glam::DVec3;
use ndarray::{Array3, ArrayView3, s};
use pulp::{Arch, Simd, WithSimd};
use rayon::prelude::*;

use super::grid::Grid;
use super::means::weighted_mean;
use super::samples::{check_rgb, check_samples};
use crate::error::Result;
use crate::kernels::sphere::{Registration, band_heights};

/// A map in fewer cells, for probes that need not be exact.
#[derive(Clone, Debug)]
pub struct WorkingMap {
    /// Mean radiance of each cell by solid angle, (rows, columns, 3); 0 where the cell became a source.
    pub radiance: Array3<f32>,
    /// Where the cells lie.
    pub grid: Grid,
    /// Vector irradiance of the cells that became sources, (n, 3 axes, 3 channels).
    pub sources: Array3<f64>,
}

/// `radiance` reduced to at most `columns` columns, its bright cells kept as point sources.
///
/// A cell that the horizon of a normal cuts is smeared by its width, which matters only where one
/// cell holds much light. So each cell with more than `source_share` of the flux of any channel
/// is taken out and kept as the vector `F = integral of L w dw` over its pixels: `max(0, n.F)` is
/// exact for a sun of one pixel wherever it stands in its cell.
///
/// # Errors
///
/// [`crate::error::Error::NotAMap`] when the array is not (height, width, 3) or smaller than 2 x 2;
/// [`crate::error::Error::UnusableSamples`]: this pass sees all samples.
pub fn reduce(
    radiance: ArrayView3<'_, f32>,
    registration: Registration,
    columns: usize,
    source_share: f64,
) -> Result<WorkingMap> {
    check_rgb(radiance)?;
    let (height, width, _) = radiance.dim();
    let pixels = Grid::of_pixels(height, width, registration);
    let block = width.div_ceil(columns.max(1)).max(1);
    let grid = pixels.in_blocks(block);
    let mut flux = block_flux(radiance, &pixels, block)?;
    let cells = bright_cells(&flux, source_share);
    let sources: Vec<[[f64; 3]; 3]> = cells
        .par_iter()
        .map(|&(row, column)| vector_irradiance(radiance, &pixels, block, row, column))
        .collect();
    for &(row, column) in &cells {
        flux.slice_mut(s![row, column, ..]).fill(0.0);
    }
    Ok(WorkingMap {
        radiance: mean_radiance(&flux, &grid),
        grid,
        sources: Array3::from_shape_fn((cells.len(), 3, 3), |(i, axis, channel)| sources[i][axis][channel]),
    })
}

/// Pixels of a row that are summed at once: few enough to stay near, many enough to be read in a stream.
const PIXELS_AT_ONCE: usize = 512;

/// Integral of the radiance over each block, (rows, columns, 3).
fn block_flux(radiance: ArrayView3<'_, f32>, pixels: &Grid, block: usize) -> Result<Array3<f64>> {
    let (height, width, _) = radiance.dim();
    let widths: Vec<f64> = pixels.phi_edges.windows(2).map(|edge| edge[1] - edge[0]).collect();
    let mut flux = Array3::zeros((height.div_ceil(block), width.div_ceil(block), 3));
    let usable: Vec<bool> = by_rows(&mut flux)
        .into_par_iter()
        .enumerate()
        .map(|(cell_row, cells)| {
            let rows = cell_row * block..((cell_row + 1) * block).min(height);
            let bands = band_heights(&pixels.theta_edges[rows.start..=rows.end]);
            let samples = radiance.slice(s![rows, .., ..]);
            let samples = samples.as_standard_layout();
            let samples = samples.as_slice().unwrap_or(&[]); // the standard layout is a slice
            let rows = samples.chunks_exact(3 * width).collect();
            Arch::new().dispatch(BlockRow { cells, rows, bands, widths: &widths, block })
        })
        .collect();
    if usable.contains(&false) {
        check_samples(radiance)?;
    }
    Ok(flux)
}

/// The pixels of each row.
fn by_rows<T>(image: &mut Array3<T>) -> Vec<&mut [[T; 3]]> {
    let width = image.dim().1;
    let pixels = image.as_slice_mut().expect("a new array is in standard layout").as_chunks_mut().0;
    pixels.chunks_mut(width).collect()
}

/// Rows of pixels of these `bands` and `widths`, to be summed into the cells that they make.
struct BlockRow<'a> {
    cells: &'a mut [[f64; 3]],
    rows: Vec<&'a [f32]>,
    bands: Vec<f64>,
    widths: &'a [f64],
    block: usize,
}

impl WithSimd for BlockRow<'_> {
    /// Whether all samples are light: a minus sign is seen on the way, the rest in the sums.
    type Output = bool;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> bool {
        let Self { cells, rows, bands, widths, block } = self;
        let whole: f64 = bands.iter().sum();
        let weights: Vec<f32> = bands.iter().map(|band| (band / whole) as f32).collect();
        let at_once = (PIXELS_AT_ONCE / block).max(1) * block;
        // A fourth channel, which is not used, makes a pixel a vector.
        let mut mean = vec![0.0; 3 * at_once + 1];
        let mut signs = false;
        for ((i, widths), cells) in widths.chunks(at_once).enumerate().zip(cells.chunks_mut(at_once / block))
        {
            let samples = 3 * widths.len();
            signs |= weighted_mean(
                &rows,
                &weights,
                3 * i * at_once..3 * i * at_once + samples,
                &mut mean[..samples],
            );
            for ((cell, widths), mean) in
                cells.iter_mut().zip(widths.chunks(block)).zip(mean.windows(3 * block + 1).step_by(3 * block))
            {
                let mut sum = [0.0; 4];
                for (pixel, width) in mean.windows(4).step_by(3).zip(widths) {
                    for (sum, value) in sum.iter_mut().zip(pixel) {
                        *sum += f64::from(*value) * width * whole;
                    }
                }
                cell.copy_from_slice(&sum[..3]);
            }
        }
        !signs && cells.as_flattened().iter().fold(true, |all, value| all & value.is_finite())
    }
}

/// Cells that hold more than `share` of all flux of a channel.
fn bright_cells(flux: &Array3<f64>, share: f64) -> Vec<(usize, usize)> {
    let (_, columns, _) = flux.dim();
    let cells = flux.as_slice().expect("a new array is in standard layout").as_chunks::<3>().0;
    let add = |sum: [f64; 3], cell: &[f64; 3]| std::array::from_fn(|channel| sum[channel] + cell[channel]);
    let rows = cells.chunks(columns).map(|row| row.iter().fold([0.0; 3], add));
    let limit = rows.fold([0.0; 3], |sum, row| add(sum, &row)).map(|total| share * total);
    let is_bright = |cell: &[f64; 3]| cell[0] > limit[0] || cell[1] > limit[1] || cell[2] > limit[2];
    let bright = cells.iter().enumerate().filter(|(_, cell)| is_bright(cell));
    bright.map(|(index, _)| (index / columns, index % columns)).collect()
}

/// `F = sum over the block's pixels of L w dw`: for each axis, for each channel.
fn vector_irradiance(
    radiance: ArrayView3<'_, f32>,
    pixels: &Grid,
    block: usize,
    cell_row: usize,
    cell_column: usize,
) -> [[f64; 3]; 3] {
    let (height, width, _) = radiance.dim();
    let columns = cell_column * block..((cell_column + 1) * block).min(width);
    let middle = |edges: &[f64], i: usize| 0.5 * (edges[i] + edges[i + 1]);
    let azimuths: Vec<(f64, f64)> =
        columns.clone().map(|column| middle(&pixels.phi_edges, column).sin_cos()).collect();
    let mut sum = [[0.0; 3]; 3];
    for row in cell_row * block..((cell_row + 1) * block).min(height) {
        let theta = &pixels.theta_edges;
        let band = band_heights(&theta[row..row + 2])[0];
        let (sin_theta, cos_theta) = middle(theta, row).sin_cos();
        for (column, (sin_phi, cos_phi)) in columns.clone().zip(&azimuths) {
            let phi = &pixels.phi_edges;
            let solid_angle = band * (phi[column + 1] - phi[column]);
            let direction = DVec3::new(sin_phi * sin_theta, cos_theta, -cos_phi * sin_theta);
            let towards = direction * solid_angle;
            for (axis, sum) in sum.iter_mut().enumerate() {
                for (channel, sum) in sum.iter_mut().enumerate() {
                    *sum += f64::from(radiance[[row, column, channel]]) * towards[axis];
                }
            }
        }
    }
    sum
}

fn mean_radiance(flux: &Array3<f64>, grid: &Grid) -> Array3<f32> {
    let bands = band_heights(&grid.theta_edges);
    let widths: Vec<f64> = grid.phi_edges.windows(2).map(|edge| edge[1] - edge[0]).collect();
    let mut mean = Array3::zeros(flux.dim());
    by_rows(&mut mean).into_par_iter().zip(bands).zip(flux.outer_iter()).for_each(|((mean, band), flux)| {
        let flux = flux.to_slice().expect("a new array is in standard layout").as_chunks::<3>().0;
        for ((mean, flux), width) in mean.iter_mut().zip(flux).zip(&widths) {
            *mean = flux.map(|flux| (flux / (band * width)) as f32);
        }
    });
    mean
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use approx::assert_relative_eq;

    use super::*;

    #[test]
    fn reduction_keeps_the_flux() {
        let map = Array3::from_shape_fn((30, 60, 3), |(y, x, c)| ((y * 7 + x * 3 + c) % 11) as f32);
        for registration in [Registration::CellCentred, Registration::BorderSampled] {
            let pixels = Grid::of_pixels(30, 60, registration);
            let before = block_flux(map.view(), &pixels, 1).unwrap().sum();
            let small = reduce(map.view(), registration, 16, 2.0).unwrap();
            let bands = band_heights(&small.grid.theta_edges);
            let after: f64 = small
                .radiance
                .indexed_iter()
                .map(|((row, column, _), &value)| {
                    let edges = &small.grid.phi_edges;
                    f64::from(value) * bands[row] * (edges[column + 1] - edges[column])
                })
                .sum();
            assert_relative_eq!(before, after, max_relative = 1e-6);
        }
    }
}
