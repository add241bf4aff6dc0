//! The best directions near given ones: variable projection with damped Gauss-Newton steps.
//!
//! For fixed directions the best radiances are a small linear problem (`radiances.rs`), so only the 2M
//! tangent coordinates of the directions are left (Golub and Pereyra 1973). The tangent plane has no
//! pole, where the paper's angles theta and phi lose a rank.
//!
//! The cost bends where a light crosses the horizon of a normal. A minimum often lies in such a crease:
//! from either side the slope leads into it, and no step across leads down. From there the way goes on
//! along the crease.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use glam::DVec3;
use nalgebra::{DMatrix, DMatrixView, DVector, Dyn, U1};

use super::moments::Moments;
use super::nnls::Support;
use super::probe::Probe;
use super::quadratic::{Crease, Quadratic};
use super::radiances::{self, Radiances};
use super::{Rig, StopReason};
use crate::kernels::sphere::{exponential_map, tangents};

/// A light never turns by more than this in one step, in radians: the model is linear only nearby.
const LONGEST_STEP: f64 = 0.5;
/// Damping of a first step.
const FIRST_DAMPING: f64 = 1e-3;
/// Least damping: with less, rounding would choose the way along what the cost hardly depends on.
const LEAST_DAMPING: f64 = 1e-5;
/// Damping at which a step no longer moves anything.
const STIFFEST: f64 = 1e8;
/// A step that crosses more horizons than this for each light failed for its length.
const MOST_CREASES: usize = 2;
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
    /// Set once no answer is wanted any more.
    pub is_over: &'a AtomicBool,
}

impl Problem<'_> {
    /// Whether to leave everything as it is.
    pub fn is_over(&self) -> bool {
        self.is_over.load(Ordering::Relaxed)
    }
}

/// One place of the search: directions, their best radiances, and what that costs.
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
    damping: f64,
    /// Steps that led here, from wherever the search began.
    pub steps: usize,
    /// Why no step leads on, once that is so.
    pub stop: Option<StopReason>,
}

impl State {
    /// The best radiances of lights in `directions`.
    pub fn new(probe: &Probe, directions: &[DVec3]) -> Self {
        Self::at(probe, Moments::new(probe, directions), 0, &[])
    }

    /// The best radiances of the lights of `moments`, after so many `steps`; those that are not 0 may be
    /// those of `guess`.
    pub fn at(probe: &Probe, moments: Moments, steps: usize, guess: &[Arc<Support>]) -> Self {
        let Radiances { x, supports, dark } = radiances::solve(probe, &moments.gram, &moments.right, guess);
        let cost = cost(probe, &moments.gram, &moments.right, &x);
        let damping = FIRST_DAMPING;
        let mut state = Self { moments, x, supports, dark, cost, damping, steps, stop: None };
        if cost <= SMALL * probe.samples.energy {
            state.cost = probe.samples.cost(&state.rig(probe));
        }
        if state.cost <= EXACT * probe.samples.energy {
            state.stop = Some(StopReason::Exact);
        }
        state
    }

    /// The same lights in other `directions`, with the best radiances for these.
    pub fn turned_to(&self, probe: &Probe, directions: Vec<DVec3>) -> Self {
        Self::at(probe, self.moments.turned(probe, directions), self.steps, &self.supports)
    }

    /// How many lights there are.
    pub fn lights(&self) -> usize {
        self.moments.directions.len()
    }

    /// Irradiance of the lights: a row for each, a column for each channel.
    pub fn irradiance(&self) -> DMatrixView<'_, f64, U1, Dyn> {
        self.x.rows(self.x.nrows() - self.lights(), self.lights())
    }

    /// Without the lights that no channel uses, if there are such beyond those that are held: nothing
    /// pulls at a light of radiance 0, so it would stay where it started.
    pub fn without_black(&self, problem: &Problem<'_>) -> Option<Self> {
        let is_lit = |&light: &usize| light < problem.held || self.irradiance().row(light).amax() > 0.0;
        let kept: Vec<usize> = (0..self.lights()).filter(is_lit).collect();
        (kept.len() < self.lights()).then(|| {
            let moments = self.moments.with(problem.probe, &kept, &[]);
            Self::at(problem.probe, moments, self.steps, &[])
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
            if self.stop.is_some() || problem.is_over() {
                break;
            }
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
        let near = Quadratic::around(problem, &self);
        let Some(mut next) = self.lower(problem, &near, still, &[]) else {
            self.stop = Some(StopReason::Converged);
            return self;
        };
        if self.cost - next.cost <= still * self.cost {
            next.stop = next.stop.or(Some(StopReason::Converged));
        }
        next
    }

    /// The first step that lowers the cost, with more and more damping, on `creases` if there are any.
    fn lower(&self, problem: &Problem<'_>, near: &Quadratic, still: f64, creases: &[Crease]) -> Option<Self> {
        let mut damping = self.damping;
        while damping < STIFFEST {
            let step = near.step(damping, creases)?;
            // Less than that is not worth the try.
            if near.fall(&step) <= 0.1 * still * self.cost {
                break;
            }
            let next = self.turned_to(problem.probe, self.directions_after(problem, &step));
            if next.cost < self.cost {
                let damping = (damping * 0.1).max(LEAST_DAMPING);
                return Some(Self { damping, steps: self.steps + 1, ..next });
            }
            if creases.is_empty()
                && let Some(creases) = self.creases_before(problem, &next)
                && let Some(next) = self.lower(problem, near, still, &creases)
            {
                return Some(next);
            }
            damping *= 10.0;
        }
        None
    }

    /// What bends the cost on the way to `next`, unless that is too far to say.
    fn creases_before(&self, problem: &Problem<'_>, next: &Self) -> Option<Vec<Crease>> {
        let crossed = self.moments.crossed(problem.probe, &next.moments);
        let crease = |(light, normal): (usize, DVec3)| Crease {
            first: 2 * (light - problem.held),
            across: tangents(self.moments.directions[light]).map(|tangent| normal.dot(tangent)),
            ahead: -normal.dot(self.moments.directions[light]),
        };
        (1..=MOST_CREASES * self.lights())
            .contains(&crossed.len())
            .then(|| crossed.into_iter().map(crease).collect())
    }

    /// Every direction turned by its part of `step`.
    fn directions_after(&self, problem: &Problem<'_>, step: &DVector<f64>) -> Vec<DVec3> {
        let mut directions = self.moments.directions.clone();
        for (i, light) in (problem.held..directions.len()).enumerate() {
            let [s, t] = tangents(directions[light]);
            let along = s * step[2 * i] + t * step[2 * i + 1];
            directions[light] = exponential_map(directions[light], along.clamp_length_max(LONGEST_STEP));
        }
        directions
    }
}

/// What the values `x` leave unexplained, from inner products: good to about 1e-15 of the energy.
pub fn cost(probe: &Probe, gram: &DMatrix<f64>, right: &DMatrix<f64>, x: &DMatrix<f64>) -> f64 {
    let used = gram * x;
    let explained = |c: usize| 2.0 * right.column(c).dot(&x.column(c)) - used.column(c).dot(&x.column(c));
    probe.samples.energy - (0..x.ncols()).map(|c| probe.copies(c) * explained(c)).sum::<f64>()
}
