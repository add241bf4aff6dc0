//! A set of lights: directions, their best radiances, and the cost.

use std::sync::Arc;

use glam::DVec3;
use nalgebra::{DMatrix, DMatrixView, Dyn, U1};

use super::factors::column_of;
use super::nnls::Support;
use super::objective::{Moments, Objective, PointObjective, Reference};
use super::radiances::{self, Radiances};
use super::rig::Rig;
use crate::interrupt;

/// Relative cost of rounding alone if the cost is summed from residuals.
const EXACT: f64 = 1e-26;
/// Relative cost of rounding alone if the cost is a difference of inner products.
pub const RESOLUTION: f64 = 1e-13;
/// Relative cost below which it is summed from residuals, if the objective can.
const SMALL: f64 = 1e-5;

/// Reason for the end of a descent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StopReason {
    /// The error stopped falling.
    Converged,
    /// Nothing is left to explain.
    Exact,
    /// The step limit came first.
    OutOfSteps,
}

/// A set of lights with its best radiances.
#[derive(Clone, Debug)]
pub struct State {
    pub moments: Moments,
    /// Coefficients of the ambient term, then irradiance of the lights; a column for each channel.
    pub x: DMatrix<f64>,
    /// For each channel, the columns that it uses.
    pub supports: Vec<Arc<Support>>,
    /// For each channel, the normals at which the ambient irradiance is held at 0.
    pub dark: Vec<Vec<DVec3>>,
    /// Weighted sum of the squared residuals.
    pub cost: f64,
    /// Number of steps of all descents that led here.
    pub steps: usize,
    /// Reason for the end of the descent, if it has ended.
    pub stop: Option<StopReason>,
}

impl State {
    /// The best radiances of lights in `directions`.
    pub fn new(objective: &dyn PointObjective, directions: &[DVec3]) -> Self {
        Self::at(objective, objective.moments(directions), 0, &[])
    }

    /// The best radiances of the lights of `moments`, after that many `steps`; those that are not 0 may be
    /// those of `guess`.
    pub fn at(objective: &dyn Objective, moments: Moments, steps: usize, guess: &[Arc<Support>]) -> Self {
        interrupt::check();
        let reference = objective.reference();
        let Radiances { x, supports, dark } = radiances::solve(reference, &moments.gram, &moments.rhs, guess);
        let cost = cost(reference, &moments.gram, &moments.rhs, &x);
        let mut state = Self { moments, x, supports, dark, cost, steps, stop: None };
        let exact_cost =
            (cost <= SMALL * reference.energy).then(|| objective.exact_cost(&state.rig(reference))).flatten();
        let cost = exact_cost.unwrap_or(cost);
        // Rounding may leave less than nothing; `max` would turn NaN to 0.
        state.cost = if cost < 0.0 { 0.0 } else { cost };
        if state.cost <= reference.energy * if exact_cost.is_some() { EXACT } else { RESOLUTION } {
            state.stop = Some(StopReason::Exact);
        }
        state
    }

    /// The lights turned to other `directions`, with the best radiances there.
    pub fn turn_to(&self, objective: &dyn PointObjective, directions: Vec<DVec3>) -> Self {
        Self::at(objective, objective.turn_to(&self.moments, directions), self.steps, &self.supports)
    }

    /// The lights `kept`, and others in the directions `new`.
    pub fn exchange(&self, objective: &dyn PointObjective, kept: &[usize], new: &[DVec3]) -> Self {
        Self::at(objective, objective.exchange(&self.moments, kept, new), self.steps, &[])
    }

    /// Number of lights.
    pub fn lights(&self) -> usize {
        self.moments.directions.len()
    }

    /// Irradiance of the lights: a row for each, a column for each channel.
    pub fn irradiance(&self) -> DMatrixView<'_, f64, U1, Dyn> {
        self.x.rows(self.x.nrows() - self.lights(), self.lights())
    }

    /// The state without the lights that no channel uses, but for the first `fixed`; absent if all are used.
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
    pub fn rig(&self, reference: &Reference) -> Rig {
        let rgb = |row: usize| {
            DVec3::from_array(reference.like.map(|like| like.map_or(0.0, |channel| self.x[(row, channel)])))
        };
        let ambient = reference.ambient.coefficients();
        Rig {
            ambient: (0..ambient).map(rgb).collect(),
            directions: self.moments.directions.clone(),
            irradiance: (ambient..self.x.nrows()).map(rgb).collect(),
            has_floor: reference.has_floor,
        }
    }

    /// Allow finer steps, unless the residual is 0.
    pub fn resume(mut self) -> Self {
        self.stop = self.stop.filter(|&stop| stop == StopReason::Exact);
        self
    }
}

/// The cost of the values `x` from inner products, right to about 1e-15 of the energy.
pub fn cost(reference: &Reference, gram: &DMatrix<f64>, rhs: &DMatrix<f64>, x: &DMatrix<f64>) -> f64 {
    let explained = |c: usize| {
        let (rhs, x) = (column_of(rhs, c), column_of(x, c));
        let of_row = |(row, (rhs, own)): (usize, (&f64, &f64))| {
            let used: f64 = column_of(gram, row).iter().zip(x).map(|(g, x)| g * x).sum();
            own * (2.0 * rhs - used)
        };
        rhs.iter().zip(x).enumerate().map(of_row).sum::<f64>()
    };
    reference.energy - (0..x.ncols()).map(|c| reference.copies(c) * explained(c)).sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::super::variable_projection::tests::world;
    use super::*;
    use crate::kernels::fit::{Ambient, Sphere};

    /// A cost of 0 would end every search.
    #[test]
    fn a_light_without_a_direction_has_no_cost() {
        let sphere = Sphere::new(&world(1.0), Ambient::Constant, false);
        assert!(State::new(&sphere, &[DVec3::NAN]).cost.is_nan());
        assert!(State::new(&sphere, &[DVec3::X]).cost > 0.0);
    }
}
