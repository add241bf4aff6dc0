//! The result of a fit: a set of lights with its sizes and errors.

use std::iter::once;

use super::comparison::Comparison;
use super::discs::{self, Bands, Sized, Sizes};
use super::light_count::{self, Trial};
use super::problem::Problem;
use super::rig::Rig;
use super::samples::{Judged, Samples};
use super::state::{State, StopReason};
use super::uncertainty::{Uncertainty, tolerances};

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
    pub probe_error: Judged,
    /// Relative RMS error of the irradiance with shadows, under a map: `discs/`.
    pub shadow_error: f64,
    /// Relative RMS error that the discs minimise; of the irradiance if the lights are points.
    pub objective_error: f64,
    /// Energies by degree under a map, for the errors of shiny objects.
    pub bands: Bands,
    /// Relative RMS error of the rig in a program that shows its lights as points.
    pub points_error: f64,
    /// Relative RMS error of as many lights, fitted as points.
    pub fitted_points_error: f64,
    /// Number of normals at which the error is evaluated.
    pub evaluation_normals: usize,
    /// These normals with the irradiance under a map; absent for measured values.
    pub map_samples: Option<Samples>,
    /// Relative RMS error by number of lights: of points, unless an error ended the search.
    pub errors: Vec<(usize, f64)>,
    /// Number of fitted channels: neither black nor the same as another.
    pub channels: usize,
    /// Steps of the descents that led to the result.
    pub steps: usize,
    /// Reason for the end of the last descent.
    pub stop: StopReason,
    /// Direction tolerance of each light under a map, in radians: the turn that makes the error a tenth larger.
    pub tolerances: Vec<f64>,
    /// Standard errors and condition number of a fit to measured values.
    pub uncertainty: Uncertainty,
}

/// Evaluation of sets of lights.
#[derive(Debug)]
pub struct Evaluator<'a> {
    pub samples: &'a Samples,
    /// The map with shadows, if there is a map.
    pub sizes: Option<Sizes<'a>>,
}

impl Evaluator<'_> {
    /// Errors of a set on the way to the final number of lights: with sizes if an error ends the search, else of points.
    pub fn trial(&self, problem: &Problem<'_>, state: State) -> Trial {
        if problem.options.has_goal() {
            return self.sized(problem, state, &[]).0;
        }
        let error = self.samples.error(&state.rig(problem.objective.reference()));
        Trial { state, others: Vec::new(), error, shadow_error: 0.0, gloss_error: 0.0 }
    }

    /// A set with its errors, and the rig with sizes if the options ask for them.
    fn sized(&self, problem: &Problem<'_>, state: State, others: &[State]) -> (Trial, Sized, Judged) {
        let (reference, options) = (problem.objective.reference(), problem.options);
        let rig = state.rig(reference);
        let sized = match (&self.sizes, options.sizes) {
            (Some(sizes), Some(_)) => {
                let rigs: Vec<Rig> =
                    once(rig).chain(others.iter().map(|other| other.rig(reference))).collect();
                // With the other objectives a selection takes as long again at 8 lights, and lowers the error of none of
                // nine real maps.
                let is_for_shadows = options.sizes == Some(Comparison::Shadows);
                let can_select = is_for_shadows && !problem.has_start() && !options.is_plain;
                sizes.fit(reference, &rigs, options.fixed, options.max_steps, can_select)
            }
            _ => Sized::points(rig),
        };
        let probe_error = match options.sizes {
            Some(_) => discs::evaluate(self.samples, &sized.rig, &sized.radii),
            None => self.samples.evaluate(&sized.rig),
        };
        let shadow_error =
            self.sizes.as_ref().map_or(0.0, |sizes| sizes.shadow_error(reference, &sized.rig, &sized.radii));
        let gloss_error = match (&self.sizes, options.gloss_error) {
            (Some(sizes), Some(_)) => sizes.bands(&sized.rig, &sized.radii).error(&options.gloss_factors),
            _ => 0.0,
        };
        let error = probe_error.error;
        (Trial { state, others: Vec::new(), error, shadow_error, gloss_error }, sized, probe_error)
    }

    /// The best of the sets in `path`, with its sizes and errors.
    pub fn best(&self, problem: &Problem<'_>, path: Vec<Trial>) -> FitResult {
        let Problem { objective, options } = *problem;
        let chosen = light_count::choose(options, &path);
        let state = problem.descent().polish(path[chosen].state.clone());
        let state = state.without_black(objective, options.fixed).unwrap_or(state);
        let (trial, sized, probe_error) = self.sized(problem, state, &path[chosen].others);
        let mut errors: Vec<(usize, f64)> =
            path.iter().map(|trial| (trial.state.lights(), trial.error)).collect();
        // The errors of other numbers are those of points.
        if options.has_goal() || options.sizes.is_none() || sized.radii.is_empty() {
            errors[chosen].1 = probe_error.error;
        }
        let reference = objective.reference();
        let objective_error = match (&self.sizes, options.sizes) {
            (Some(sizes), Some(_)) => sizes.objective_error(reference, &sized.rig, &sized.radii),
            _ => probe_error.error,
        };
        let cost = probe_error.error.powi(2) * reference.energy;
        let of_points = || self.sizes.as_ref().map(|_| tolerances(&problem.descent(), &trial.state, cost));
        let tolerances = sized.tolerances.or_else(of_points).unwrap_or_default();
        let bands = self.sizes.as_ref().map(|sizes| sizes.bands(&sized.rig, &sized.radii));
        FitResult {
            bands: bands.unwrap_or_default(),
            points_error: self.samples.error(&sized.rig),
            fitted_points_error: self.samples.error(&trial.state.rig(reference)),
            rig: sized.rig,
            radii: sized.radii,
            at_bound: sized.at_bound,
            probe_error,
            shadow_error: trial.shadow_error,
            objective_error,
            evaluation_normals: self.samples.normals.len(),
            map_samples: None,
            errors,
            channels: reference.channels.len(),
            steps: trial.state.steps + sized.steps,
            stop: sized.stop.or(trial.state.stop).unwrap_or(StopReason::Converged),
            tolerances,
            uncertainty: Uncertainty::default(),
        }
    }
}
