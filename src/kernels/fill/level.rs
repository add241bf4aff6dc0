//! One image of the multigrid on which the harmonic fill is solved.

use std::mem::replace;

use glam::{DVec3, Vec3A};

use crate::interrupt;
use crate::kernels::image::Grid;
use crate::kernels::sphere::band_heights;

/// Conductances of the upper and of the right side of each row, for columns of a width and a distance of 1.
///
/// There is one more upper side: the lower one of the last row, a pole, whose conductance is 0.
pub(super) fn conductances(theta_edges: &[f64]) -> [Vec<f64>; 2] {
    let middles: Vec<f64> = theta_edges.windows(2).map(|edge| 0.5 * (edge[0] + edge[1])).collect();
    let inner = middles.windows(2).zip(&theta_edges[1..]);
    let inner = inner.map(|(middle, edge)| edge.sin() / (middle[1] - middle[0]));
    let up = std::iter::once(0.0).chain(inner).chain(std::iter::once(0.0)).collect();
    let side = theta_edges.windows(2).zip(&middles).map(|(edge, middle)| (edge[1] - edge[0]) / middle.sin());
    [up, side.collect()]
}

/// One image of the sphere: known pixels, and holes to fill.
pub struct Level {
    /// Rows and columns.
    pub size: (usize, usize),
    grid: Grid,
    /// Radiance of each pixel.
    pub values: Vec<Vec3A>,
    is_hole: Vec<bool>,
    /// Flat indices of the holes, in ascending order.
    pub holes: Vec<usize>,
}

impl Level {
    /// A level with these holes, in ascending order, before any value is known.
    pub fn new(grid: Grid, holes: Vec<usize>) -> Self {
        let size @ (height, width) = (grid.theta_edges.len() - 1, grid.phi_edges.len() - 1);
        let mut is_hole = vec![false; height * width];
        for &hole in &holes {
            is_hole[hole] = true;
        }
        Self { size, grid, values: vec![Vec3A::ZERO; is_hole.len()], is_hole, holes }
    }

    /// The level with pixels of twice the size. A pixel is a hole if all pixels inside it are.
    pub fn coarser(&self) -> Self {
        let grid = self.grid.in_blocks(2);
        let columns = grid.phi_edges.len() - 1;
        let is_first = |&&hole: &&usize| {
            [hole / self.size.1, hole % self.size.1].iter().all(|position| position.is_multiple_of(2))
        };
        let outer = self.holes.iter().filter(is_first).map(|&hole| self.parent(columns, hole));
        let outer =
            outer.filter(|&pixel| self.children(columns, pixel).all(|fine| self.is_hole[fine])).collect();
        Self::new(grid, outer)
    }

    /// Set each of these pixels, unless it is a hole, to the mean of the known pixels inside it on a finer level.
    pub fn average(&mut self, finer: &Self, pixels: &[usize]) {
        let bands = band_heights(&finer.grid.theta_edges);
        for &pixel in pixels.iter().filter(|&&pixel| !self.is_hole[pixel]) {
            let (mut sum, mut whole) = (DVec3::ZERO, 0.0);
            for fine in finer.children(self.size.1, pixel).filter(|&fine| !finer.is_hole[fine]) {
                let weight = bands[fine / finer.size.1];
                whole += weight;
                sum += weight * finer.values[fine].as_dvec3();
            }
            self.values[pixel] = (sum / whole).as_vec3a();
        }
    }

    /// The pixel that contains `pixel` on the coarser level, which has `columns` columns.
    pub fn parent(&self, columns: usize, pixel: usize) -> usize {
        pixel / self.size.1 / 2 * columns + pixel % self.size.1 / 2
    }

    /// True for a hole.
    pub fn is_hole(&self, pixel: usize) -> bool {
        self.is_hole[pixel]
    }

    /// The pixels of this level inside `pixel` of the coarser level, which has `columns` columns.
    pub fn children(&self, columns: usize, pixel: usize) -> impl Iterator<Item = usize> {
        let (row, column) = (2 * (pixel / columns), 2 * (pixel % columns));
        let (height, width) = self.size;
        let rows = row..(row + 2).min(height);
        rows.flat_map(move |row| (column..(column + 2).min(width)).map(move |column| row * width + column))
    }

    /// Mark some pixels and their eight neighbours, across the seam.
    pub fn mark_around(&self, pixels: &[usize], is_marked: &mut [bool]) {
        let (height, width) = self.size;
        // Mark each run of neighbours in a row at once.
        for run in pixels.chunk_by(|&one, &other| other == one + 1 && other % width > 0) {
            let (row, first) = (run[0] / width, run[0] % width);
            let end = first + run.len();
            for row in row.saturating_sub(1)..(row + 2).min(height) {
                let is_marked = &mut is_marked[row * width..(row + 1) * width];
                is_marked[first.saturating_sub(1)..(end + 1).min(width)].fill(true);
                is_marked[if first > 0 { first - 1 } else { width - 1 }] = true;
                is_marked[if end < width { end } else { 0 }] = true;
            }
        }
    }

    /// Start the holes from the values of a coarser level.
    pub fn start_from(&mut self, coarser: &Self) {
        let (start, width) = (Upsampling::new(coarser, 2, self.size), self.size.1);
        for row in self.holes.chunk_by(|one, other| one / width == other / width) {
            let values = start.row(row[0] / width);
            for &hole in row {
                self.values[hole] = values.at(hole % width);
            }
        }
    }

    /// Holes inside pixels of a `coarser` level that are at most `steps` steps from a rim there.
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
        let is_near = |&hole: &usize| !is_far[self.parent(coarser.size.1, hole)];
        self.holes.iter().copied().filter(is_near).collect()
    }

    /// The four direct neighbours of a pixel, across the seam: left, right, above, below.
    fn around(&self, at: usize) -> [usize; 4] {
        let (height, width) = self.size;
        let (row, column) = (at / width, at % width);
        let left = if column > 0 { at - 1 } else { at + width - 1 };
        let right = if column + 1 < width { at + 1 } else { at + 1 - width };
        let above = if row > 0 { at - width } else { at };
        let below = if row + 1 < height { at + width } else { at };
        [left, right, above, below]
    }

    /// Relax some holes for a number of sweeps of Gauss and Seidel: each takes the mean of its neighbours.
    ///
    /// Finite volumes on the sphere give the weights. The conductance between two pixels is the length of their common
    /// side over the distance of their centres. It is 0 at the poles.
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
        let (width, widths) = (self.size.1, self.grid.widths());
        let [up, side] = conductances(&self.grid.theta_edges);
        let stencil = |&at: &usize| {
            let (row, column) = (at / width, at % width);
            let [left, right, above, below] = self.around(at);
            let own = widths[column];
            let beside = |other: usize| 2.0 * side[row] / (own + widths[other % width]);
            let conductances = [beside(left), own * up[row], own * up[row + 1]];
            let over = 1.0 / (conductances.iter().sum::<f64>() + beside(right));
            Stencil {
                at: at as u32,
                right: right as u32,
                others: [left, above, below].map(|at| at as u32),
                weights: conductances.map(|conductance| (over * conductance) as f32),
            }
        };
        // Relax the black pixels of a chessboard first: none of them needs another one.
        let is_black = |&&at: &&usize| (at / width + at % width).is_multiple_of(2);
        let (black, white): (Vec<&usize>, Vec<&usize>) = holes.iter().partition(is_black);
        black.into_iter().chain(white).map(stencil).collect()
    }
}

/// Weights of the four neighbours of a pixel in its mean.
struct Stencil {
    at: u32,
    right: u32,
    /// The left, upper and lower neighbours.
    others: [u32; 3],
    /// Their weights; all four add up to 1.
    weights: [f32; 3],
}

impl Stencil {
    /// Mean of the neighbours, summed as differences from the right one, so that equal neighbours give exactly their
    /// value. Rounding cannot make it negative, because the right one has at least a quarter of the weight.
    fn mean(&self, values: &[Vec3A]) -> Vec3A {
        let [right, left, up, down] =
            [self.right, self.others[0], self.others[1], self.others[2]].map(|at| values[at as usize]);
        let [to_left, to_up, to_down] = self.weights;
        right + (left - right) * to_left + (up - right) * to_up + (down - right) * to_down
    }
}

/// A level at a higher resolution, by linear interpolation between its pixel centres.
pub struct Upsampling<'a> {
    level: &'a Level,
    rows: Vec<Neighbours>,
    columns: Vec<Neighbours>,
}

/// Two rows or columns of a level on both sides of a smaller pixel, and the weight of the second.
type Neighbours = (usize, usize, f32);

/// One row of smaller pixels.
pub struct FineRow<'a> {
    rows: [&'a [Vec3A]; 2],
    weight: f32,
    columns: &'a [Neighbours],
}

impl<'a> Upsampling<'a> {
    /// Upsample a level by a whole `factor` to this number of rows and columns.
    pub fn new(level: &'a Level, factor: usize, (height, width): (usize, usize)) -> Self {
        let (last_row, last_column) = (level.size.0 - 1, level.size.1 - 1);
        let rows = (0..height).map(|row| {
            let (second, weight) = second(row, factor);
            (second.saturating_sub(1), second.min(last_row), weight)
        });
        let columns = (0..width).map(|column| {
            let (second, weight) = second(column, factor);
            let first = if second > 0 { second - 1 } else { last_column };
            (first, if second > last_column { 0 } else { second }, weight)
        });
        Self { level, rows: rows.collect(), columns: columns.collect() }
    }

    /// One row of smaller pixels.
    pub fn row(&self, row: usize) -> FineRow<'_> {
        let (above, below, weight) = self.rows[row];
        let width = self.level.size.1;
        let rows = [above, below].map(|row| &self.level.values[row * width..(row + 1) * width]);
        FineRow { rows, weight, columns: &self.columns }
    }
}

impl FineRow<'_> {
    /// Value at a column.
    #[inline]
    pub fn at(&self, column: usize) -> Vec3A {
        let (left, right, weight) = self.columns[column];
        let [above, below] = self.rows;
        let between = |column: usize| interpolate(above[column], below[column], self.weight);
        interpolate(between(left), between(right), weight)
    }
}

/// Index and weight of the first pixel whose centre lies after the centre of a pixel `factor` times as small.
fn second(small: usize, factor: usize) -> (usize, f32) {
    let offset = ((small % factor) as f32 + 0.5) / factor as f32 - 0.5;
    if offset < 0.0 { (small / factor, offset + 1.0) } else { (small / factor + 1, offset) }
}

/// Linear interpolation that is exact between equal values.
#[inline]
fn interpolate(first: Vec3A, second: Vec3A, weight: f32) -> Vec3A {
    first + weight * (second - first)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernels::sphere::Registration;

    #[test]
    fn a_hole_many_steps_from_a_rim_is_not_near_it() {
        let grid = Grid::of_pixels(64, 128, Registration::CellCentred);
        // Use a hole across the seam.
        let is_hole = |row: usize, column: usize| (10..54).contains(&row) && !(24..104).contains(&column);
        let holes = (0..64 * 128).filter(|pixel| is_hole(pixel / 128, pixel % 128)).collect();
        let fine = Level::new(grid, holes);
        let near = fine.near_rim(&fine.coarser(), 2);
        for &hole in &fine.holes {
            let (row, column) = (hole / 128, (hole + 64) % 128);
            // Count pixels to the rim from 1 on; a coarser pixel is two pixels wide.
            let steps = (row - 9).min(54 - row).min(column - 39).min(88 - column);
            assert_eq!(near.contains(&hole), steps <= 6, "row {row}, column {column}");
        }
    }

    /// Columns are a circle, rows are not.
    #[test]
    fn a_pixel_is_marked_with_its_neighbours_across_the_seam() {
        let level = Level::new(Grid::of_pixels(4, 8, Registration::CellCentred), Vec::new());
        for pixel in 0..32 {
            let mut is_marked = vec![false; 32];
            level.mark_around(&[pixel], &mut is_marked);
            for (other, is_marked) in is_marked.into_iter().enumerate() {
                let [rows, columns] = [(other / 8).abs_diff(pixel / 8), (other % 8).abs_diff(pixel % 8)];
                assert_eq!(is_marked, rows <= 1 && matches!(columns, 0 | 1 | 7), "{pixel} {other}");
            }
        }
    }

    /// A value linear in the row and in the column, different in each channel.
    fn ramp(row: f32, column: f32) -> Vec3A {
        3.0 * row + 5.0 * column + Vec3A::new(0.0, 100.0, 200.0)
    }

    #[test]
    fn smaller_pixels_lie_on_the_ramp_between_the_larger_ones() {
        let mut level = Level::new(Grid::of_pixels(8, 16, Registration::CellCentred), Vec::new());
        for (at, value) in level.values.iter_mut().enumerate() {
            *value = ramp((at / 16) as f32, (at % 16) as f32);
        }
        for factor in [1, 2, 3, 4, 5, 8] {
            let upsampled = Upsampling::new(&level, factor, (8 * factor, 16 * factor));
            let position = |small: usize| (small as f32 + 0.5) / factor as f32 - 0.5;
            for row in factor..7 * factor {
                for column in factor..15 * factor {
                    let expected = ramp(position(row), position(column));
                    assert!(upsampled.row(row).at(column).abs_diff_eq(expected, 1e-3));
                }
            }
        }
    }

    #[test]
    fn the_two_ends_of_a_row_meet_at_the_seam() {
        let mut level = Level::new(Grid::of_pixels(8, 16, Registration::CellCentred), Vec::new());
        level.values[..16].fill(Vec3A::ONE);
        level.values[15] = 9.0 * Vec3A::ONE;
        let upsampled = Upsampling::new(&level, 2, (16, 32));
        let row = upsampled.row(0);
        let values = [0, 1, 30, 31].map(|column| row.at(column).x.to_bits());
        assert_eq!(values, [3.0_f32, 1.0, 7.0, 7.0].map(f32::to_bits));
    }
}
