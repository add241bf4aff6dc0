//! A copy of the map, and the mean of each of its blocks: one pass over the pixels.

use ndarray::{Array3, ArrayView3, Axis};
use rayon::prelude::*;

use crate::interrupt;
use crate::kernels::image::{BlockRow, Grid, luminance_f32};
use crate::kernels::sphere::{Registration, band_heights};

/// A map, and its mean radiance in larger pixels, those in which lights were searched for.
pub struct Working {
    /// The map itself, in standard layout.
    pub map: Array3<f32>,
    /// Rows and columns of the larger pixels.
    pub size: (usize, usize),
    /// Their mean radiance, row after row.
    pub radiance: Vec<[f32; 3]>,
    /// Where they lie.
    pub grid: Grid,
}

impl Working {
    pub fn of(radiance: ArrayView3<'_, f32>, registration: Registration, block: usize) -> Self {
        let (height, width, _) = radiance.dim();
        let pixels = Grid::of_pixels(height, width, registration);
        let grid = pixels.in_blocks(block);
        let size = (grid.theta_edges.len() - 1, grid.phi_edges.len() - 1);
        let mut map = Array3::zeros((height, width, 3));
        let mut means = vec![[0.0; 3]; size.0 * size.1];
        map.axis_chunks_iter_mut(Axis(0), block)
            .into_par_iter()
            .zip(means.par_chunks_mut(size.1))
            .zip(radiance.axis_chunks_iter(Axis(0), block).into_par_iter())
            .enumerate()
            .for_each(|(row, ((mut copy, means), rows))| {
                interrupt::check();
                copy.assign(&rows);
                if block == 1 {
                    let samples = copy.as_slice().unwrap_or_default();
                    means.copy_from_slice(samples.as_chunks::<3>().0);
                } else {
                    fill_means(radiance, &pixels, block, row, means);
                }
            });
        Self { map, size, radiance: means, grid }
    }

    /// Luminance of a pixel.
    pub fn luminance(&self, index: usize) -> f32 {
        luminance_f32(self.radiance[index])
    }

    /// Integral of the luminance over the sphere.
    pub fn flux(&self) -> f64 {
        let widths: Vec<f64> = self.grid.phi_edges.windows(2).map(|edge| edge[1] - edge[0]).collect();
        let row = |(row, band): (usize, f64)| {
            let luminance = (row * self.size.1..(row + 1) * self.size.1).map(|i| self.luminance(i));
            band * luminance.zip(&widths).map(|(y, width)| f64::from(y) * width).sum::<f64>()
        };
        band_heights(&self.grid.theta_edges).into_iter().enumerate().map(row).sum()
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
