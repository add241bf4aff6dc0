//! The lines that cut the sphere into the cells of an image.

use glam::DVec3;

use crate::kernels::sphere::{Registration, direction_of};

/// The lines that cut the sphere into the cells of an image.
#[derive(Clone, Debug, PartialEq)]
pub struct Grid {
    /// Polar angles between the rows, from 0 to pi.
    pub theta_edges: Vec<f64>,
    /// Azimuths between the columns, from 0 to 2 pi.
    pub phi_edges: Vec<f64>,
    /// Factor of the column of an azimuth phi: the whole part of `phi * columns_per_radian + first_column`.
    pub columns_per_radian: f64,
    /// 0, or half a column where the first column is cut by the seam.
    pub first_column: f64,
}

impl Grid {
    /// A grid whose cells are the pixels.
    pub fn of_pixels(height: usize, width: usize, registration: Registration) -> Self {
        let (columns, first_column) = match registration {
            Registration::CellCentred => (width as f64, 0.0),
            Registration::BorderSampled => ((width - 1) as f64, 0.5),
        };
        Self {
            theta_edges: registration.theta_edges(height),
            phi_edges: registration.phi_edges(width),
            columns_per_radian: columns / std::f64::consts::TAU,
            first_column,
        }
    }

    /// Width of each column in radians.
    pub fn widths(&self) -> Vec<f64> {
        self.phi_edges.windows(2).map(|edge| edge[1] - edge[0]).collect()
    }

    /// The grid of blocks of `block` x `block` cells; those at the far edges may be smaller.
    pub(crate) fn in_blocks(&self, block: usize) -> Self {
        let every = |edges: &[f64]| {
            let mut outer: Vec<f64> = edges[..edges.len() - 1].iter().copied().step_by(block).collect();
            outer.extend(edges.last());
            outer
        };
        Self {
            theta_edges: every(&self.theta_edges),
            phi_edges: every(&self.phi_edges),
            columns_per_radian: self.columns_per_radian / block as f64,
            first_column: self.first_column / block as f64,
        }
    }
}

/// Directions of the centres of the cells of a grid.
pub struct CellCentres {
    /// Sine and cosine of the polar angle of each row.
    pub rows: Vec<(f64, f64)>,
    /// Sine and cosine of the azimuth of each column.
    pub columns: Vec<(f64, f64)>,
}

impl CellCentres {
    /// Directions of the centres of the cells of this grid.
    pub fn new(grid: &Grid) -> Self {
        let centres =
            |edges: &[f64]| edges.windows(2).map(|edge| (0.5 * (edge[0] + edge[1])).sin_cos()).collect();
        Self { rows: centres(&grid.theta_edges), columns: centres(&grid.phi_edges) }
    }

    /// Unit vector towards a cell, by its flat index.
    pub fn direction(&self, cell: usize) -> DVec3 {
        self.at(cell / self.columns.len(), cell % self.columns.len())
    }

    /// Unit vector towards the cell of a row and a column.
    pub fn at(&self, row: usize, column: usize) -> DVec3 {
        direction_of(self.rows[row], self.columns[column])
    }
}
