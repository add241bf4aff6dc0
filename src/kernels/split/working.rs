//! The mean of each block of the map's pixels: one pass over them.

use ndarray::ArrayView3;
use rayon::prelude::*;

use crate::interrupt;
use crate::kernels::image::{BlockRow, Grid, luminance_f32, samples_of};
use crate::kernels::sphere::{Registration, band_heights};

/// A map in larger pixels, those in which lights were searched for.
pub struct Working {
    /// Rows and columns of the larger pixels.
    pub size: (usize, usize),
    /// Their mean radiance, row after row.
    pub radiance: Vec<[f32; 3]>,
    /// Where they lie.
    pub grid: Grid,
    /// Integral of the luminance over the sphere.
    pub flux: f64,
}

impl Working {
    pub fn of(radiance: ArrayView3<'_, f32>, registration: Registration, block: usize) -> Self {
        let (height, width, _) = radiance.dim();
        let pixels = Grid::of_pixels(height, width, registration);
        let grid = pixels.in_blocks(block);
        let size = (grid.theta_edges.len() - 1, grid.phi_edges.len() - 1);
        let widths: Vec<f64> = grid.phi_edges.windows(2).map(|edge| edge[1] - edge[0]).collect();
        let mut means = vec![[0.0; 3]; size.0 * size.1];
        let fluxes: Vec<f64> = means
            .par_chunks_mut(size.1)
            .zip(band_heights(&grid.theta_edges))
            .enumerate()
            .map(|(row, (means, band))| {
                interrupt::check();
                if block == 1 {
                    let samples = samples_of(radiance, row..row + 1);
                    means.copy_from_slice(samples.as_chunks::<3>().0);
                } else {
                    fill_means(radiance, &pixels, block, row, means);
                }
                let luminance = means.iter().map(|&mean| f64::from(luminance_f32(mean)));
                band * luminance.zip(&widths).map(|(y, width)| y * width).sum::<f64>()
            })
            .collect();
        Self { size, radiance: means, grid, flux: fluxes.into_iter().sum() }
    }

    /// Luminance of a pixel.
    pub fn luminance(&self, index: usize) -> f32 {
        luminance_f32(self.radiance[index])
    }

    /// The eight pixels around one, across the seam and the poles.
    pub fn around(&self, index: usize) -> [usize; 8] {
        let (height, width) = self.size;
        let (row, column) = (index / width, index % width);
        let (left, right) = ((column + width - 1) % width, (column + 1) % width);
        let across = |column: usize| (column + width / 2) % width;
        let line = |row: usize, beyond: bool| {
            [left, column, right].map(|column| row * width + if beyond { across(column) } else { column })
        };
        let up = line(row.saturating_sub(1), row == 0);
        let down = line((row + 1).min(height - 1), row + 1 == height);
        [up[0], up[1], up[2], row * width + left, row * width + right, down[0], down[1], down[2]]
    }
}

/// Mean radiance of each block of a row of blocks, by solid angle.
fn fill_means(
    radiance: ArrayView3<'_, f32>,
    pixels: &Grid,
    block: usize,
    row: usize,
    means: &mut [[f32; 3]],
) {
    let widths: Vec<f32> = pixels.phi_edges.windows(2).map(|edge| (edge[1] - edge[0]) as f32).collect();
    let rows = BlockRow::new(radiance, &pixels.theta_edges, block, row);
    rows.mean(|columns, samples| {
        let samples = samples.as_chunks::<3>().0.chunks(block);
        let blocks = samples.zip(widths[columns.clone()].chunks(block));
        for (mean, (samples, widths)) in means[columns.start / block..].iter_mut().zip(blocks) {
            let whole: f32 = widths.iter().sum();
            *mean = [0, 1, 2].map(|channel| {
                samples.iter().zip(widths).map(|(sample, width)| sample[channel] * width).sum::<f32>() / whole
            });
        }
    });
}
