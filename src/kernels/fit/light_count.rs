//! How many lights: more and more, until they are as many as allowed, good enough, or help no more.

use super::problem::Problem;
use super::samples::Samples;
use super::search::{FINE, Search};
use super::state::{State, StopReason};
use crate::error::Result;

/// Share of the error that one light more must take away to be worth it.
const WORTH_A_LIGHT: f64 = 1e-3;

/// The best place found with each number of lights, and the error of each by `judge`.
///
/// Below the error `floor`, what is left is the error of the rendering, and no light is added.
pub fn path(problem: &Problem<'_>, judge: &Samples, floor: f64) -> Result<Vec<(State, f64)>> {
    let search = Search::new(problem);
    let judged = |state: &State| (state.clone(), judge.error(&state.rig(problem.objective.given())));
    let mut beam = vec![started(problem, 0)];
    let mut path = vec![judged(&beam[0])];
    while beam[0].lights() < problem.lights && !is_enough(problem, &path, floor) {
        let next = next(&search, &beam)?;
        let Some(best) = next.first() else { break };
        path.push(judged(best));
        beam = next;
    }
    // The last number deserves a search of its own, unless it had one.
    let has_search = problem.error.is_none() && problem.start.len() == problem.fixed;
    if has_search
        && beam[0].lights() > problem.fixed
        && let Some(best) = search.best(beam)?
    {
        path.pop();
        path.push(judged(&best));
    }
    Ok(path)
}

/// The sets with more lights than those of `beam`, best first; none where no light helps.
fn next(search: &Search<'_>, beam: &[State]) -> Result<Vec<State>> {
    let problem = search.problem;
    let count = beam[0].lights();
    if count < problem.start.len() {
        let next = if problem.error.is_some() { problem.fixed.max(count + 1) } else { problem.start.len() };
        return Ok(vec![refilled(search, started(problem, next.min(problem.lights)))]);
    }
    let mut grown = search.grown(beam);
    if problem.start.len() > problem.fixed {
        // Lights that were given a start stay near it.
        grown.truncate(1);
        return Ok(grown.into_iter().map(|state| state.descend(problem, FINE)).collect());
    }
    if problem.error.is_some()
        && let Some(best) = search.best(grown.clone())?
    {
        grown.insert(0, best);
    }
    Ok(grown)
}

/// The best lights near the first `count` starts.
fn started(problem: &Problem<'_>, count: usize) -> State {
    let problem = Problem { fixed: problem.fixed.min(count), ..*problem };
    State::new(problem.objective, &problem.start[..count]).descend(&problem, FINE)
}

/// With lights that no channel uses put where they help.
fn refilled(search: &Search<'_>, state: State) -> State {
    let lights = state.lights();
    let Some(mut state) = state.without_black(search.problem) else { return state };
    while state.lights() < lights {
        let Some(next) = search.grown(std::slice::from_ref(&state)).into_iter().next() else { break };
        state = next;
    }
    state.descend(search.problem, FINE)
}

/// Nothing is left to explain, the error asked for is reached, or several more lights in a row have
/// not lowered the error: what they explain is the pattern of the normals.
fn is_enough(problem: &Problem<'_>, path: &[(State, f64)], floor: f64) -> bool {
    /// Lights that may fail to lower the error before no more are tried.
    const PATIENCE: usize = 3;
    let Some((last, error)) = path.last() else { return false };
    if last.lights() < problem.fixed {
        return false;
    }
    let fixed = path.iter().filter(|(state, _)| state.lights() >= problem.fixed);
    let mut best = (f64::INFINITY, 0);
    for (state, error) in fixed {
        if *error < best.0 * (1.0 - WORTH_A_LIGHT) {
            best = (*error, state.lights());
        }
    }
    last.stop == Some(StopReason::Exact)
        || *error <= floor
        || problem.error.is_some_and(|wanted| *error <= wanted)
        || last.lights() >= best.1.max(problem.fixed) + PATIENCE
}

/// The place that is worth its lights: the first that reaches the error asked for, or the fewest that do as well as
/// any, but none of the fixed and started ones less.
pub fn chosen(problem: &Problem<'_>, path: &[(State, f64)], floor: f64) -> usize {
    let least = path.iter().map(|(_, error)| *error).fold(f64::INFINITY, f64::min);
    let wanted = problem.error.filter(|wanted| least <= *wanted);
    let enough = wanted.unwrap_or((least * (1.0 + WORTH_A_LIGHT)).max(floor));
    let last = path.len() - 1;
    let given = problem.start.len().min(path[last].0.lights());
    path.iter().position(|(state, error)| *error <= enough && state.lights() >= given).unwrap_or(last)
}
