//! Pixels as cells of the sphere: the integral of the direction over each, and its solid angle.
//!
//! The direction is `(sin phi sin theta, cos theta, -cos phi sin theta)`, so both are products of a factor of the row
//! and one of the column.

use std::f64::consts::PI;
use std::ops::Range;

use glam::DVec3;

use crate::kernels::detect::segment::run::Run;
use crate::kernels::image::Grid;
use crate::kernels::sphere::band_heights;

/// Every cell of an image.
pub struct Cells {
    pub rows: Vec<Row>,
    columns: Columns<Vec<f64>>,
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

/// For columns side by side: integrals over the azimuths of the sine, of the cosine and of 1, products of an integral
/// with a mean, and the means.
#[derive(Default)]
pub struct Columns<Values> {
    pub sin: Values,
    pub cos: Values,
    pub width: Values,
    pub sin_sin: Values,
    pub sin_cos: Values,
    pub cos_cos: Values,
    pub mean_sin: Values,
    pub mean_cos: Values,
}

impl Row {
    fn between(edges: &[f64], band: f64) -> Self {
        let (middle, half) = (0.5 * (edges[0] + edges[1]), 0.5 * (edges[1] - edges[0]));
        let squares = half - 0.5 * (2.0 * middle).cos() * (2.0 * half).sin();
        Self { squares, products: band * middle.cos() * half.cos(), band }
    }
}

impl Columns<Vec<f64>> {
    fn push(&mut self, edges: &[f64]) {
        let (middle, half) = (0.5 * (edges[0] + edges[1]), 0.5 * (edges[1] - edges[0]));
        let (width, chord) = (2.0 * half, 2.0 * half.sin());
        let (sin, cos) = (chord * middle.sin(), chord * middle.cos());
        let (mean_sin, mean_cos) = (sin / width, cos / width);
        self.sin.push(sin);
        self.cos.push(cos);
        self.width.push(width);
        self.sin_sin.push(sin * mean_sin);
        self.sin_cos.push(sin * mean_cos);
        self.cos_cos.push(cos * mean_cos);
        self.mean_sin.push(mean_sin);
        self.mean_cos.push(mean_cos);
    }
}

impl Cells {
    pub fn new(grid: &Grid) -> Self {
        let theta = &grid.theta_edges;
        let rows = theta.windows(2).zip(band_heights(theta));
        let rows = rows.map(|(edges, band)| Row::between(edges, band)).collect();
        let mut columns = Columns::default();
        grid.phi_edges.windows(2).for_each(|edges| columns.push(edges));
        Self { rows, columns }
    }

    /// Some columns.
    pub fn columns(&self, range: Range<usize>) -> Columns<&[f64]> {
        let all = &self.columns;
        let of = |select: fn(&Columns<Vec<f64>>) -> &Vec<f64>| &select(all)[range.clone()];
        Columns {
            sin: of(|all| &all.sin),
            cos: of(|all| &all.cos),
            width: of(|all| &all.width),
            sin_sin: of(|all| &all.sin_sin),
            sin_cos: of(|all| &all.sin_cos),
            cos_cos: of(|all| &all.cos_cos),
            mean_sin: of(|all| &all.mean_sin),
            mean_cos: of(|all| &all.mean_cos),
        }
    }

    /// Angle from the middle of a pixel to its corners, at most.
    pub fn half_diagonal(&self) -> f64 {
        let width = self.columns.width.iter().copied().fold(0.0, f64::max);
        0.5 * (PI / self.rows.len() as f64).hypot(width)
    }

    /// Dot products of a vector with the mean directions of pixels side by side, which are not quite unit vectors.
    pub fn dot_products(&self, run: &Run, vector: DVec3) -> impl Iterator<Item = f64> {
        let Row { squares, products, band } = self.rows[run.row];
        let DVec3 { x, y, z } = vector * DVec3::new(squares, products, -squares) / band;
        let Columns { mean_sin, mean_cos, .. } = self.columns(run.columns.clone());
        mean_sin.iter().zip(mean_cos).map(move |(sin, cos)| x * sin + y + z * cos)
    }
}
