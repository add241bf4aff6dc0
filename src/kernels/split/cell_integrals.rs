//! Integrals of the direction over pixels, as products of a factor of the row and one of the column.
//!
//! The direction is `(sin phi sin theta, cos theta, -cos phi sin theta)`, and a solid angle is `sin theta dtheta dphi`.

use crate::kernels::image::Grid;
use crate::kernels::sphere::band_heights;

/// Integrals over the polar angles of one row of pixels.
#[derive(Clone, Copy)]
pub struct RowIntegrals {
    /// Integral of `sin^2 theta`.
    pub squares: f64,
    /// Integral of `sin theta cos theta`.
    pub products: f64,
    /// Integral of `sin theta`: `cos theta_top - cos theta_bottom`.
    pub band: f64,
}

/// Integrals over the azimuths of one column of pixels.
#[derive(Clone, Copy)]
pub struct ColumnIntegrals {
    pub sin: f64,
    pub cos: f64,
    pub width: f64,
}

/// Integrals for each row of pixels.
pub fn row_integrals(grid: &Grid) -> Vec<RowIntegrals> {
    let rows = grid.theta_edges.windows(2).zip(band_heights(&grid.theta_edges));
    let row = |(edges, band): (&[f64], f64)| {
        let (middle, half) = (0.5 * (edges[0] + edges[1]), 0.5 * (edges[1] - edges[0]));
        let squares = half - 0.5 * (2.0 * middle).cos() * (2.0 * half).sin();
        RowIntegrals { squares, products: band * middle.cos() * half.cos(), band }
    };
    rows.map(row).collect()
}

/// Integrals for each column of pixels.
pub fn column_integrals(grid: &Grid) -> Vec<ColumnIntegrals> {
    let column = |edges: &[f64]| {
        let (middle, half) = (0.5 * (edges[0] + edges[1]), 0.5 * (edges[1] - edges[0]));
        let chord = 2.0 * half.sin();
        ColumnIntegrals { sin: chord * middle.sin(), cos: chord * middle.cos(), width: 2.0 * half }
    };
    grid.phi_edges.windows(2).map(column).collect()
}
