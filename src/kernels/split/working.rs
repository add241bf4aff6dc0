//! The map in the larger pixels in which its lights were found: each is read only where it is asked for.

use std::borrow::Cow;
use std::f64::consts::{PI, TAU};

use glam::{DVec3, Vec4};
use rayon::prelude::*;

use crate::interrupt;
use crate::kernels::image::{Grid, luminance_f32};
use crate::kernels::sphere::{Registration, band_heights};

/// A larger pixel.
#[derive(Clone, Copy)]
pub struct Place {
    /// Its flat index.
    pub index: usize,
    row: usize,
    column: usize,
}

/// A map in larger pixels. Few of them lie near a light, so no mean radiance is stored.
pub struct Working<'a> {
    /// The pixels of the map itself, row after row.
    pixels: &'a [[f32; 3]],
    /// Rows and columns of the larger pixels.
    pub size: (usize, usize),
    /// Where they lie.
    pub grid: Grid,
    /// Their luminance.
    luminance: Cow<'a, [f32]>,
    /// Pixels of the map along each of their sides.
    block: usize,
    /// Share of each row and column of the map in the larger pixels that it is in.
    row_shares: Vec<f32>,
    column_shares: Vec<f32>,
    /// Sine and cosine of the middle of each row and column of the larger pixels.
    rows: Vec<(f64, f64)>,
    columns: Vec<(f64, f64)>,
}

impl<'a> Working<'a> {
    /// A map of this height and width, in pixels of `block` x `block` of its own. Their luminance is measured if it is not
    /// known.
    pub fn of(
        map: &'a [[f32; 3]],
        (height, width): (usize, usize),
        registration: Registration,
        block: usize,
        luminance: Option<&'a [f32]>,
    ) -> Self {
        let pixels = Grid::of_pixels(height, width, registration);
        let grid = pixels.in_blocks(block);
        let middles = |edges: &[f64]| -> Vec<(f64, f64)> {
            edges.windows(2).map(|edge| (0.5 * (edge[0] + edge[1])).sin_cos()).collect()
        };
        let widths: Vec<f64> = pixels.phi_edges.windows(2).map(|edge| edge[1] - edge[0]).collect();
        let (rows, columns) = (middles(&grid.theta_edges), middles(&grid.phi_edges));
        let mut working = Self {
            pixels: map,
            size: (rows.len(), columns.len()),
            grid,
            luminance: Cow::Borrowed(luminance.unwrap_or_default()),
            block,
            row_shares: shares(&band_heights(&pixels.theta_edges), block),
            column_shares: shares(&widths, block),
            rows,
            columns,
        };
        if luminance.is_none() {
            working.luminance = Cow::Owned(working.measured());
        }
        working
    }

    /// The luminance of each pixel.
    fn measured(&self) -> Vec<f32> {
        let pixels = (0..self.size.0 * self.size.1).into_par_iter().with_min_len(self.size.1);
        let luminance = |pixel| {
            if pixel % self.size.1 == 0 {
                interrupt::check();
            }
            luminance_f32(self.mean(self.place(pixel)))
        };
        pixels.map(luminance).collect()
    }

    /// How many pixels have a known luminance: all, if it is that of this map.
    pub fn luminances(&self) -> usize {
        self.luminance.len()
    }

    /// The pixel of this flat index.
    pub fn place(&self, index: usize) -> Place {
        Place { index, row: index / self.size.1, column: index % self.size.1 }
    }

    /// Mean radiance of a pixel, by solid angle.
    pub fn mean(&self, Place { row, column, .. }: Place) -> [f32; 3] {
        let [row, column] = [row, column].map(|place| place * self.block);
        let rows = row..(row + self.block).min(self.row_shares.len());
        let columns = column..(column + self.block).min(self.column_shares.len());
        // The mean of differences from the first pixel: exact where all are alike.
        let first = rgb(self.pixels[row * self.column_shares.len() + column]);
        let mut sum = Vec4::ZERO;
        for row in rows {
            let start = row * self.column_shares.len();
            let pixels = &self.pixels[start + columns.start..start + columns.end];
            let shares = &self.column_shares[columns.clone()];
            let line = pixels.iter().zip(shares).map(|(&pixel, &share)| share * (rgb(pixel) - first));
            sum += self.row_shares[row] * line.sum::<Vec4>();
        }
        (first + sum).truncate().to_array()
    }

    /// Luminance of a pixel.
    pub fn luminance(&self, place: Place) -> f32 {
        self.luminance[place.index]
    }

    /// Direction of the middle of a pixel.
    pub fn centre(&self, place: Place) -> DVec3 {
        let ((sin, cos), (sin_phi, cos_phi)) = (self.rows[place.row], self.columns[place.column]);
        DVec3::new(sin_phi * sin, cos, -cos_phi * sin)
    }

    /// Solid angle of a pixel, nearly.
    pub fn solid_angle(&self, place: Place) -> f64 {
        let (height, width) = self.size;
        PI / height as f64 * TAU / width as f64 * self.rows[place.row].0
    }

    /// Whether a pixel and all around it are some for which this holds; not told at the seam and the poles.
    pub fn is_inside(&self, pixel: usize, holds: impl Fn(usize) -> bool) -> bool {
        let (height, width) = self.size;
        let is_at_end = pixel < width || pixel + width >= height * width;
        let is_at_seam = pixel.is_multiple_of(width) || (pixel + 1).is_multiple_of(width);
        let rows = [pixel.wrapping_sub(width), pixel, pixel + width];
        !is_at_end && !is_at_seam && rows.into_iter().all(|middle| (middle - 1..=middle + 1).all(&holds))
    }

    /// The eight pixels around one, across the seam and the poles.
    pub fn around(&self, Place { row, column, .. }: Place) -> [Place; 8] {
        let (height, width) = self.size;
        let left = if column > 0 { column - 1 } else { width - 1 };
        let right = if column + 1 < width { column + 1 } else { 0 };
        let beside = |row: usize| [left, column, right].map(|column| (row, column));
        // Beyond a pole lies the same row, half a turn away.
        let across = || beside(row).map(|(row, column)| (row, (column + width / 2) % width));
        let up = if row > 0 { beside(row - 1) } else { across() };
        let down = if row + 1 < height { beside(row + 1) } else { across() };
        [up[0], up[1], up[2], (row, left), (row, right), down[0], down[1], down[2]]
            .map(|(row, column)| Place { index: row * width + column, row, column })
    }
}

fn rgb([red, green, blue]: [f32; 3]) -> Vec4 {
    Vec4::new(red, green, blue, 0.0)
}

/// The share of each of these sizes in the sum of its block.
fn shares(sizes: &[f64], block: usize) -> Vec<f32> {
    let of_block = |sizes: &'_ [f64]| {
        let whole: f64 = sizes.iter().sum();
        sizes.iter().map(|size| (size / whole) as f32).collect::<Vec<f32>>()
    };
    sizes.chunks(block).flat_map(of_block).collect()
}
