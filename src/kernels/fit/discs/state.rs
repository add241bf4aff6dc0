//! One place of the descent: discs, their best fluxes, and what that costs.

use std::sync::Arc;

use glam::DVec3;
use nalgebra::DMatrix;

use super::disc::Disc;
use super::target::Target;
use crate::interrupt;
use crate::kernels::fit::nnls::Support;
use crate::kernels::fit::objective::Given;
use crate::kernels::fit::radiances::{self, Radiances};
use crate::kernels::sphere::exponential_map;

/// The greatest radius, in radians: 75 degrees.
pub const GREATEST_RADIUS: f64 = 75.0 / 180.0 * std::f64::consts::PI;
/// The least radius: .003 degrees. A smaller one changes nothing that can be seen.
pub const LEAST_RADIUS: f64 = 5e-5;

/// What is asked of a descent.
#[derive(Clone, Copy, Debug)]
pub struct Problem<'a> {
    pub target: &'a Target,
    /// Channels and ambient term, as in the search before.
    pub given: &'a Given,
    /// Lights whose direction stays.
    pub fixed: usize,
    /// Steps after which a descent gives up.
    pub max_steps: usize,
}

/// One place of the descent.
#[derive(Clone, Debug)]
pub struct State {
    pub discs: Vec<Disc>,
    /// Coefficients of the ambient term, then flux of the lights; a column for each channel.
    pub x: DMatrix<f64>,
    pub supports: Vec<Arc<Support>>,
    pub cost: f64,
}

impl Problem<'_> {
    /// The greatest radius of a light in a direction: over a floor, the whole disc stands above the horizon.
    pub fn greatest_radius(&self, direction: DVec3) -> f64 {
        let elevation = direction.y.clamp(0.0, 1.0).asin();
        let most = if self.given.has_floor { GREATEST_RADIUS.min(elevation) } else { GREATEST_RADIUS };
        most.max(LEAST_RADIUS)
    }

    /// The disc nearest to one of that direction and radius.
    pub fn disc(&self, direction: DVec3, radius: f64) -> Disc {
        Disc::new(direction, radius.clamp(LEAST_RADIUS, self.greatest_radius(direction)))
    }
}

impl State {
    /// The best fluxes of `discs`; those that are not 0 may be those of `guess`.
    pub fn new(problem: &Problem<'_>, discs: Vec<Disc>, guess: &[Arc<Support>]) -> Self {
        interrupt::check();
        let given = problem.given;
        let (gram, rgb) = problem.target.products(&discs);
        let rhs = DMatrix::from_fn(rgb.nrows(), given.channels.len(), |i, c| rgb[(i, given.channels[c])]);
        let Radiances { x, supports, .. } = radiances::solve(given, &gram, &rhs, guess);
        let used = &gram * &x;
        let cost = |c: usize| {
            let explained = 2.0 * rhs.column(c).dot(&x.column(c)) - used.column(c).dot(&x.column(c));
            given.copies(c) * (problem.target.energy[given.channels[c]] - explained)
        };
        let cost = (0..given.channels.len()).map(cost).sum();
        Self { discs, x, supports, cost }
    }

    /// With every light turned along its tangents, and its radius multiplied by the exponential of the third coordinate.
    pub fn moved(&self, problem: &Problem<'_>, step: &[f64]) -> Self {
        let moved = |(disc, step): (&Disc, &[f64])| {
            let [s, t] = disc.frame();
            let direction = exponential_map(disc.direction, s * step[0] + t * step[1]);
            let is_below = problem.given.has_floor && direction.y < 0.0;
            let direction = if is_below { direction.with_y(0.0).normalize_or(DVec3::X) } else { direction };
            problem.disc(direction, disc.radius * step[2].exp())
        };
        let discs = self.discs.iter().zip(step.as_chunks::<3>().0).map(|(disc, step)| moved((disc, step)));
        Self::new(problem, discs.collect(), &self.supports)
    }

    /// Without the lights that no channel uses, but for fixed ones.
    pub fn without_black(self, problem: &Problem<'_>) -> Self {
        let first = self.x.nrows() - self.discs.len();
        let is_used = |light: usize| light < problem.fixed || self.x.row(first + light).amax() > 0.0;
        let kept: Vec<Disc> = self
            .discs
            .iter()
            .enumerate()
            .filter(|(light, _)| is_used(*light))
            .map(|(_, disc)| *disc)
            .collect();
        if kept.len() == self.discs.len() { self } else { Self::new(problem, kept, &[]) }
    }
}
