//! The sphere in fewer and fewer pixels, on which a membrane is found from the coarsest to the finest.

use rayon::prelude::*;

use crate::interrupt;
use crate::kernels::image::Grid;
use crate::kernels::sphere::band_heights;

/// Red, green, blue, and the bump.
pub type Value = [f32; 4];

/// One image of the sphere: given pixels, and holes to be closed.
pub struct Level {
    pub size: (usize, usize),
    grid: Grid,
    pub values: Vec<Value>,
    pub is_hole: Vec<bool>,
}

impl Level {
    pub fn new(grid: Grid, values: Vec<Value>, is_hole: Vec<bool>) -> Self {
        let size = (grid.theta_edges.len() - 1, grid.phi_edges.len() - 1);
        Self { size, grid, values, is_hole }
    }

    pub fn has_holes(&self) -> bool {
        self.is_hole.contains(&true)
    }

    /// The level with pixels of twice the size: the mean of those that are given; a hole where none is.
    pub fn coarser(&self) -> Self {
        let grid = self.grid.in_blocks(2);
        let size = (grid.theta_edges.len() - 1, grid.phi_edges.len() - 1);
        let bands = band_heights(&self.grid.theta_edges);
        let mut values = vec![[0.0; 4]; size.0 * size.1];
        let mut is_hole = vec![false; values.len()];
        let rows = values.par_chunks_mut(size.1).zip(is_hole.par_chunks_mut(size.1));
        rows.zip(bands.par_chunks(2)).enumerate().for_each(|(row, ((values, is_hole), bands))| {
            for (column, (value, is_hole)) in values.iter_mut().zip(is_hole).enumerate() {
                let (mut sum, mut whole) = ([0.0_f64; 4], 0.0);
                for (row, band) in (2 * row..).zip(bands) {
                    for column in 2 * column..(2 * column + 2).min(self.size.1) {
                        let fine = row * self.size.1 + column;
                        let weight = if self.is_hole[fine] { 0.0 } else { *band };
                        whole += weight;
                        sum.iter_mut().zip(self.values[fine]).for_each(|(s, v)| *s += weight * f64::from(v));
                    }
                }
                *is_hole = whole <= 0.0;
                if whole > 0.0 {
                    *value = sum.map(|sum| (sum / whole) as f32);
                }
            }
        });
        Self { size, grid, values, is_hole }
    }

    /// Start the holes with the values of a coarser level.
    pub fn start_from(&mut self, coarser: &Self) {
        for index in (0..self.values.len()).filter(|&index| self.is_hole[index]) {
            let (row, column) = (index / self.size.1, index % self.size.1);
            self.values[index] = coarser.between(row, column, 2).map(|value| value as f32);
        }
    }

    /// The value at a pixel of an image whose pixels are `factor` times as small, between the four nearest.
    pub fn between(&self, row: usize, column: usize, factor: usize) -> [f64; 4] {
        let (height, width) = self.size;
        let split = |place: usize| {
            let at = (place as f64 + 0.5) / factor as f64 - 0.5;
            (at.floor() as i64, at - at.floor())
        };
        let ((row, down), (column, right)) = (split(row), split(column));
        let rows = [row, row + 1].map(|row| row.clamp(0, height as i64 - 1) as usize * width);
        let columns = [column, column + 1].map(|column| column.rem_euclid(width as i64) as usize);
        let [a, b] = rows.map(|row| columns.map(|column| self.values[row + column]));
        std::array::from_fn(|i| {
            let line = |[left, right_one]: [Value; 2]| {
                let (left, right_one) = (f64::from(left[i]), f64::from(right_one[i]));
                left + right * (right_one - left)
            };
            let (above, below) = (line(a), line(b));
            above + down * (below - above)
        })
    }

    /// Let the holes relax `sweeps` times: each pixel takes the mean of its neighbours (Gauss and Seidel).
    ///
    /// In finite volumes on the sphere, two pixels exchange the length of the side that they share over the
    /// distance of their middles. A row at a pole has no side there. The bump has a source of 1 everywhere.
    pub fn relax(&mut self, sweeps: usize) {
        let (height, width) = self.size;
        let theta = &self.grid.theta_edges;
        let bands = band_heights(theta);
        let middles: Vec<f64> = theta.windows(2).map(|edge| 0.5 * (edge[0] + edge[1])).collect();
        let widths: Vec<f64> = self.grid.phi_edges.windows(2).map(|edge| edge[1] - edge[0]).collect();
        // Conductance of the upper side of each row for a width of 1, and of its left and right sides.
        let up: Vec<f64> = (0..=height)
            .map(|row| match row {
                row if row == 0 || row == height => 0.0,
                row => theta[row].sin() / (middles[row] - middles[row - 1]),
            })
            .collect();
        let side: Vec<f64> =
            (0..height).map(|row| (theta[row + 1] - theta[row]) / middles[row].sin()).collect();
        let holes = (0..self.values.len()).filter(|&index| self.is_hole[index]);
        let holes: Vec<(usize, usize)> = holes.map(|index| (index / width, index % width)).collect();
        for _ in 0..sweeps {
            interrupt::check();
            for &(row, column) in &holes {
                let left = if column > 0 { column - 1 } else { width - 1 };
                let right = if column + 1 < width { column + 1 } else { 0 };
                let own = widths[column];
                let line = row * width;
                let index = line + column;
                let neighbours = [
                    (line + left, 2.0 * side[row] / (own + widths[left])),
                    (line + right, 2.0 * side[row] / (own + widths[right])),
                    (if row > 0 { index - width } else { index }, own * up[row]),
                    (if row + 1 < height { index + width } else { index }, own * up[row + 1]),
                ];
                let mut sum = [0.0, 0.0, 0.0, own * bands[row]];
                let mut whole = 0.0;
                for (neighbour, weight) in neighbours {
                    whole += weight;
                    let value = self.values[neighbour];
                    sum.iter_mut().zip(value).for_each(|(sum, value)| *sum += weight * f64::from(value));
                }
                self.values[index] = sum.map(|sum| (sum / whole) as f32);
            }
        }
    }
}
