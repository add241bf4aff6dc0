//! The sphere in fewer and fewer pixels, on which a membrane is found from the coarsest to the finest.

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
    is_hole: Vec<bool>,
    /// Flat indices of the holes, in ascending order.
    pub holes: Vec<usize>,
}

impl Level {
    /// A level with these holes, in ascending order, of which no value is known.
    pub fn new(grid: Grid, holes: Vec<usize>) -> Self {
        let size @ (height, width) = (grid.theta_edges.len() - 1, grid.phi_edges.len() - 1);
        let mut is_hole = vec![false; height * width];
        for &hole in &holes {
            is_hole[hole] = true;
        }
        Self { size, grid, values: vec![[0.0; 4]; is_hole.len()], is_hole, holes }
    }

    /// The level with pixels of twice the size: a hole where no pixel is given.
    pub fn coarser(&self) -> Self {
        let grid = self.grid.in_blocks(2);
        let columns = grid.phi_edges.len() - 1;
        let mut outer: Vec<usize> = self.holes.iter().map(|&hole| self.outside(columns, hole)).collect();
        outer.sort_unstable();
        outer.dedup();
        outer.retain(|&pixel| self.inside(columns, pixel).all(|fine| self.is_hole[fine]));
        Self::new(grid, outer)
    }

    /// Let each of these pixels, unless it is a hole, be the mean of those given in a level of half its pixels' size.
    pub fn average(&mut self, finer: &Self, pixels: &[usize]) {
        let bands = band_heights(&finer.grid.theta_edges);
        for &pixel in pixels.iter().filter(|&&pixel| !self.is_hole[pixel]) {
            let (mut sum, mut whole) = ([0.0_f64; 4], 0.0);
            for fine in finer.inside(self.size.1, pixel) {
                let weight = if finer.is_hole[fine] { 0.0 } else { bands[fine / finer.size.1] };
                whole += weight;
                sum.iter_mut().zip(finer.values[fine]).for_each(|(s, v)| *s += weight * f64::from(v));
            }
            self.values[pixel] = sum.map(|sum| (sum / whole) as f32);
        }
    }

    /// The pixel of a level with `columns` columns of twice the width in which a pixel lies.
    pub fn outside(&self, columns: usize, pixel: usize) -> usize {
        pixel / self.size.1 / 2 * columns + pixel % self.size.1 / 2
    }

    /// Whether a pixel is a hole.
    pub fn is_hole(&self, pixel: usize) -> bool {
        self.is_hole[pixel]
    }

    /// The pixels inside one of a level with `columns` columns of twice the width.
    pub fn inside(&self, columns: usize, pixel: usize) -> impl Iterator<Item = usize> {
        let (row, column) = (2 * (pixel / columns), 2 * (pixel % columns));
        let (height, width) = self.size;
        let rows = row..(row + 2).min(height);
        rows.flat_map(move |row| (column..(column + 2).min(width)).map(move |column| row * width + column))
    }

    /// A pixel and those around it, across the seam.
    pub fn around(&self, pixel: usize) -> impl Iterator<Item = usize> {
        let (height, width) = self.size;
        let (row, column) = (pixel / width, pixel % width);
        let rows = row.saturating_sub(1)..(row + 2).min(height);
        let left = if column > 0 { column - 1 } else { width - 1 };
        let right = if column + 1 < width { column + 1 } else { 0 };
        rows.flat_map(move |row| [left, column, right].map(|column| row * width + column))
    }

    /// Start the holes with the values of a coarser level.
    pub fn start_from(&mut self, coarser: &Self) {
        let start = coarser.enlarged(2, self.size);
        for &index in &self.holes {
            let (row, column) = (index / self.size.1, index % self.size.1);
            self.values[index] = start.at(row, column).map(|value| value as f32);
        }
    }

    /// The level in pixels that are `factor` times as small, of an image of this size.
    pub fn enlarged(&self, factor: usize, (height, width): (usize, usize)) -> Enlarged<'_> {
        let split = |place: usize| {
            let at = (place as f64 + 0.5) / factor as f64 - 0.5;
            (at.floor() as i64, at - at.floor())
        };
        let last_row = self.size.0 as i64 - 1;
        let row = |row| {
            let (row, down) = split(row);
            ([row, row + 1].map(|row| row.clamp(0, last_row) as usize * self.size.1), down)
        };
        let column = |column| {
            let (column, right) = split(column);
            ([column, column + 1].map(|column| column.rem_euclid(self.size.1 as i64) as usize), right)
        };
        let (rows, columns) = ((0..height).map(row).collect(), (0..width).map(column).collect());
        Enlarged { level: self, rows, columns }
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
        // One over the distance of the middles of each column and the one to its left.
        let beside: Vec<f64> =
            (0..width).map(|column| 2.0 / (widths[column] + widths[(column + width - 1) % width])).collect();
        let holes: Vec<(usize, usize)> =
            self.holes.iter().map(|index| (index / width, index % width)).collect();
        for _ in 0..sweeps {
            interrupt::check();
            for &(row, column) in &holes {
                let left = if column > 0 { column - 1 } else { width - 1 };
                let right = if column + 1 < width { column + 1 } else { 0 };
                let own = widths[column];
                let line = row * width;
                let index = line + column;
                // The left one comes last: it has only just been found.
                let neighbours = [
                    (line + right, side[row] * beside[right]),
                    (if row > 0 { index - width } else { index }, own * up[row]),
                    (if row + 1 < height { index + width } else { index }, own * up[row + 1]),
                    (line + left, side[row] * beside[column]),
                ];
                let mut sum = [0.0, 0.0, 0.0, own * bands[row]];
                let mut whole = 0.0;
                for (neighbour, weight) in neighbours {
                    whole += weight;
                    let value = self.values[neighbour];
                    sum.iter_mut().zip(value).for_each(|(sum, value)| *sum += weight * f64::from(value));
                }
                let share = 1.0 / whole;
                self.values[index] = sum.map(|sum| (sum * share) as f32);
            }
        }
    }
}

/// A level in smaller pixels, each between the four nearest of the level.
pub struct Enlarged<'a> {
    pub level: &'a Level,
    /// The starts of the rows above and below the middle of each row, and the share of the lower one.
    rows: Vec<([usize; 2], f64)>,
    /// The columns beside the middle of each column, and the share of the right one.
    columns: Vec<([usize; 2], f64)>,
}

impl Enlarged<'_> {
    pub fn at(&self, row: usize, column: usize) -> [f64; 4] {
        let ((rows, down), (columns, right)) = (self.rows[row], self.columns[column]);
        let [a, b] = rows.map(|row| columns.map(|column| self.level.values[row + column]));
        std::array::from_fn(|i| {
            let line = |[left, right_one]: [Value; 2]| {
                let (left, right_one) = (f64::from(left[i]), f64::from(right_one[i]));
                left + right * (right_one - left)
            };
            let (above, below) = (line(a), line(b));
            above + down * (below - above)
        })
    }
}
