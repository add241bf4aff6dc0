//! The best directions near given ones: variable projection with damped Gauss-Newton steps.
//!
//! For fixed directions the best radiances `x` are a small linear problem (`nnls.rs`), so only the
//! 2M tangent coordinates `t` of the directions are left (Golub and Pereyra 1973). With Kaufman's
//! approximation of the Jacobian, and `P_c` the projection on the columns that channel c uses,
//!
//! ```text
//!   J_c = -(1 - P_c) D_c        D_c[:, jk] = x_jc da_j/dt_k
//!   J^T J [jk, j'k'] = sum_c x_jc x_j'c ( da_jk.da_j'k' - (A_c^T da_jk)^T G_c^-1 (A_c^T da_j'k') )
//!   J^T r [jk]       = -sum_c x_jc da_jk.r_c
//! ```
//!
//! all of them inner products that [`Moments`] already holds. The tangent plane has no pole, where
//! the paper's angles theta and phi lose a rank.

use glam::DVec3;
use nalgebra::{DMatrix, DVector};

use super::ambient::Ambient;
use super::moments::Moments;
use super::nnls::{self, View};
use super::probe::Probe;
use super::radiances::{self, Radiances};
use super::{Rig, StopReason};
use crate::kernels::sphere::exponential_map;

/// A light never turns by more than this in one step, in radians: the model is linear only nearby.
const LONGEST_STEP: f64 = 0.5;
/// Damping of a first step.
const FIRST_DAMPING: f64 = 1e-3;
/// Damping at which a step no longer moves anything.
const STIFFEST: f64 = 1e8;
/// Relative cost of rounding alone.
const EXACT: f64 = 1e-26;
/// Relative cost below which it is summed from the residuals: from the moments it would be a
/// difference of large numbers.
const SMALL: f64 = 1e-5;

/// What is solved.
#[derive(Clone, Copy, Debug)]
pub struct Problem<'a> {
    /// What is to be reproduced.
    pub probe: &'a Probe,
    /// Where the first lights start, brightest first.
    pub start: &'a [DVec3],
    /// How many of these keep their directions.
    pub held: usize,
    /// Steps after which the solver gives up.
    pub max_steps: usize,
}

/// One place of the search: directions, their best radiances, and what that costs.
#[derive(Clone, Debug)]
pub struct State {
    pub moments: Moments,
    /// Coefficients of the ambient term, then irradiance of the lights; a column for each channel.
    pub x: DMatrix<f64>,
    /// For each channel, the normals at which the ambient term is kept from turning negative.
    dark: Vec<Vec<DVec3>>,
    /// Weighted sum of squares of what is left unexplained.
    pub cost: f64,
    damping: f64,
    /// Steps that led here, from wherever the search began.
    pub steps: usize,
    /// Why no step leads on, once that is so.
    pub stop: Option<StopReason>,
}

impl State {
    /// The best radiances of lights in `directions`.
    pub fn new(probe: &Probe, directions: &[DVec3]) -> Self {
        Self::at(probe, Moments::new(probe, directions), 0)
    }

    /// The best radiances of the lights of `moments`, after so many `steps`.
    pub fn at(probe: &Probe, moments: Moments, steps: usize) -> Self {
        let columns = moments.columns();
        let gram = moments.gram.view((0, 0), (columns, columns));
        let right = moments.right.rows(0, columns);
        let Radiances { x, dark } = radiances::solve(probe, &gram, &right);
        let cost = cost(probe, &gram, &right, &x);
        let mut state = Self { moments, x, dark, cost, damping: FIRST_DAMPING, steps, stop: None };
        if cost <= SMALL * probe.samples.energy {
            state.cost = probe.samples.cost(&state.rig(probe));
        }
        if state.cost <= EXACT * probe.samples.energy {
            state.stop = Some(StopReason::Exact);
        }
        state
    }

    /// How many lights there are.
    pub fn lights(&self) -> usize {
        self.moments.directions.len()
    }

    /// Irradiance of the lights: a row for each, a column for each channel.
    pub fn irradiance(&self) -> View<'_> {
        self.x.rows(self.x.nrows() - self.lights(), self.lights())
    }

    /// The columns that a channel uses.
    fn used(&self, probe: &Probe, channel: usize) -> Vec<usize> {
        let x = self.x.column(channel);
        (0..x.len()).filter(|&i| i < probe.free() || x[i] > 0.0).collect()
    }

    /// Without the lights that no channel uses, if there are such beyond those that are held: nothing
    /// pulls at a light of radiance 0, so it would stay where it started.
    pub fn without_black(&self, problem: &Problem<'_>) -> Option<Self> {
        let is_lit = |&light: &usize| light < problem.held || self.irradiance().row(light).amax() > 0.0;
        let kept: Vec<usize> = (0..self.lights()).filter(is_lit).collect();
        (kept.len() < self.lights()).then(|| {
            let moments = self.moments.with(problem.probe, &kept, &[]);
            Self::at(problem.probe, moments, self.steps)
        })
    }

    /// All three channels of the lights.
    pub fn rig(&self, probe: &Probe) -> Rig {
        let rgb = |row: usize| {
            DVec3::from_array(probe.like.map(|like| like.map_or(0.0, |channel| self.x[(row, channel)])))
        };
        let ambient = probe.ambient.coefficients();
        Rig {
            ambient: (0..ambient).map(rgb).collect(),
            directions: self.moments.directions.clone(),
            irradiance: (ambient..self.x.nrows()).map(rgb).collect(),
        }
    }

    /// Downhill until a step lowers the cost by less than the share `still` of it.
    pub fn descend(mut self, problem: &Problem<'_>, still: f64) -> Self {
        for _ in 0..problem.max_steps {
            self = self.step(problem, still);
        }
        self.stop = self.stop.or(Some(StopReason::OutOfSteps));
        self
    }

    /// Ready for finer steps, unless nothing is left to explain.
    pub fn resumed(mut self) -> Self {
        self.stop = self.stop.filter(|&stop| stop == StopReason::Exact);
        self
    }

    /// One damped step downhill; at the bottom none, and the reason why.
    pub fn step(mut self, problem: &Problem<'_>, still: f64) -> Self {
        if self.stop.is_some() {
            return self;
        }
        let (curvature, slope) = normal_equations(problem, &self);
        while self.damping < STIFFEST {
            let Some(step) = damped_step(&curvature, &slope, self.damping) else { break };
            // What the linear model promises: less than that is not worth the try.
            let promised = -(2.0 * slope.dot(&step) + step.dot(&(&curvature * &step)));
            if promised <= 0.1 * still * self.cost {
                break;
            }
            let moments = self.moments.turned(problem.probe, self.turned(problem, &step));
            let mut next = Self::at(problem.probe, moments, self.steps + 1);
            if next.cost < self.cost {
                next.damping = (self.damping * 0.1).max(1e-12);
                if self.cost - next.cost <= still * self.cost {
                    next.stop = next.stop.or(Some(StopReason::Converged));
                }
                return next;
            }
            self.damping *= 10.0;
        }
        self.stop = Some(StopReason::Converged);
        self
    }

    /// Every direction turned by its part of `step`.
    fn turned(&self, problem: &Problem<'_>, step: &DVector<f64>) -> Vec<DVec3> {
        let mut directions = self.moments.directions.clone();
        for (i, light) in (problem.held..directions.len()).enumerate() {
            let [s, t] = self.moments.tangents[light];
            let along = s * step[2 * i] + t * step[2 * i + 1];
            directions[light] = exponential_map(directions[light], along.clamp_length_max(LONGEST_STEP));
        }
        directions
    }
}

/// What the values `x` leave unexplained, from inner products: good to about 1e-15 of the energy.
pub fn cost(probe: &Probe, gram: &View<'_>, right: &View<'_>, x: &DMatrix<f64>) -> f64 {
    let used = gram * x;
    let explained = |c: usize| 2.0 * right.column(c).dot(&x.column(c)) - used.column(c).dot(&x.column(c));
    probe.samples.energy - (0..x.ncols()).map(|c| probe.copies(c) * explained(c)).sum::<f64>()
}

/// `(H + damping diag H) step = -slope` (Levenberg 1944, Marquardt 1963).
fn damped_step(curvature: &DMatrix<f64>, slope: &DVector<f64>, damping: f64) -> Option<DVector<f64>> {
    if slope.is_empty() {
        return None;
    }
    let mut damped = curvature.clone();
    // A light that no channel uses has no slope and no curvature: it stays where it is.
    let floor = 1e-14 * curvature.diagonal().max();
    for i in 0..slope.len() {
        damped[(i, i)] += damping * curvature[(i, i)] + floor;
    }
    (floor > 0.0).then(|| damped.cholesky().map(|factor| factor.solve(&-slope))).flatten()
}

/// `J^T J` and `J^T r` of the head of this file, for the lights that may move.
fn normal_equations(problem: &Problem<'_>, state: &State) -> (DMatrix<f64>, DVector<f64>) {
    let Moments { gram, right, .. } = &state.moments;
    let first = state.moments.columns() + 2 * problem.held;
    let size = gram.nrows() - first;
    let derivatives = gram.view((first, 0), (size, gram.ncols()));
    let explained = derivatives.columns(0, state.x.nrows()) * &state.x;
    let (mut curvature, mut slope) = (DMatrix::zeros(size, size), DVector::zeros(size));
    let mut outside: Option<(Vec<usize>, DMatrix<f64>)> = None;
    for channel in 0..state.x.ncols() {
        let (used, dark) = (state.used(problem.probe, channel), &state.dark[channel]);
        // Channels that use the same lights share the projection.
        if !dark.is_empty() || outside.as_ref().is_none_or(|(last, _)| *last != used) {
            outside = project(gram, first, &used, dark).map(|outside| (used, outside));
        }
        let Some((_, outside)) = &outside else { continue };
        let copies = problem.probe.copies(channel);
        let irradiance = state.irradiance();
        let of = DVector::from_fn(size, |i, _| irradiance[(problem.held + i / 2, channel)]);
        let (right, explained) = (right.column(channel), explained.column(channel));
        for a in 0..size {
            slope[a] -= copies * of[a] * (right[first + a] - explained[a]);
            let mut curvature = curvature.column_mut(a);
            curvature.zip_zip_apply(&of, &outside.column(a), |sum, of_b, outside| {
                *sum += copies * of[a] * of_b * outside;
            });
        }
    }
    (curvature, slope)
}

/// Inner products of the derivatives from column `first` on, outside the span of the `used` columns.
///
/// With the factor L of the used columns' Gram matrix, `V = D^T A L^-T` holds what is inside. Where
/// the ambient term is held at zero for the normals `dark`, with rows C, the used columns may not
/// follow along `U = C L^-T`: that part of V is outside again.
fn project(gram: &DMatrix<f64>, first: usize, used: &[usize], dark: &[DVec3]) -> Option<DMatrix<f64>> {
    let factor = nnls::factor(&gram.as_view(), used)?;
    let size = gram.nrows() - first;
    let derivatives = DMatrix::from_fn(size, used.len(), |i, j| gram[(first + i, used[j])]);
    let inside = nnls::orthonormal(&factor, derivatives);
    let mut outside = gram.view((first, first), (size, size)).into_owned();
    outside.gemm(-1.0, &inside, &inside.transpose(), 1.0);
    if !dark.is_empty() {
        let columns: Vec<[f64; 9]> = dark.iter().map(|&n| Ambient::Sh2.irradiance(n)).collect();
        let held = DMatrix::from_fn(dark.len(), used.len(), |i, j| *columns[i].get(j).unwrap_or(&0.0));
        let basis = nnls::orthonormal(&factor, held).transpose().col_piv_qr().q();
        let back = inside * basis;
        outside += &back * back.transpose();
    }
    Some(outside)
}
