//! One place of the search: directions, their best radiances, and what that costs.

use std::sync::Arc;

use glam::DVec3;
use nalgebra::{DMatrix, DMatrixView, Dyn, U1};

use super::factors::column_of;
use super::nnls::Support;
use super::objective::{Given, Moments, Objective, PointObjective};
use super::radiances::{self, Radiances};
use super::rig::Rig;
use crate::interrupt;

/// Relative cost of rounding alone, where the cost is summed from residuals.
const EXACT: f64 = 1e-26;
/// The same where it is a difference of inner products.
pub const RESOLUTION: f64 = 1e-13;
/// Relative cost below which it is summed from the residuals, where that can be.
const SMALL: f64 = 1e-5;

/// Why the solver stopped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StopReason {
    /// The error stopped falling.
    Converged,
    /// Nothing is left to explain.
    Exact,
    /// The step limit came first.
    OutOfSteps,
}

/// One place of the search.
#[derive(Clone, Debug)]
pub struct State {
    pub moments: Moments,
    /// Coefficients of the ambient term, then irradiance of the lights; a column for each channel.
    pub x: DMatrix<f64>,
    /// For each channel, the columns that it uses.
    pub supports: Vec<Arc<Support>>,
    /// For each channel, the normals at which the ambient term is kept from turning negative.
    pub dark: Vec<Vec<DVec3>>,
    /// Weighted sum of squares of what is left unexplained.
    pub cost: f64,
    /// Steps that led here, from wherever the search began.
    pub steps: usize,
    /// Why no step leads on, once that is so.
    pub stop: Option<StopReason>,
}

impl State {
    /// The best radiances of lights in `directions`.
    pub fn new(objective: &dyn PointObjective, directions: &[DVec3]) -> Self {
        Self::at(objective.base(), objective.moments(directions), 0, &[])
    }

    /// The best radiances of the lights of `moments`, after that many `steps`; those that are not 0 may be
    /// those of `guess`.
    pub fn at(objective: &dyn Objective, moments: Moments, steps: usize, guess: &[Arc<Support>]) -> Self {
        interrupt::check();
        let given = objective.given();
        let Radiances { x, supports, dark } = radiances::solve(given, &moments.gram, &moments.rhs, guess);
        let cost = cost(given, &moments.gram, &moments.rhs, &x);
        let mut state = Self { moments, x, supports, dark, cost, steps, stop: None };
        let exact_cost =
            (cost <= SMALL * given.energy).then(|| objective.exact_cost(&state.rig(given))).flatten();
        // Rounding may leave less than nothing.
        state.cost = exact_cost.unwrap_or(cost).max(0.0);
        if state.cost <= given.energy * if exact_cost.is_some() { EXACT } else { RESOLUTION } {
            state.stop = Some(StopReason::Exact);
        }
        state
    }

    /// The same lights in other `directions`, with the best radiances for these.
    pub fn turned_to(&self, objective: &dyn PointObjective, directions: Vec<DVec3>) -> Self {
        Self::at(objective.base(), objective.turned(&self.moments, directions), self.steps, &self.supports)
    }

    /// The lights `kept`, and others in the directions `new`.
    pub fn exchanged(&self, objective: &dyn PointObjective, kept: &[usize], new: &[DVec3]) -> Self {
        Self::at(objective.base(), objective.exchanged(&self.moments, kept, new), self.steps, &[])
    }

    /// How many lights there are.
    pub fn lights(&self) -> usize {
        self.moments.directions.len()
    }

    /// Irradiance of the lights: a row for each, a column for each channel.
    pub fn irradiance(&self) -> DMatrixView<'_, f64, U1, Dyn> {
        self.x.rows(self.x.nrows() - self.lights(), self.lights())
    }

    /// The state without the lights that no channel uses, but for the first `fixed`; none if all are used.
    ///
    /// A light of radiance 0 has no gradient, so it would stay where it started.
    pub fn without_black(&self, objective: &dyn Objective, fixed: usize) -> Option<Self> {
        let is_used = |&light: &usize| light < fixed || self.irradiance().row(light).amax() > 0.0;
        let kept: Vec<usize> = (0..self.lights()).filter(is_used).collect();
        (kept.len() < self.lights()).then(|| {
            let moments = objective.subset(&self.moments, &kept);
            Self { stop: self.stop, ..Self::at(objective, moments, self.steps, &[]) }
        })
    }

    /// All three channels of the lights.
    pub fn rig(&self, given: &Given) -> Rig {
        let rgb = |row: usize| {
            DVec3::from_array(given.like.map(|like| like.map_or(0.0, |channel| self.x[(row, channel)])))
        };
        let ambient = given.ambient.coefficients();
        Rig {
            ambient: (0..ambient).map(rgb).collect(),
            directions: self.moments.directions.clone(),
            irradiance: (ambient..self.x.nrows()).map(rgb).collect(),
            has_floor: given.has_floor,
        }
    }

    /// Ready for finer steps, unless nothing is left to explain.
    pub fn resumed(mut self) -> Self {
        self.stop = self.stop.filter(|&stop| stop == StopReason::Exact);
        self
    }
}

/// What the values `x` leave unexplained, from inner products: good to about 1e-15 of the energy.
pub fn cost(given: &Given, gram: &DMatrix<f64>, rhs: &DMatrix<f64>, x: &DMatrix<f64>) -> f64 {
    let explained = |c: usize| {
        let (rhs, x) = (column_of(rhs, c), column_of(x, c));
        let of_row = |(row, (rhs, own)): (usize, (&f64, &f64))| {
            let used: f64 = column_of(gram, row).iter().zip(x).map(|(g, x)| g * x).sum();
            own * (2.0 * rhs - used)
        };
        rhs.iter().zip(x).enumerate().map(of_row).sum::<f64>()
    };
    given.energy - (0..x.ncols()).map(|c| given.copies(c) * explained(c)).sum::<f64>()
}
