//! What is asked of a fit.

use glam::DVec3;

use super::objective::Objective;

/// What is asked of a fit.
#[derive(Clone, Copy, Debug)]
pub struct Problem<'a> {
    /// What is minimised.
    pub objective: &'a dyn Objective,
    /// Where the first lights start, brightest first. Those beyond start where they explain most.
    pub start: &'a [DVec3],
    /// How many of these keep their directions, and get only their radiances.
    pub fixed: usize,
    /// Lights at most.
    pub lights: usize,
    /// Relative RMS error at which no more lights are added.
    pub error: Option<f64>,
    /// Steps after which a descent gives up.
    pub max_steps: usize,
}
