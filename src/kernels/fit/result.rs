//! The result of a fit: a set of lights with its sizes and errors.

use std::iter::once;
use std::time::Instant;

use super::comparison::Comparison;
use super::discs::{Sized, Sizes};
use super::light_count::{self, Trial};
use super::objective::Reference;
use super::problem::Problem;
use super::rig::Rig;
use super::samples::{ProbeError, Samples};
use super::state::{State, StopReason};
use super::uncertainty::{Uncertainty, tolerances};

/// Wall time of each step.
#[derive(Clone, Debug)]
pub struct Clock {
    laps: Vec<(&'static str, f64)>,
    last: Instant,
}

impl Clock {
    /// A clock without laps.
    pub fn start() -> Self {
        Self { laps: Vec::new(), last: Instant::now() }
    }

    /// Store the time since the last lap as that of a `step`.
    pub fn lap(&mut self, step: &'static str) {
        self.laps.push((step, self.last.elapsed().as_secs_f64()));
        self.last = Instant::now();
    }
}

/// The best rig and its errors.
#[derive(Clone, Debug)]
pub struct FitResult {
    /// Ambient and lights, the fixed ones first.
    pub rig: Rig,
    /// Angular radius of each light, in radians: 0 for a point.
    pub radii: Vec<f64>,
    /// Lights whose radius is at the greatest one of the options.
    pub at_bound: Vec<usize>,
    /// Error of the rig.
    pub probe_error: ProbeError,
    /// Relative RMS error of the irradiance with shadows, under a map: `discs/`.
    pub shadow_error: f64,
    /// Relative RMS error that the discs minimise; of the irradiance if the lights are points.
    pub objective_error: f64,
    /// Relative RMS error of the rig in a program that shows its lights as points.
    pub points_error: f64,
    /// Relative RMS error of as many lights, fitted as points.
    pub fitted_points_error: f64,
    /// Relative RMS error by number of lights: of points, unless an error ended the search.
    pub errors: Vec<(usize, f64)>,
    /// Number of fitted channels: not black, and not equal to another.
    pub channels: usize,
    /// Steps of the descents that led to the result.
    pub steps: usize,
    /// Reason for the end of the last descent.
    pub stop: StopReason,
    /// Direction tolerance of each light under a map, in radians: the turn that makes the error a tenth larger.
    pub tolerances: Vec<f64>,
    /// Standard errors and condition number of a fit to measured values.
    pub uncertainty: Uncertainty,
    /// Wall time of each step, in seconds.
    pub seconds: Vec<(&'static str, f64)>,
}

/// Evaluation of sets of lights.
#[derive(Debug)]
pub enum Evaluator<'a> {
    /// Under a map, in closed form.
    Map(Box<Sizes<'a>>),
    /// At known normals, of points.
    Samples(&'a Samples),
}

impl Evaluator<'_> {
    /// The map with shadows, if there is a map.
    fn sizes(&self) -> Option<&Sizes<'_>> {
        match self {
            Self::Map(sizes) => Some(sizes),
            Self::Samples(_) => None,
        }
    }

    /// Errors of a rig whose lights have these radii.
    fn probe_error(&self, reference: &Reference, rig: &Rig, radii: &[f64]) -> ProbeError {
        match self {
            Self::Map(sizes) => sizes.errors(Comparison::Probe, reference, rig, radii),
            Self::Samples(samples) => samples.evaluate(rig, radii),
        }
    }

    /// Error of a rig whose lights are points.
    fn points_error(&self, reference: &Reference, rig: &Rig) -> f64 {
        self.probe_error(reference, rig, &vec![0.0; rig.directions.len()]).error
    }

    /// Errors of a set on the way to the final number of lights: with sizes if an error ends the search, else of points.
    pub fn trial(&self, problem: &Problem<'_>, state: State) -> Trial {
        if problem.options.has_goal() {
            return self.sized(problem, state, &[]).0;
        }
        let reference = problem.objective.reference();
        let error = self.points_error(reference, &state.rig(reference));
        Trial { state, others: Vec::new(), error, shadow_error: 0.0, gloss_error: 0.0 }
    }

    /// A set with its errors, and the rig with sizes if the options ask for them.
    fn sized(&self, problem: &Problem<'_>, state: State, others: &[State]) -> (Trial, Sized, ProbeError) {
        let (reference, options) = (problem.objective.reference(), problem.options);
        let rig = state.rig(reference);
        let sized = match (self.sizes(), options.sizes) {
            (Some(sizes), Some(comparison)) => {
                let rigs: Vec<Rig> =
                    once(rig).chain(others.iter().map(|other| other.rig(reference))).collect();
                // With the other objectives a selection takes as long again at 8 lights, and lowers the error of none of
                // nine real maps.
                let is_for_shadows = comparison == Comparison::Shadows;
                let can_select = is_for_shadows && !problem.has_start() && !options.is_plain;
                sizes.fit(comparison, reference, &rigs, options.fixed, options.max_steps, can_select)
            }
            _ => Sized::points(rig),
        };
        let probe_error = self.probe_error(reference, &sized.rig, &sized.radii);
        let under_map = |error: &dyn Fn(&Sizes<'_>) -> f64| self.sizes().map_or(0.0, error);
        let shadow_error =
            under_map(&|sizes| sizes.errors(Comparison::Shadows, reference, &sized.rig, &sized.radii).error);
        let gloss_error =
            under_map(&|sizes| sizes.gloss_error(&sized.rig, &sized.radii, &options.gloss_factors));
        let error = probe_error.error;
        (Trial { state, others: Vec::new(), error, shadow_error, gloss_error }, sized, probe_error)
    }

    /// The best of the sets in `path`, with its sizes and errors.
    pub fn best(&self, problem: &Problem<'_>, path: &[Trial], mut clock: Clock) -> FitResult {
        let Problem { objective, options } = *problem;
        let chosen = light_count::choose(options, path);
        let state = problem.descent().polish(path[chosen].state.clone());
        let state = state.without_black(objective, options.fixed).unwrap_or(state);
        let (trial, sized, probe_error) = self.sized(problem, state, &path[chosen].others);
        clock.lap("sizes");
        let mut errors: Vec<(usize, f64)> =
            path.iter().map(|trial| (trial.state.lights(), trial.error)).collect();
        // The errors of other numbers are those of points.
        if options.has_goal() || options.sizes.is_none() || sized.radii.is_empty() {
            errors[chosen].1 = probe_error.error;
        }
        let reference = objective.reference();
        let objective_error = match (self.sizes(), options.sizes) {
            (Some(sizes), Some(kernel)) => sizes.errors(kernel, reference, &sized.rig, &sized.radii).error,
            _ => probe_error.error,
        };
        let cost = probe_error.error.powi(2) * reference.energy;
        let of_points = || self.sizes().map(|_| tolerances(&problem.descent(), &trial.state, cost));
        let tolerances = sized.tolerances.or_else(of_points).unwrap_or_default();
        let points_error = self.points_error(reference, &sized.rig);
        let fitted_points_error = self.points_error(reference, &trial.state.rig(reference));
        clock.lap("evaluate");
        FitResult {
            points_error,
            fitted_points_error,
            rig: sized.rig,
            radii: sized.radii,
            at_bound: sized.at_bound,
            probe_error,
            shadow_error: trial.shadow_error,
            objective_error,
            errors,
            channels: reference.channels.len(),
            steps: trial.state.steps + sized.steps,
            stop: sized.stop.or(trial.state.stop).unwrap_or(StopReason::Converged),
            tolerances,
            uncertainty: Uncertainty::default(),
            seconds: clock.laps,
        }
    }
}
