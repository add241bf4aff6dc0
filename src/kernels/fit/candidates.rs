//! Predicted cost of a light in a new direction, for many directions at once.
//!
//! R is the inverse Gram matrix of the columns of a state, and `r_c` is its residual in channel c. A light in the
//! direction d has the column `a_d`, and u holds the inner products of `a_d` with the columns of the state. With
//! `z = R u`, the part of `a_d` outside the span of these columns has the squared length `o = <a_d, a_d> - u.z`. If
//! this light is added, the cost is at least
//!
//! ```text
//!   cost - sum_c max(0, <a_d, r_c>)^2 / o
//! ```
//!
//! If instead light j, of radiance `x_j`, moves to d, the cost is at least
//!
//! ```text
//!   cost + sum_c x_jc^2 / R_jj - sum_c max(0, <a_d, r_c> + x_jc z_j / R_jj)^2 / (o + z_j^2 / R_jj)
//! ```
//!
//! Both bounds are exact if no radiance would turn negative.

use glam::DVec3;
use nalgebra::{DMatrix, DVector};

use super::objective::{Directions, PointObjective};
use super::settings::SEARCH;
use super::state::State;
use crate::kernels::sampling;
use crate::kernels::sphere::to_vectors;

/// Smallest squared distance of a column from the span of the others, relative to its squared length.
const DEPENDENT: f64 = 1e-6;

/// Directions for a light, and the inner products that do not depend on the other lights.
#[derive(Debug)]
pub struct Candidates<'a> {
    objective: &'a dyn PointObjective,
    at: Directions,
    /// Products with the ambient columns and the irradiance: a row for each direction.
    sides: DMatrix<f64>,
    /// Squared length of each column.
    squares: Vec<f64>,
}

/// Least cost with a light in a direction, and that direction.
pub type Prediction = (f64, DVec3);

/// Inner products of the candidates with the columns and the residuals of a state.
pub struct Beside<'a> {
    candidates: &'a Candidates<'a>,
    state: &'a State,
    /// `<a_d, r_c>`: a row for each direction, a column for each channel.
    residual: DMatrix<f64>,
    /// R, and `z = R u`: a column for each direction.
    inverse: DMatrix<f64>,
    along: DMatrix<f64>,
    /// Values `o`, one for each direction.
    outside: Vec<f64>,
}

impl<'a> Candidates<'a> {
    /// Candidates of an objective.
    pub fn new(objective: &'a dyn PointObjective) -> Self {
        let places = to_vectors(sampling::even_sphere(SEARCH.directions).view());
        let places: Vec<DVec3> = places.into_iter().map(|place| objective.place(place)).collect();
        let at = objective.directions(places);
        let sides = objective.side_products(&at);
        let squares = objective.squares(&at);
        Self { objective, at, sides, squares }
    }

    /// Products with the lights of `state`; absent if its columns depend on each other.
    pub fn beside(&'a self, state: &'a State) -> Option<Beside<'a>> {
        let ambient = self.objective.reference().ambient.coefficients();
        let lights = self.objective.light_products(&self.at, &state.moments.directions);
        let mut products = self.sides.columns(0, ambient).resize_horizontally(state.x.nrows(), 0.0);
        products.columns_range_mut(ambient..).copy_from(&lights);
        let residual = self.sides.columns_range(ambient..) - &products * &state.x;
        let mut gram = state.moments.gram.clone();
        // Separate columns that depend on each other, such as those of equal lights.
        (0..gram.nrows()).for_each(|i| gram[(i, i)] *= 1.0 + DEPENDENT);
        let inverse = gram.cholesky()?.inverse();
        let products = products.transpose();
        let along = &inverse * &products;
        let inner = |i: usize| products.column(i).dot(&along.column(i));
        let outside = self.squares.iter().enumerate().map(|(i, square)| square - inner(i)).collect();
        Some(Beside { candidates: self, state, residual, inverse, along, outside })
    }
}

impl Beside<'_> {
    /// One more light in each direction that would lower the cost.
    pub fn additions(&self) -> Vec<Prediction> {
        let zero = DVector::zeros(self.state.x.ncols());
        self.predictions(self.state.cost, self.state.cost, &zero, |_| (0.0, 0.0))
    }

    /// Predicted costs below `most` of moving this light to each candidate direction.
    pub fn relocations(&self, light: usize, most: f64) -> Vec<Prediction> {
        let row = self.state.x.nrows() - self.state.lights() + light;
        let own = self.inverse[(row, row)];
        let x = self.state.x.row(row).transpose();
        let reference = self.candidates.objective.reference();
        let without: f64 = (0..x.len()).map(|c| reference.copies(c) * x[c] * x[c]).sum::<f64>() / own;
        self.predictions(self.state.cost + without, most, &x, |i| {
            let along = self.along[(row, i)];
            (along / own, along * along / own)
        })
    }

    /// Predictions below `most` for a light of the radiances `x`; `freed` gives the products that its removal frees.
    fn predictions(
        &self,
        cost: f64,
        most: f64,
        x: &DVector<f64>,
        freed: impl Fn(usize) -> (f64, f64),
    ) -> Vec<Prediction> {
        let Candidates { at, squares, objective, .. } = self.candidates;
        let copies: Vec<f64> = (0..x.len()).map(|channel| objective.reference().copies(channel)).collect();
        let mut predictions = Vec::with_capacity(self.outside.len());
        for (i, &outside) in self.outside.iter().enumerate() {
            let (share, length) = freed(i);
            let outside = outside + length;
            let explained = |c: usize| copies[c] * (self.residual[(i, c)] + x[c] * share).max(0.0).powi(2);
            let left = cost - (0..x.len()).map(explained).sum::<f64>() / outside;
            if left < most && outside > DEPENDENT * squares[i] {
                predictions.push((left, at.directions[i]));
            }
        }
        predictions
    }
}
