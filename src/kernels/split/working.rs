//! The map in the larger pixels in which its lights were found: each is read only where it is asked for.

use glam::DVec3;

use crate::kernels::image::{Grid, luminance_f32};
use crate::kernels::sphere::{Registration, band_heights};

/// A map in larger pixels. Few of them lie near a light, so none is stored.
pub struct Working<'a> {
    /// The pixels of the map itself, row after row.
    pixels: &'a [[f32; 3]],
    /// Rows and columns of the larger pixels.
    pub size: (usize, usize),
    /// Where they lie.
    pub grid: Grid,
    /// Pixels of the map along each of their sides.
    block: usize,
    /// `cos theta_top - cos theta_bottom` of each row of the map, and the width of each column.
    bands: Vec<f64>,
    widths: Vec<f64>,
    /// Sine and cosine of the middle of each row and column of the larger pixels.
    rows: Vec<(f64, f64)>,
    columns: Vec<(f64, f64)>,
}

impl<'a> Working<'a> {
    /// A map of this height and width, in pixels of `block` x `block` of its own.
    pub fn of(
        map: &'a [[f32; 3]],
        (height, width): (usize, usize),
        registration: Registration,
        block: usize,
    ) -> Self {
        let pixels = Grid::of_pixels(height, width, registration);
        let grid = pixels.in_blocks(block);
        let middles = |edges: &[f64]| -> Vec<(f64, f64)> {
            edges.windows(2).map(|edge| (0.5 * (edge[0] + edge[1])).sin_cos()).collect()
        };
        let (rows, columns) = (middles(&grid.theta_edges), middles(&grid.phi_edges));
        Self {
            pixels: map,
            size: (rows.len(), columns.len()),
            grid,
            block,
            bands: band_heights(&pixels.theta_edges),
            widths: pixels.phi_edges.windows(2).map(|edge| edge[1] - edge[0]).collect(),
            rows,
            columns,
        }
    }

    /// Mean radiance of a pixel, by solid angle.
    pub fn mean(&self, index: usize) -> [f32; 3] {
        let [row, column] = [index / self.size.1, index % self.size.1].map(|place| place * self.block);
        let rows = row..(row + self.block).min(self.bands.len());
        let columns = column..(column + self.block).min(self.widths.len());
        let (mut sum, mut whole) = ([0.0; 3], 0.0);
        for row in rows {
            let pixels = &self.pixels[row * self.widths.len()..][columns.clone()];
            for (pixel, width) in pixels.iter().zip(&self.widths[columns.clone()]) {
                let solid_angle = self.bands[row] * width;
                whole += solid_angle;
                sum.iter_mut().zip(pixel).for_each(|(sum, &value)| *sum += solid_angle * f64::from(value));
            }
        }
        sum.map(|sum| (sum / whole) as f32)
    }

    /// Luminance of a pixel.
    pub fn luminance(&self, index: usize) -> f32 {
        luminance_f32(self.mean(index))
    }

    /// Direction of the middle of a pixel.
    pub fn centre(&self, index: usize) -> DVec3 {
        let ((sin, cos), (sin_phi, cos_phi)) =
            (self.rows[index / self.size.1], self.columns[index % self.size.1]);
        DVec3::new(sin_phi * sin, cos, -cos_phi * sin)
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
