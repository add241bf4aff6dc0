//! Steps to the bottom of a valley, with damping.
//!
//! The tangent plane of a direction has no pole, where the paper's angles theta and phi lose a rank. Gauss and
//! Newton's steps come first, as they never lead to a saddle; where they gain little, exact ones finish.
//!
//! The cost over given normals bends where a light crosses the horizon of one. A minimum often lies in such a
//! kink: from either side the slope leads into it, and no step across leads down. From there the way goes on
//! along the kink. A floor is such a wall as well.

use glam::DVec3;
use nalgebra::DVector;

use super::newton::{Kink, Quadratic};
use super::problem::Problem;
use super::state::{RESOLUTION, State, StopReason};
use crate::kernels::sphere::{exponential_map, tangents};

/// A light never turns by more than this in one step, in radians: the model is true only nearby.
pub const LONGEST_STEP: f64 = 0.5;
/// Least damping: with less, rounding would choose the way along what the cost hardly depends on.
pub const LEAST_DAMPING: f64 = 1e-5;
/// Damping at which a step no longer moves anything.
pub const STIFFEST: f64 = 1e8;
/// Damping from which a small gain says nothing of the valley.
pub const STIFF: f64 = 0.1;
/// Relative gain of a step below which second derivatives are worth their time.
const LITTLE: f64 = 0.03;
/// A step that crosses more horizons than this for each light failed for its length.
const MOST_KINKS: usize = 2;

impl State {
    /// Downhill until a step lowers the cost by less than the share `tolerance` of it.
    pub fn descend(mut self, problem: &Problem<'_>, tolerance: f64) -> Self {
        for _ in 0..problem.max_steps {
            if self.stop.is_some() {
                return self;
            }
            self = self.step(problem, tolerance);
        }
        self.stop = self.stop.or(Some(StopReason::OutOfSteps));
        self
    }

    /// The last digits, where the cost is a difference that no longer shows them: steps without damping, as long
    /// as each is less than half of the one before.
    pub fn polished(mut self, problem: &Problem<'_>) -> Self {
        /// The longest first step, in radians: farther from the bottom the model may not be trusted blindly.
        const LONGEST: f64 = 1e-3;
        let resolution = RESOLUTION * problem.objective.given().energy;
        let mut longest = LONGEST;
        while let Some(step) = Quadratic::around(problem, &self, true).step(0.0, &[]) {
            let next = self.turned_to(problem.objective, self.directions_after(problem, &step));
            let is_allowed = next.moments.directions.iter().all(|&l| problem.objective.allows(l));
            // Not a number where there is no light to turn.
            if !(step.amax() < longest && next.cost <= self.cost + resolution && is_allowed) {
                break;
            }
            longest = 0.5 * step.amax();
            self = Self { steps: self.steps + 1, stop: self.stop, ..next };
        }
        self
    }

    /// One damped step downhill; at the bottom none, and the reason why.
    fn step(mut self, problem: &Problem<'_>, tolerance: f64) -> Self {
        let is_exact = self.gain < LITTLE && tolerance < LITTLE;
        let model = Quadratic::around(problem, &self, is_exact);
        let Some(mut next) = self.lower(problem, &model, tolerance, &[]) else {
            if self.gain >= LITTLE && tolerance < LITTLE {
                self.gain = 0.0; // no step of the first kind is left
                return self;
            }
            self.stop = Some(StopReason::Converged);
            return self;
        };
        next.gain = (self.cost - next.cost) / self.cost.max(f64::MIN_POSITIVE);
        let is_last = is_exact || tolerance >= LITTLE;
        if next.gain <= tolerance && is_last && next.damping < STIFF {
            next.stop = next.stop.or(Some(StopReason::Converged));
        }
        next
    }

    /// The first step that lowers the cost, with more and more damping, on `kinks` if there are any.
    fn lower(
        &self,
        problem: &Problem<'_>,
        model: &Quadratic,
        tolerance: f64,
        kinks: &[Kink],
    ) -> Option<Self> {
        let mut damping = self.damping;
        while damping < STIFFEST {
            let Some(step) = model.step(damping, kinks) else {
                damping *= 10.0;
                continue;
            };
            // Less than that is not worth the try.
            if model.fall(&step) <= 0.1 * tolerance * self.cost {
                break;
            }
            let next = self.turned_to(problem.objective, self.directions_after(problem, &step));
            let is_allowed = next.moments.directions.iter().all(|&l| problem.objective.allows(l));
            if next.cost < self.cost && is_allowed {
                // What has just failed will fail again.
                let ease = if damping > self.damping { 0.3 } else { 0.1 };
                let damping = (damping * ease).max(LEAST_DAMPING);
                return Some(Self { damping, steps: self.steps + 1, ..next });
            }
            if kinks.is_empty()
                && let Some(kinks) = self.kinks_before(problem, &next)
                && let Some(next) = self.lower(problem, model, tolerance, &kinks)
            {
                return Some(next);
            }
            damping *= 10.0;
        }
        None
    }

    /// What bends the cost on the way to `next`, unless that is too far to say.
    fn kinks_before(&self, problem: &Problem<'_>, next: &Self) -> Option<Vec<Kink>> {
        let crossed = problem.objective.kinks(&self.moments, &next.moments);
        let kink = |(light, normal): (usize, DVec3)| Kink {
            first: 2 * (light - problem.fixed),
            across: tangents(self.moments.directions[light]).map(|tangent| normal.dot(tangent)),
            ahead: -normal.dot(self.moments.directions[light]),
        };
        (1..=MOST_KINKS * self.lights())
            .contains(&crossed.len())
            .then(|| crossed.into_iter().map(kink).collect())
    }

    /// Every direction turned by its part of `step`.
    fn directions_after(&self, problem: &Problem<'_>, step: &DVector<f64>) -> Vec<DVec3> {
        let mut directions = self.moments.directions.clone();
        for (i, light) in (problem.fixed..directions.len()).enumerate() {
            let [s, t] = tangents(directions[light]);
            let along = s * step[2 * i] + t * step[2 * i + 1];
            directions[light] = exponential_map(directions[light], along.clamp_length_max(LONGEST_STEP));
        }
        directions
    }
}
