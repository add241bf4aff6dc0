//! A search for lights: an objective, and the lights that the caller fixed or started.

use glam::DVec3;

use super::damped_newton::Descent;
use super::objective::PointObjective;
use super::options::FitOptions;

/// A search for the lights of one objective.
#[derive(Clone, Copy, Debug)]
pub struct Problem<'a> {
    /// Cost of lights without a size.
    pub objective: &'a dyn PointObjective,
    /// Initial directions of the first lights, brightest first. Others start where they lower the cost most.
    pub start: &'a [DVec3],
    /// Number of these that keep their directions.
    pub fixed: usize,
    /// Greatest number of lights.
    pub lights: usize,
    /// Greatest number of steps of one descent.
    pub max_steps: usize,
    /// True for the plain search of benchmarks.
    pub is_plain: bool,
}

impl<'a> Problem<'a> {
    /// The search that the options ask for.
    pub fn new(objective: &'a dyn PointObjective, options: &'a FitOptions) -> Self {
        let &FitOptions { ref start, fixed, lights, max_steps, is_plain, .. } = options;
        Self { objective, start, fixed, lights, max_steps, is_plain }
    }

    /// A descent of a set of lights.
    pub fn descent(&self) -> Descent<'a> {
        Descent { objective: self.objective.base(), fixed: self.fixed, max_steps: self.max_steps }
    }
}
