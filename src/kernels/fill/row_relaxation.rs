//! Relaxation of whole rows of holes, for multigrid.
//!
//! Finite volumes on the sphere give the equation: the sum of the flows from the four neighbours of a hole into it is
//! minus a source. A flow is a difference of values times a conductance: the length of the common side over the distance
//! of the centres. It is 0 at the poles. Differences keep a constant image exact.

use super::level::conductances;
use crate::interrupt;
use crate::kernels::image::Grid;

/// Adjacent holes of one row, perhaps across the seam, with the factors of their tridiagonal matrix.
pub struct HoleRun {
    row: usize,
    first: usize,
    /// Pivots of Gaussian elimination.
    pivots: Vec<f64>,
    /// Solution for the corner of the matrix of a whole ring (Sherman and Morrison 1950); empty for others.
    corner: Vec<f64>,
}

/// Image of the sphere with holes, and the equation of each hole.
pub struct RowRelaxation {
    /// Rows and columns.
    pub size: (usize, usize),
    /// Runs of holes, row after row.
    pub runs: Vec<HoleRun>,
    grid: Grid,
    is_hole: Vec<bool>,
    /// Conductance of the upper side of each row for a width of 1, and 0 below the last.
    up: Vec<f64>,
    /// Conductance of the right side of each row for columns at a distance of 1.
    side: Vec<f64>,
    /// One over the distance of each column to the next, across the seam.
    per_distance: Vec<f64>,
    widths: Vec<f64>,
}

impl RowRelaxation {
    /// The equations of an image with these holes.
    pub fn new(grid: Grid, is_hole: Vec<bool>) -> Self {
        let [up, side] = conductances(&grid.theta_edges);
        let widths = grid.widths();
        let next = widths.iter().skip(1).chain(widths.first());
        let per_distance = widths.iter().zip(next).map(|(own, next)| 2.0 / (own + next)).collect();
        let size = (side.len(), widths.len());
        let mut image = Self { size, runs: Vec::new(), grid, is_hole, up, side, per_distance, widths };
        image.runs = (0..size.0).flat_map(|row| image.runs_of(row)).collect();
        image
    }

    /// The image with pixels of twice the size. A pixel is a hole if all pixels inside it are.
    pub fn coarser(&self) -> Self {
        let grid = self.grid.in_blocks(2);
        let columns = grid.phi_edges.len() - 1;
        let mut is_hole = vec![true; columns * (grid.theta_edges.len() - 1)];
        for (at, _) in self.is_hole.iter().enumerate().filter(|(_, is_hole)| !**is_hole) {
            is_hole[self.parent(columns, at)] = false;
        }
        Self::new(grid, is_hole)
    }

    /// Flat indices of the holes of a run.
    pub fn pixels(&self, run: &HoleRun) -> impl Iterator<Item = usize> + use<> {
        let (width, first, start) = (self.size.1, run.first, run.row * self.size.1);
        (0..run.pivots.len()).map(move |step| start + (first + step) % width)
    }

    /// Relax all rows downwards and upwards.
    pub fn relax(&self, image: &mut [f64], source: &[f64]) {
        interrupt::check();
        let mut flows = Vec::new();
        for run in self.runs.iter().chain(self.runs.iter().rev()) {
            flows.clear();
            flows.extend(self.pixels(run).map(|at| self.residual(image, source, at)));
            self.eliminate(run, &mut flows);
            for (at, change) in self.pixels(run).zip(&flows) {
                image[at] += change;
            }
        }
    }

    /// Residual of the holes, summed over the pixels of a `coarser` image.
    pub fn restrict_residual(&self, coarser: &Self, image: &[f64], source: &[f64]) -> Vec<f64> {
        let mut sums = vec![0.0; coarser.is_hole.len()];
        for at in self.runs.iter().flat_map(|run| self.pixels(run)) {
            sums[self.parent(coarser.size.1, at)] += self.residual(image, source, at);
        }
        sums
    }

    /// Add the `correction` of a `coarser` image to the holes, by linear interpolation between its pixels.
    pub fn add_correction(&self, coarser: &Self, correction: &[f64], image: &mut [f64]) {
        let (height, width) = coarser.size;
        for at in self.runs.iter().flat_map(|run| self.pixels(run)) {
            let (row, column) = (at / self.size.1, at % self.size.1);
            let (own_row, own_column) = (row / 2, column / 2);
            let other_row =
                if row % 2 == 0 { own_row.saturating_sub(1) } else { (own_row + 1).min(height - 1) };
            let other_column = if column % 2 == 0 { own_column + width - 1 } else { own_column + 1 } % width;
            let in_row = |row: usize| {
                0.75 * correction[row * width + own_column] + 0.25 * correction[row * width + other_column]
            };
            image[at] += 0.75 * in_row(own_row) + 0.25 * in_row(other_row);
        }
    }

    fn parent(&self, columns: usize, at: usize) -> usize {
        at / self.size.1 / 2 * columns + at % self.size.1 / 2
    }

    /// Flow into a hole plus its source.
    fn residual(&self, image: &[f64], source: &[f64], at: usize) -> f64 {
        let (height, width) = self.size;
        let (row, column) = (at / width, at % width);
        let before = if column > 0 { column - 1 } else { width - 1 };
        let after = if column + 1 < width { column + 1 } else { 0 };
        let (start, own) = (row * width, image[at]);
        let beside = self.per_distance[before] * (image[start + before] - own)
            + self.per_distance[column] * (image[start + after] - own);
        let above = if row > 0 { self.up[row] * (image[at - width] - own) } else { 0.0 };
        let below = if row + 1 < height { self.up[row + 1] * (image[at + width] - own) } else { 0.0 };
        source[at] + self.side[row] * beside + self.widths[column] * (above + below)
    }

    /// Runs of holes in a row.
    fn runs_of(&self, row: usize) -> Vec<HoleRun> {
        let width = self.size.1;
        let is_hole = &self.is_hole[row * width..(row + 1) * width];
        let Some(known) = is_hole.iter().position(|is_hole| !is_hole) else {
            return vec![self.ring(row)];
        };
        // Start behind a known pixel: no run is cut by the seam.
        let mut runs = Vec::new();
        let mut length = 0;
        for step in 1..=width {
            let column = (known + step) % width;
            if is_hole[column] {
                length += 1;
            } else if length > 0 {
                runs.push(self.open_run(row, (column + width - length) % width, length));
                length = 0;
            }
        }
        runs
    }

    /// Sum of the conductances of a pixel.
    fn diagonal(&self, row: usize, column: usize) -> f64 {
        let before = (column + self.size.1 - 1) % self.size.1;
        let beside = self.side[row] * (self.per_distance[before] + self.per_distance[column]);
        beside + self.widths[column] * (self.up[row] + self.up[row + 1])
    }

    /// Conductance from the pixel at a step of a run to the next one.
    fn ahead(&self, row: usize, first: usize, step: usize) -> f64 {
        self.side[row] * self.per_distance[(first + step) % self.size.1]
    }

    fn open_run(&self, row: usize, first: usize, length: usize) -> HoleRun {
        let diagonal = (0..length).map(|step| self.diagonal(row, (first + step) % self.size.1)).collect();
        HoleRun { row, first, pivots: self.pivots(row, first, diagonal), corner: Vec::new() }
    }

    /// The run of a row without a known pixel. Its matrix has two corners, which are one product of vectors.
    fn ring(&self, row: usize) -> HoleRun {
        let width = self.size.1;
        let mut diagonal: Vec<f64> = (0..width).map(|column| self.diagonal(row, column)).collect();
        let (first, corner) = (diagonal[0], self.ahead(row, 0, width - 1));
        diagonal[0] += first;
        diagonal[width - 1] += corner * corner / first;
        let mut run = HoleRun { row, first: 0, pivots: self.pivots(row, 0, diagonal), corner: Vec::new() };
        let mut solution = vec![0.0; width];
        (solution[0], solution[width - 1]) = (-first, -corner);
        self.eliminate(&run, &mut solution);
        run.corner = solution;
        run
    }

    fn pivots(&self, row: usize, first: usize, mut diagonal: Vec<f64>) -> Vec<f64> {
        for step in 1..diagonal.len() {
            diagonal[step] -= self.ahead(row, first, step - 1).powi(2) / diagonal[step - 1];
        }
        diagonal
    }

    /// Replace the residuals of a run by the changes that remove them.
    fn eliminate(&self, run: &HoleRun, flows: &mut [f64]) {
        let ahead = |step: usize| self.ahead(run.row, run.first, step);
        for step in 1..flows.len() {
            flows[step] += ahead(step - 1) / run.pivots[step - 1] * flows[step - 1];
        }
        let last = flows.len() - 1;
        flows[last] /= run.pivots[last];
        for step in (0..last).rev() {
            flows[step] = (flows[step] + ahead(step) * flows[step + 1]) / run.pivots[step];
        }
        if !run.corner.is_empty() {
            // The corner is the product of (-d, 0, .., -c) and (1, 0, .., c / d) for the first diagonal element d.
            let per_first = ahead(last) / self.diagonal(run.row, 0);
            let along = |values: &[f64]| values[0] + per_first * values[last];
            let factor = along(flows) / (1.0 + along(&run.corner));
            for (flow, corner) in flows.iter_mut().zip(&run.corner) {
                *flow -= factor * corner;
            }
        }
    }
}
