//! The map's pixels as cells of the sphere: the integral of the direction over each, and its solid angle.

use std::f64::consts::PI;

use glam::DVec3;

use crate::kernels::sphere::{Registration, band_heights};

/// Every cell of a map.
pub struct Cells {
    /// Integrals of `sin^2`, of `sin cos` and of `sin` of the polar angle over each row.
    rows: Vec<[f64; 3]>,
    /// Integrals of the sine and the cosine of the azimuth over each column, and its width.
    columns: Vec<[f64; 3]>,
}

impl Cells {
    pub fn new(height: usize, width: usize, registration: Registration) -> Self {
        let theta = registration.theta_edges(height);
        let row = |(edges, band): (&[f64], f64)| {
            let (middle, half) = (0.5 * (edges[0] + edges[1]), 0.5 * (edges[1] - edges[0]));
            let squares = half - 0.5 * (2.0 * middle).cos() * (2.0 * half).sin();
            [squares, band * middle.cos() * half.cos(), band]
        };
        let column = |edges: &[f64]| {
            let (middle, half) = (0.5 * (edges[0] + edges[1]), 0.5 * (edges[1] - edges[0]));
            let chord = 2.0 * half.sin();
            [chord * middle.sin(), chord * middle.cos(), 2.0 * half]
        };
        Self {
            rows: theta.windows(2).zip(band_heights(&theta)).map(row).collect(),
            columns: registration.phi_edges(width).windows(2).map(column).collect(),
        }
    }

    /// Angle from the middle of a pixel to its corners, at most.
    pub fn half_diagonal(&self) -> f64 {
        let width = self.columns.iter().map(|column| column[2]).fold(0.0, f64::max);
        0.5 * (PI / self.rows.len() as f64).hypot(width)
    }

    /// The integral of the direction over a pixel, and its solid angle.
    pub fn at(&self, row: usize, column: usize) -> (DVec3, f64) {
        let [squares, product, band] = self.rows[row];
        let [sin, cos, width] = self.columns[column];
        (DVec3::new(sin * squares, width * product, -cos * squares), width * band)
    }
}
