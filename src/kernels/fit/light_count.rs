//! The number of lights: one more at a time, until an error is reached or more lights do not help.

use rayon::prelude::*;

use super::damped_newton::Descent;
use super::options::FitOptions;
use super::problem::Problem;
use super::search::Search;
use super::settings::SEARCH;
use super::state::{State, StopReason};
use crate::error::Result;

/// Evaluation of a set of lights.
pub type Evaluate<'a> = &'a (dyn Fn(State) -> Trial + Sync);

/// A set of lights and its errors.
#[derive(Clone, Debug)]
pub struct Trial {
    pub state: State,
    /// Other minima with as many lights, from which lights with a size descend as well.
    pub others: Vec<State>,
    pub error: f64,
    pub shadow_error: f64,
    /// Error of a shiny object, if one is requested.
    pub gloss_error: f64,
}

impl FitOptions {
    /// True if the caller named errors and a trial reaches them all.
    fn is_reached(&self, trial: &Trial) -> bool {
        self.has_goal()
            && self.error.is_none_or(|most| trial.error <= most)
            && self.shadow_error.is_none_or(|most| trial.shadow_error <= most)
            && self.gloss_error.is_none_or(|most| trial.gloss_error <= most)
    }

    /// The error by which numbers of lights are compared.
    fn comparison_error(&self, trial: &Trial) -> f64 {
        if self.gloss_error.is_some() {
            trial.gloss_error
        } else if self.shadow_error.is_some() {
            trial.shadow_error
        } else {
            trial.error
        }
    }
}

/// The best set with each number of lights on the way to each of `counts`, which are at most `problem.lights`, evaluated by
/// `evaluate`. The search stops when the error is at most `options.error_floor`.
///
/// A path is that of a search for its number alone: forward selection finds the same sets on the way to each.
pub fn search_paths(
    problem: &Problem<'_>,
    counts: &[usize],
    evaluate: Evaluate<'_>,
) -> Result<Vec<Vec<Trial>>> {
    let search = Search::new(problem);
    let (path, beams) = selection_path(&search, evaluate)?;
    let path_to = |&count: &usize| {
        let end = beams.iter().rposition(|beam| beam[0].lights() <= count).unwrap_or(0);
        let mut path = path[..=end].to_vec();
        // Search for the final number of lights, unless that has happened.
        let has_search = !problem.options.has_goal() && !problem.has_start();
        if has_search && beams[end][0].lights() > problem.options.fixed {
            let mut others = search.best(beams[end].clone())?;
            let best = others.remove(0);
            path[end] = Trial { others, ..evaluate(best) };
        }
        Ok(path)
    };
    counts.par_iter().map(path_to).collect()
}

/// The best set with each number of lights by forward selection, and the sets it was selected from.
fn selection_path(search: &Search<'_>, evaluate: Evaluate<'_>) -> Result<(Vec<Trial>, Vec<Vec<State>>)> {
    let problem = search.problem;
    let mut beam = vec![near_start(problem, 0)];
    let (mut path, mut beams) = (vec![evaluate(beam[0].clone())], vec![beam.clone()]);
    while beam[0].lights() < problem.options.lights && !is_enough(problem.options, &path) {
        beam = larger_sets(search, &beam)?;
        let Some(best) = beam.first() else { break };
        path.push(evaluate(best.clone()));
        beams.push(beam.clone());
    }
    Ok((path, beams))
}

/// The sets with more lights than those of `beam`, best first; empty if no light helps.
fn larger_sets(search: &Search<'_>, beam: &[State]) -> Result<Vec<State>> {
    let problem = search.problem;
    let FitOptions { start, fixed, lights, .. } = problem.options;
    let count = beam[0].lights();
    if count < start.len() {
        let next = if problem.options.has_goal() { *fixed.max(&(count + 1)) } else { start.len() };
        return Ok(vec![refill(search, near_start(problem, next.min(*lights)))]);
    }
    let mut grown = search.grow(beam);
    if problem.has_start() {
        grown.truncate(1);
        return Ok(grown.into_iter().map(|state| problem.descent().run(state, SEARCH.fine)).collect());
    }
    if problem.options.has_goal() {
        let best = search.best(grown.clone())?;
        grown.splice(0..0, best.into_iter().take(1));
    }
    Ok(grown)
}

/// The best lights near the first `count` starts.
fn near_start(problem: &Problem<'_>, count: usize) -> State {
    let FitOptions { start, fixed, .. } = problem.options;
    let descent = Descent { fixed: *fixed.min(&count), ..problem.descent() };
    descent.run(State::new(problem.objective, &start[..count]), SEARCH.fine)
}

/// Replace lights that are black in all channels by new lights, and descend again.
fn refill(search: &Search<'_>, state: State) -> State {
    let lights = state.lights();
    let Problem { objective, options } = *search.problem;
    let Some(mut state) = state.without_black(objective, options.fixed) else { return state };
    while state.lights() < lights {
        let Some(next) = search.grow(std::slice::from_ref(&state)).into_iter().next() else { break };
        state = next;
    }
    search.problem.descent().run(state, SEARCH.fine)
}

/// True if the residual is 0, the errors of the options are reached, or the last lights have not lowered the error.
fn is_enough(options: &FitOptions, path: &[Trial]) -> bool {
    let Some(last) = path.last() else { return false };
    let lights = last.state.lights();
    if lights < options.fixed {
        return false;
    }
    let allowed: Vec<&Trial> = path.iter().filter(|trial| trial.state.lights() >= options.fixed).collect();
    // The first lights of a sky may raise the errors of shadows and of shiny objects while they lower that of the probe.
    let useful = last_gain(&allowed, &|trial| options.comparison_error(trial))
        .max(last_gain(&allowed, &|trial| trial.error))
        .max(options.fixed);
    last.state.stop == Some(StopReason::Exact)
        || last.error <= options.error_floor
        || options.is_reached(last)
        || lights >= useful + SEARCH.patience
}

/// Number of lights of the last trial whose error is less than that of all before it.
fn last_gain(path: &[&Trial], error: &dyn Fn(&Trial) -> f64) -> usize {
    let mut best = (f64::INFINITY, 0);
    for trial in path {
        if error(trial) < best.0 * (1.0 - SEARCH.worth_a_light) {
            best = (error(trial), trial.state.lights());
        }
    }
    best.1
}

/// Index of the set with the fewest lights that reaches the errors of the options.
///
/// If no set reaches them, the set with the fewest lights and nearly the least error is chosen. Sets with fewer lights
/// than the start are skipped.
pub fn choose(options: &FitOptions, path: &[Trial]) -> usize {
    let least = path.iter().map(|trial| options.comparison_error(trial)).fold(f64::INFINITY, f64::min);
    let enough = (least * (1.0 + SEARCH.worth_a_light)).max(options.error_floor);
    let is_reached = path.iter().any(|trial| options.is_reached(trial));
    let is_enough = |trial: &Trial| {
        if is_reached { options.is_reached(trial) } else { options.comparison_error(trial) <= enough }
    };
    let last = path.len() - 1;
    let reference = options.start.len().min(path[last].state.lights());
    path.iter().position(|trial| is_enough(trial) && trial.state.lights() >= reference).unwrap_or(last)
}
