//! Integrals of the radiance over the cells of a map, and the cells that are sources or bright.

use std::array::from_fn;
use std::f64::consts::{FRAC_PI_2, PI};

use ndarray::{Array3, ArrayView3, Axis, s};
use rayon::prelude::*;

use super::block_layout::BlockLayout;
use super::block_rows::BlockRow;
use super::grid::Grid;
use super::samples::check_samples;
use crate::error::Result;
use crate::kernels::sphere::band_heights;

/// Least ratio of a bright cell to the mean of all cells.
const CONTRAST: f64 = 8.0;
/// Least product of the flux and the radiance of a bright cell, each as a ratio to those of the map.
const WORTH: f64 = 0.012;

/// Integral of the radiance over each cell.
pub(super) struct CellFlux {
    /// (rows, columns, 3)
    pub cells: Array3<f64>,
    /// Integral over each row.
    pub rows: Vec<[f64; 3]>,
}

impl CellFlux {
    /// Integrals over the blocks of a map's pixels.
    pub fn of_map(map: ArrayView3<'_, f32>, layout: &BlockLayout) -> Result<Self> {
        let widths = layout.pixels.widths();
        let (rows, columns) = layout.blocks();
        let mut cells = Array3::zeros((rows, columns, 3));
        let rows = rows_mut(&mut cells).enumerate().map(|(row, cells)| {
            let pixels = BlockRow::new(map, &layout.pixels.theta_edges, layout.block, row);
            add_across(cells, &pixels, &widths, layout.block)
        });
        let (is_unusable, rows): (Vec<bool>, Vec<[f64; 3]>) = rows.unzip();
        if is_unusable.contains(&true) {
            check_samples(map)?;
        }
        Ok(Self { cells, rows })
    }

    /// Set the integrals over a row of cells, and their sum.
    pub fn set_row(&mut self, row: usize, cells: &[[f64; 3]], sum: [f64; 3]) {
        let places = self.cells.index_axis_mut(Axis(0), row);
        for (place, cell) in places.into_iter().zip(cells.as_flattened()) {
            *place = *cell;
        }
        self.rows[row] = sum;
    }

    /// Remove the part of each row below the horizon.
    pub fn hide_below(&mut self, grid: &Grid) {
        let rows = self.cells.outer_iter_mut().zip(&mut self.rows);
        for ((mut cells, sum), visible) in rows.zip(visible_above(grid)) {
            cells.mapv_inplace(|value| visible * value);
            *sum = sum.map(|value| visible * value);
        }
    }

    /// Integral over the map in each channel.
    pub fn whole(&self) -> [f64; 3] {
        sum(&self.rows)
    }

    /// Remove a cell.
    pub fn remove(&mut self, (row, column): (usize, usize)) {
        self.cells.slice_mut(s![row, column, ..]).fill(0.0);
        let others = self.cells.index_axis(Axis(0), row);
        self.rows[row] = from_fn(|channel| others.column(channel).sum());
    }

    /// Cells with more than a `share` of the `whole` flux of a channel, and with [`CONTRAST`] times the mean flux of a cell.
    pub fn sources(&self, whole: [f64; 3], share: f64) -> Vec<(usize, usize)> {
        let (rows, columns, _) = self.cells.dim();
        let least = least_source(whole, share, rows * columns);
        let in_row = |(row, cells): (usize, &[[f64; 3]])| {
            let columns = cells.iter().enumerate().filter(|(_, cell)| is_source(cell, least));
            columns.map(|(column, _)| (row, column)).collect::<Vec<_>>()
        };
        rows_of(&self.cells).enumerate().flat_map_iter(in_row).collect()
    }

    /// Mean radiance of the cells, and the bright cells, for which harmonics are not sharp enough.
    pub fn means(&self, grid: &Grid) -> (Array3<f32>, Vec<(usize, usize)>) {
        // Avoid divisions: `L / L_0` is the fraction of the flux over the fraction of the sphere.
        let over_whole = 1.0 / self.whole().iter().sum::<f64>();
        let widths = grid.widths();
        let of_row = |row: usize, means: &mut [[f32; 3]], cells: &[[f64; 3]], band: f64| {
            let mut bright = Vec::new();
            for (column, ((mean, cell), width)) in means.iter_mut().zip(cells).zip(&widths).enumerate() {
                let solid_angle = band * width;
                let over = 1.0 / solid_angle;
                *mean = cell.map(|flux| (flux * over) as f32);
                if is_bright(cell, over_whole, solid_angle) {
                    bright.push((row, column));
                }
            }
            bright
        };
        let mut means = Array3::zeros(self.cells.dim());
        let bands = band_heights(&grid.theta_edges);
        let rows = rows_mut(&mut means).zip(rows_of(&self.cells)).zip(&bands);
        let bright = rows.enumerate();
        let bright =
            bright.flat_map_iter(|(row, ((means, cells), band))| of_row(row, means, cells, *band)).collect();
        (means, bright)
    }
}

/// Fraction of each row of cells that is above the horizon.
pub(super) fn visible_above(grid: &Grid) -> impl Iterator<Item = f64> {
    let edges = grid.theta_edges.windows(2);
    edges.map(|edges| ((FRAC_PI_2 - edges[0]) / (edges[1] - edges[0])).clamp(0.0, 1.0))
}

/// Flux of each channel above which one of `cells` is a source.
pub(super) fn least_source(whole: [f64; 3], share: f64, cells: usize) -> [f64; 3] {
    let share = share.max(CONTRAST / cells as f64);
    whole.map(|whole| share * whole)
}

/// True if a cell has more flux in a channel than the `least` one of a source.
pub(super) fn is_source(cell: &[f64; 3], least: [f64; 3]) -> bool {
    (0..3).any(|c| cell[c] > least[c])
}

/// True for a bright cell: one with `F / F_0 * L / L_0 > 0.012` and `L > 8 L_0`.
///
/// F and L are the flux and the radiance of the cell, `F_0` and `L_0` those of the map; `over_whole` is `1 / F_0`. So 1.5e-3
/// of the flux is enough at 8 times the mean radiance, and less beside a sun.
pub(super) fn is_bright(cell: &[f64; 3], over_whole: f64, solid_angle: f64) -> bool {
    let share = cell.iter().sum::<f64>() * over_whole;
    let dense = share * 4.0 * PI;
    dense > CONTRAST * solid_angle && share * dense > WORTH * solid_angle
}

/// Sum rows of pixels of these `widths` into their cells; true if a sample is no radiance, and the sum of the cells.
///
/// A sample with a minus sign counts as no radiance, too.
pub(super) fn add_across(
    cells: &mut [[f64; 3]],
    pixels: &BlockRow<'_>,
    widths: &[f64],
    block: usize,
) -> (bool, [f64; 3]) {
    let mut each = cells.iter_mut();
    let height = pixels.height;
    let has_signs = pixels.mean(|columns, mean| {
        let blocks = mean.as_chunks::<3>().0.chunks(block).zip(widths[columns].chunks(block));
        for ((pixels, widths), cell) in blocks.zip(&mut each) {
            let mut sum = [0.0; 3];
            for (pixel, width) in pixels.iter().zip(widths) {
                (0..3).for_each(|c| sum[c] += f64::from(pixel[c]) * width);
            }
            *cell = sum.map(|sum| sum * height);
        }
    });
    // NaN and infinity persist in every sum.
    let sum = sum(cells);
    (has_signs || !sum.iter().all(|sum| sum.is_finite()), sum)
}

pub(super) fn sum(fluxes: &[[f64; 3]]) -> [f64; 3] {
    fluxes.iter().fold([0.0; 3], |sum, flux| from_fn(|c| sum[c] + flux[c]))
}

/// Cells of each row.
pub(super) fn rows_of<T: Sync>(cells: &Array3<T>) -> impl IndexedParallelIterator<Item = &[[T; 3]]> {
    let samples = cells.as_slice().unwrap_or(&[]); // as it was made, row after row
    samples.as_chunks::<3>().0.par_chunks(cells.dim().1)
}

pub(super) fn rows_mut<T: Send>(cells: &mut Array3<T>) -> impl IndexedParallelIterator<Item = &mut [[T; 3]]> {
    let columns = cells.dim().1;
    let samples = cells.as_slice_mut().unwrap_or(&mut []); // as it was made, row after row
    samples.as_chunks_mut::<3>().0.par_chunks_mut(columns)
}
