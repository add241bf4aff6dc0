//! Integrals of the direction over the cells of an image, as products of a factor of the row and one of the column.
//!
//! The direction is `(sin phi sin theta, cos theta, -cos phi sin theta)`, and a solid angle is `sin theta dtheta dphi`.

use glam::DVec3;

/// Integrals over the polar angles of one row of cells.
#[derive(Clone, Copy)]
pub struct RowIntegrals {
    /// Integral of `sin^2 theta`.
    pub squares: f64,
    /// Integral of `sin theta cos theta`.
    pub products: f64,
    /// Integral of `sin theta`: `cos theta_top - cos theta_bottom`.
    pub band: f64,
}

/// Integrals over the azimuths of one column of cells.
#[derive(Clone, Copy)]
pub struct ColumnIntegrals {
    /// Integral of `sin phi`.
    pub sin: f64,
    /// Integral of `cos phi`.
    pub cos: f64,
    /// Width in radians.
    pub width: f64,
}

impl RowIntegrals {
    /// Integrals between two polar angles.
    pub fn new(top: f64, bottom: f64) -> Self {
        let (sum, difference) = (top + bottom, bottom - top);
        Self {
            squares: 0.5 * (difference - sum.cos() * difference.sin()),
            products: 0.5 * sum.sin() * difference.sin(),
            band: 2.0 * (0.5 * sum).sin() * (0.5 * difference).sin(),
        }
    }

    /// Integrals for each row between these polar angles.
    pub fn of_rows(theta_edges: &[f64]) -> Vec<Self> {
        theta_edges.windows(2).map(|edge| Self::new(edge[0], edge[1])).collect()
    }

    /// Integral of the direction over the cell of a column.
    pub fn direction(&self, column: &ColumnIntegrals) -> DVec3 {
        DVec3::new(self.squares * column.sin, self.products * column.width, -self.squares * column.cos)
    }
}

impl ColumnIntegrals {
    /// Integrals for each column between these azimuths.
    pub fn of_columns(phi_edges: &[f64]) -> Vec<Self> {
        let column = |edge: &[f64]| {
            let (middle, half) = (0.5 * (edge[0] + edge[1]), 0.5 * (edge[1] - edge[0]));
            let chord = 2.0 * half.sin();
            Self { sin: chord * middle.sin(), cos: chord * middle.cos(), width: 2.0 * half }
        };
        phi_edges.windows(2).map(column).collect()
    }
}
