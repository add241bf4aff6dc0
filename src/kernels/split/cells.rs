//! Pixels as cells of the sphere: the integral of the direction over each, and its solid angle.
//!
//! The direction is `(sin phi sin theta, cos theta, -cos phi sin theta)`, so both are products of a factor of the row
//! and one of the column.

use std::f64::consts::PI;
use std::ops::Range;

use glam::DVec3;

use crate::kernels::image::Grid;
use crate::kernels::sphere::band_heights;

/// Every cell of an image.
pub struct Cells {
    pub rows: Vec<Row>,
    columns: Columns<Vec<f64>>,
    /// Means of the sine and of the cosine of each column, and its width.
    means: Vec<[f64; 3]>,
}

/// Integrals over the polar angles of a row.
#[derive(Clone, Copy)]
pub struct Row {
    /// Of `sin^2`.
    pub squares: f64,
    /// Of `sin cos`.
    pub products: f64,
    /// Of `sin`: `cos theta_top - cos theta_bottom`.
    pub band: f64,
}

/// For columns side by side, each three times, as for its samples of red, green and blue: integrals over the azimuths of
/// the sine, of the cosine and of 1, and products of an integral with a mean.
#[derive(Default)]
pub struct Columns<Values> {
    pub sin: Values,
    pub cos: Values,
    pub width: Values,
    pub sin_sin: Values,
    pub sin_cos: Values,
    pub cos_cos: Values,
}

impl Row {
    fn between(edges: &[f64], band: f64) -> Self {
        let (middle, half) = (0.5 * (edges[0] + edges[1]), 0.5 * (edges[1] - edges[0]));
        let squares = half - 0.5 * (2.0 * middle).cos() * (2.0 * half).sin();
        Self { squares, products: band * middle.cos() * half.cos(), band }
    }
}

impl Columns<Vec<f64>> {
    /// Add a column, and tell the means of its sine and cosine, and its width.
    fn push(&mut self, edges: &[f64]) -> [f64; 3] {
        let (middle, half) = (0.5 * (edges[0] + edges[1]), 0.5 * (edges[1] - edges[0]));
        let (width, chord) = (2.0 * half, 2.0 * half.sin());
        let (sin, cos) = (chord * middle.sin(), chord * middle.cos());
        let (mean_sin, mean_cos) = (sin / width, cos / width);
        self.sin.extend([sin; 3]);
        self.cos.extend([cos; 3]);
        self.width.extend([width; 3]);
        self.sin_sin.extend([sin * mean_sin; 3]);
        self.sin_cos.extend([sin * mean_cos; 3]);
        self.cos_cos.extend([cos * mean_cos; 3]);
        [mean_sin, mean_cos, width]
    }
}

impl Cells {
    pub fn new(grid: &Grid) -> Self {
        let theta = &grid.theta_edges;
        let rows = theta.windows(2).zip(band_heights(theta));
        let rows = rows.map(|(edges, band)| Row::between(edges, band)).collect();
        let mut columns = Columns::default();
        let means = grid.phi_edges.windows(2).map(|edges| columns.push(edges)).collect();
        Self { rows, columns, means }
    }

    /// Some columns.
    pub fn columns(&self, range: Range<usize>) -> Columns<&[f64]> {
        let Columns { sin, cos, width, sin_sin, sin_cos, cos_cos } = &self.columns;
        let [sin, cos, width, sin_sin, sin_cos, cos_cos] = [sin, cos, width, sin_sin, sin_cos, cos_cos]
            .map(|values| &values[3 * range.start..3 * range.end]);
        Columns { sin, cos, width, sin_sin, sin_cos, cos_cos }
    }

    /// Means of the sine and of the cosine of some columns, and their widths.
    pub fn means(&self, range: Range<usize>) -> &[[f64; 3]] {
        &self.means[range]
    }

    /// Angle from the middle of a pixel to its corners, at most.
    pub fn half_diagonal(&self) -> f64 {
        let width = self.columns.width.iter().copied().fold(0.0, f64::max);
        0.5 * (PI / self.rows.len() as f64).hypot(width)
    }

    /// The mean direction of a pixel, not quite a unit vector.
    pub fn mean(&self, row: usize, column: usize) -> DVec3 {
        let (Row { squares, products, band }, [sin, cos, _]) = (self.rows[row], self.means[column]);
        DVec3::new(sin * squares, products, -cos * squares) / band
    }
}
