//! What a light in a new place would explain, for many places at once.
//!
//! With R the inverse Gram matrix of the columns of a state, and for the column of a light at d: u its inner
//! products with them, `z = R u`, `o = <a_d, a_d> - u.z` what it adds to them, and `<a_d, r_c>` those with the
//! residuals, one light more leaves at least
//!
//! ```text
//!   cost - sum_c max(0, <a_d, r_c>)^2 / o
//! ```
//!
//! and the light j, of radiance `x_j`, taken from its place and put at d at least
//!
//! ```text
//!   cost + sum_c x_jc^2 / R_jj - sum_c max(0, <a_d, r_c> + x_jc z_j / R_jj)^2 / (o + z_j^2 / R_jj)
//! ```
//!
//! with equality where no radiance would turn negative.

use glam::DVec3;
use nalgebra::{DMatrix, DVector};

use super::objective::{Directions, PointObjective};
use super::state::State;
use crate::kernels::sampling;
use crate::kernels::sphere::to_vectors;

/// Places that are tried: about 20 degrees apart.
const TRIED: usize = 96;
/// A column this close to the span of the others, in squared length, brings nothing new.
const DEPENDENT: f64 = 1e-6;

/// Places for a light, and the inner products that do not depend on the others.
#[derive(Debug)]
pub struct Candidates<'a> {
    objective: &'a dyn PointObjective,
    at: Directions,
    /// With each side of the probe: a row for each place.
    sides: DMatrix<f64>,
    /// Of each column with itself.
    squares: Vec<f64>,
}

/// A promise: the cost that a light at a place would leave, at least.
pub type Promise = (f64, DVec3);

/// What the candidates are to the lights of a state.
pub struct Beside<'a> {
    candidates: &'a Candidates<'a>,
    state: &'a State,
    /// `<a_d, r_c>`: a row for each place, a column for each channel.
    residual: DMatrix<f64>,
    /// R, and `z = R u`: a column for each place.
    inverse: DMatrix<f64>,
    along: DMatrix<f64>,
    /// `o`
    outside: Vec<f64>,
}

impl<'a> Candidates<'a> {
    /// For an objective.
    pub fn new(objective: &'a dyn PointObjective) -> Self {
        let places = to_vectors(sampling::even_sphere(TRIED).view());
        let places: Vec<DVec3> = places.into_iter().map(|place| objective.placed(place)).collect();
        let at = objective.directions(places);
        let sides = objective.side_products(&at);
        let squares = objective.squares(&at);
        Self { objective, at, sides, squares }
    }

    /// Beside the lights of `state`.
    pub fn beside(&'a self, state: &'a State) -> Option<Beside<'a>> {
        let ambient = self.objective.given().ambient.coefficients();
        let lights = self.objective.light_products(&self.at, &state.moments.directions);
        let mut products = self.sides.columns(0, ambient).resize_horizontally(state.x.nrows(), 0.0);
        products.columns_range_mut(ambient..).copy_from(&lights);
        let residual = self.sides.columns_range(ambient..) - &products * &state.x;
        let mut gram = state.moments.gram.clone();
        // Columns may depend on each other: as for lights that are the same.
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
    /// One light more at each place, where that would lower the cost.
    pub fn added(&self) -> Vec<Promise> {
        let zero = DVector::zeros(self.state.x.ncols());
        self.promises(self.state.cost, self.state.cost, &zero, |_| (0.0, 0.0))
    }

    /// The light j taken out and put at each place, where that would leave less than the cost `most`.
    pub fn moved(&self, light: usize, most: f64) -> Vec<Promise> {
        let row = self.state.x.nrows() - self.state.lights() + light;
        let own = self.inverse[(row, row)];
        let x = self.state.x.row(row).transpose();
        let given = self.candidates.objective.given();
        let without: f64 = (0..x.len()).map(|c| given.copies(c) * x[c] * x[c]).sum::<f64>() / own;
        self.promises(self.state.cost + without, most, &x, |i| {
            let along = self.along[(row, i)];
            (along / own, along * along / own)
        })
    }

    /// Of a light that has the radiances `x` already, and of what its place gives back at each candidate: those of less
    /// than `most`.
    fn promises(
        &self,
        cost: f64,
        most: f64,
        x: &DVector<f64>,
        given_back: impl Fn(usize) -> (f64, f64),
    ) -> Vec<Promise> {
        let Candidates { at, squares, objective, .. } = self.candidates;
        let copies: Vec<f64> = (0..x.len()).map(|channel| objective.given().copies(channel)).collect();
        let mut promises = Vec::with_capacity(self.outside.len());
        for (i, &outside) in self.outside.iter().enumerate() {
            let (share, length) = given_back(i);
            let outside = outside + length;
            let explained = |c: usize| copies[c] * (self.residual[(i, c)] + x[c] * share).max(0.0).powi(2);
            let left = cost - (0..x.len()).map(explained).sum::<f64>() / outside;
            if left < most && outside > DEPENDENT * squares[i] {
                promises.push((left, at.directions[i]));
            }
        }
        promises
    }
}
