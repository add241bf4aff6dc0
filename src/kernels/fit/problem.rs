//! A search for lights: an objective, and the options of the caller.

use super::damped_newton::Descent;
use super::objective::PointObjective;
use super::options::FitOptions;

/// A search for the lights of one objective.
#[derive(Clone, Copy, Debug)]
pub struct Problem<'a> {
    /// Cost of lights without a size.
    pub objective: &'a dyn PointObjective,
    /// Starts, numbers of lights and errors that the caller wants.
    pub options: &'a FitOptions,
}

impl<'a> Problem<'a> {
    /// A descent of a set of lights.
    pub fn descent(&self) -> Descent<'a> {
        let &FitOptions { fixed, max_steps, .. } = self.options;
        Descent { objective: self.objective, fixed, max_steps }
    }

    /// True if the caller gave starts of lights that may turn: lights stay near them.
    pub fn has_start(&self) -> bool {
        self.options.start.len() > self.options.fixed
    }
}
