//! The sphere in fewer and fewer pixels, on which a membrane is found from the coarsest to the finest.
#![allow(clippy::inline_always, reason = "what is not inlined is compiled for the oldest of processors")]

use std::mem::replace;

use glam::Vec4;

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
        // The first pixel inside of a hole is one.
        let is_first = |&&hole: &&usize| {
            [hole / self.size.1, hole % self.size.1].iter().all(|place| place.is_multiple_of(2))
        };
        let outer = self.holes.iter().filter(is_first).map(|&hole| self.outside(columns, hole));
        let outer =
            outer.filter(|&pixel| self.inside(columns, pixel).all(|fine| self.is_hole[fine])).collect();
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

    /// Mark some pixels and those around each, across the seam.
    pub fn mark_around(&self, pixels: &[usize], is_marked: &mut [bool]) {
        let (height, width) = self.size;
        // Those side by side in a row together.
        for side_by_side in pixels.chunk_by(|&one, &other| other == one + 1 && other % width > 0) {
            let (row, first) = (side_by_side[0] / width, side_by_side[0] % width);
            let end = first + side_by_side.len();
            for row in row.saturating_sub(1)..(row + 2).min(height) {
                let is_marked = &mut is_marked[row * width..(row + 1) * width];
                is_marked[first.saturating_sub(1)..(end + 1).min(width)].fill(true);
                is_marked[if first > 0 { first - 1 } else { width - 1 }] = true;
                is_marked[if end < width { end } else { 0 }] = true;
            }
        }
    }

    /// Start the holes with the values of a coarser level.
    pub fn start_from(&mut self, coarser: &Self) {
        let start = Enlarged::new(coarser, 2, self.size.1);
        for &index in &self.holes {
            self.values[index] = start.at(index / self.size.1, index % self.size.1);
        }
    }

    /// The holes inside pixels of a `coarser` level that are at most so many steps from a rim there.
    pub fn near_rim(&self, coarser: &Self, steps: usize) -> Vec<usize> {
        let mut is_far = coarser.is_hole.clone();
        let beside = |&hole: &usize| coarser.around(hole).iter().any(|&at| !coarser.is_hole[at]);
        let mut front: Vec<usize> = coarser.holes.iter().copied().filter(beside).collect();
        for &hole in &front {
            is_far[hole] = false;
        }
        for _ in 0..steps {
            let around = front.iter().flat_map(|&hole| coarser.around(hole));
            front = around.filter(|&hole| replace(&mut is_far[hole], false)).collect();
        }
        let is_near = |&hole: &usize| !is_far[self.outside(coarser.size.1, hole)];
        self.holes.iter().copied().filter(is_near).collect()
    }

    /// The pixels at the four sides of one, across the seam.
    fn around(&self, at: usize) -> [usize; 4] {
        let (height, width) = self.size;
        let (row, column) = (at / width, at % width);
        let left = if column > 0 { at - 1 } else { at + width - 1 };
        let right = if column + 1 < width { at + 1 } else { at + 1 - width };
        let above = if row > 0 { at - width } else { at };
        let below = if row + 1 < height { at + width } else { at };
        [left, right, above, below]
    }

    /// Let some holes relax `sweeps` times: each pixel takes the mean of its neighbours (Gauss and Seidel, every second
    /// pixel first).
    ///
    /// In finite volumes on the sphere, two pixels exchange the length of the side that they share over the
    /// distance of their middles. A row at a pole has no side there. The bump has a source of 1 everywhere.
    pub fn relax(&mut self, holes: &[usize], sweeps: usize) {
        let stencils = self.stencils(holes);
        for _ in 0..sweeps {
            interrupt::check();
            for stencil in &stencils {
                self.values[stencil.at as usize] = stencil.mean(&self.values);
            }
        }
    }

    fn stencils(&self, holes: &[usize]) -> Vec<Stencil> {
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
        let stencil = |&at: &usize| {
            let (row, column) = (at / width, at % width);
            let [left, right, above, below] = self.around(at);
            let own = widths[column];
            let beside = |other: usize| 2.0 * side[row] / (own + widths[other % width]);
            let conductances = [beside(left), own * up[row], own * up[row + 1]];
            let share = 1.0 / (conductances.iter().sum::<f64>() + beside(right));
            Stencil {
                at: at as u32,
                right: right as u32,
                others: [left, above, below].map(|at| at as u32),
                weights: conductances.map(|conductance| (share * conductance) as f32),
                source: (share * own * bands[row]) as f32,
            }
        };
        // Take every second pixel first, as on a chessboard: none waits for the one before it.
        let is_black = |&&at: &&usize| (at / width + at % width).is_multiple_of(2);
        let (black, white): (Vec<&usize>, Vec<&usize>) = holes.iter().partition(is_black);
        black.into_iter().chain(white).map(stencil).collect()
    }
}

/// A pixel, and what it takes from those around it.
struct Stencil {
    at: u32,
    /// The pixel at its right.
    right: u32,
    /// The pixels at its left, above and below.
    others: [u32; 3],
    /// Their shares; what is missing to 1 is that of the right one.
    weights: [f32; 3],
    /// What the bump gains.
    source: f32,
}

impl Stencil {
    /// The mean of the neighbours, which is exact where they are alike, for it starts from one of them. That is the
    /// right one: it has a fourth at least, so that rounding takes nothing below 0.
    fn mean(&self, values: &[Value]) -> Value {
        let [right, left, up, down] = [self.right, self.others[0], self.others[1], self.others[2]]
            .map(|at| Vec4::from_array(values[at as usize]));
        let [to_left, to_up, to_down] = self.weights;
        let beside = right + (left - right) * to_left;
        (beside + (up - right) * to_up + (down - right) * to_down + Vec4::W * self.source).to_array()
    }
}

/// A level in smaller pixels, each between the four nearest of the level.
struct Enlarged<'a> {
    level: &'a Level,
    /// How many of them lie along the side of a pixel.
    factor: usize,
    /// Between which columns of the level each of the smaller ones lies.
    columns: Vec<Between>,
}

/// Between two pixels side by side, or one above the other: the second of them, and its share.
type Between = (usize, f32);

impl<'a> Enlarged<'a> {
    /// A level in pixels that are `factor` times as small, in so many `columns` at most.
    fn new(level: &'a Level, factor: usize, columns: usize) -> Self {
        let columns = (0..columns).map(|column| after(column, factor)).collect();
        Self { level, factor, columns }
    }

    fn at(&self, row: usize, column: usize) -> Value {
        let ((right, share), width) = (self.columns[column], self.level.size.1);
        let left = if right > 0 { right - 1 } else { width - 1 };
        let right = if right < width { right } else { 0 };
        let rows = after(row, self.factor);
        between(self.in_rows(rows, left), self.in_rows(rows, right), share).to_array()
    }

    /// The value of a column of the level between two of its rows.
    #[inline(always)]
    fn in_rows(&self, (below, share): Between, column: usize) -> Value {
        let (height, width) = self.level.size;
        let [above, below] = [below.saturating_sub(1), below.min(height - 1)].map(|row| row * width + column);
        between(self.level.values[above], self.level.values[below], share).to_array()
    }
}

/// The first pixel whose middle is beyond that of one of pixels `factor` times as small, and how far that one is on the
/// way there from the pixel before.
#[inline(always)]
pub fn after(place: usize, factor: usize) -> Between {
    let share = ((place % factor) as f32 + 0.5) / factor as f32 - 0.5;
    if share < 0.0 { (place / factor, share + 1.0) } else { (place / factor + 1, share) }
}

/// A value on the way from one to another.
#[inline(always)]
fn between(one: Value, other: Value, share: f32) -> Vec4 {
    let (one, other) = (Vec4::from_array(one), Vec4::from_array(other));
    one + share * (other - one)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernels::sphere::Registration;

    #[test]
    fn what_is_many_steps_from_a_rim_is_not_near_it() {
        let grid = Grid::of_pixels(64, 128, Registration::CellCentred);
        // Across the seam.
        let is_hole = |row: usize, column: usize| (10..54).contains(&row) && !(24..104).contains(&column);
        let places = (0..64).flat_map(|row| (0..128).map(move |column| (row, column)));
        let places = places.filter(|&(row, column)| is_hole(row, column));
        let fine = Level::new(grid, places.map(|(row, column)| row * 128 + column).collect());
        let near = fine.near_rim(&fine.coarser(), 2);
        for &hole in &fine.holes {
            let (row, column) = (hole / 128, (hole + 64) % 128);
            // Pixels to the rim, from 1 on; those of the coarser level come in pairs.
            let steps = (row - 9).min(54 - row).min(column - 39).min(88 - column);
            assert_eq!(near.contains(&hole), steps <= 6, "row {row}, column {column}");
        }
    }
}
