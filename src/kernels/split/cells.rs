//! Pixels as cells of the sphere: the integral of the direction over each, and its solid angle.
//!
//! The direction is `(sin phi sin theta, cos theta, -cos phi sin theta)`, so both are products of a factor of the row
//! and one of the column.

use std::f64::consts::PI;

use glam::DVec3;

use crate::kernels::image::Grid;
use crate::kernels::sphere::band_heights;

/// Every cell of an image.
pub struct Cells {
    pub rows: Vec<Row>,
    pub columns: Vec<Column>,
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

/// Integrals over the azimuths of a column, of the sine, of the cosine and of 1; means of sine and cosine; and products
/// of an integral with a mean.
#[derive(Clone, Copy)]
pub struct Column {
    pub sin: f64,
    pub cos: f64,
    pub width: f64,
    pub mean_sin: f64,
    pub mean_cos: f64,
    pub sin_sin: f64,
    pub sin_cos: f64,
    pub cos_cos: f64,
}

impl Row {
    fn between(edges: &[f64], band: f64) -> Self {
        let (middle, half) = (0.5 * (edges[0] + edges[1]), 0.5 * (edges[1] - edges[0]));
        let squares = half - 0.5 * (2.0 * middle).cos() * (2.0 * half).sin();
        Self { squares, products: band * middle.cos() * half.cos(), band }
    }
}

impl Column {
    fn between(edges: &[f64]) -> Self {
        let (middle, half) = (0.5 * (edges[0] + edges[1]), 0.5 * (edges[1] - edges[0]));
        let (width, chord) = (2.0 * half, 2.0 * half.sin());
        let (sin, cos) = (chord * middle.sin(), chord * middle.cos());
        let (mean_sin, mean_cos) = (sin / width, cos / width);
        let (sin_sin, sin_cos, cos_cos) = (sin * mean_sin, sin * mean_cos, cos * mean_cos);
        Self { sin, cos, width, mean_sin, mean_cos, sin_sin, sin_cos, cos_cos }
    }
}

impl Cells {
    pub fn new(grid: &Grid) -> Self {
        let theta = &grid.theta_edges;
        let rows = theta.windows(2).zip(band_heights(theta));
        Self {
            rows: rows.map(|(edges, band)| Row::between(edges, band)).collect(),
            columns: grid.phi_edges.windows(2).map(Column::between).collect(),
        }
    }

    /// Angle from the middle of a pixel to its corners, at most.
    pub fn half_diagonal(&self) -> f64 {
        let width = self.columns.iter().map(|column| column.width).fold(0.0, f64::max);
        0.5 * (PI / self.rows.len() as f64).hypot(width)
    }

    /// The mean direction of a pixel, not quite a unit vector.
    pub fn mean(&self, row: usize, column: usize) -> DVec3 {
        let Row { squares, products, band } = self.rows[row];
        let Column { mean_sin, mean_cos, .. } = self.columns[column];
        DVec3::new(mean_sin * squares, products, -mean_cos * squares) / band
    }
}
