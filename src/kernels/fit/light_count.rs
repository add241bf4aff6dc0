//! How many lights: more and more, until they are as many as allowed, good enough, or help no more.

use super::problem::Problem;
use super::search::{FINE, Search};
use super::state::{State, StopReason};
use crate::error::Result;

/// Share of the error that one light more must take away to be worth it.
const WORTH_A_LIGHT: f64 = 1e-3;

/// The errors that are good enough, if any were asked for.
#[derive(Clone, Copy, Debug)]
pub struct Goal {
    pub error: Option<f64>,
    pub shadow_error: Option<f64>,
}

/// The best place found with one number of lights, and its errors.
#[derive(Clone, Debug)]
pub struct Tried {
    pub state: State,
    pub error: f64,
    pub shadow_error: f64,
}

impl Goal {
    /// Whether there is any.
    fn is_some(&self) -> bool {
        self.error.is_some() || self.shadow_error.is_some()
    }

    /// Whether all that was asked for is reached.
    fn is_reached(&self, tried: &Tried) -> bool {
        self.is_some()
            && self.error.is_none_or(|wanted| tried.error <= wanted)
            && self.shadow_error.is_none_or(|wanted| tried.shadow_error <= wanted)
    }

    /// The error by which numbers of lights are compared.
    fn compared(&self, tried: &Tried) -> f64 {
        if self.shadow_error.is_some() { tried.shadow_error } else { tried.error }
    }
}

/// The best place found with each number of lights, judged by `judge`.
///
/// Below the error `floor`, what is left is the error of the rendering, and no light is added.
pub fn path(
    problem: &Problem<'_>,
    goal: &Goal,
    judge: &dyn Fn(&State) -> Tried,
    floor: f64,
) -> Result<Vec<Tried>> {
    let search = Search::new(problem);
    let mut beam = vec![started(problem, 0)];
    let mut path = vec![judge(&beam[0])];
    while beam[0].lights() < problem.lights && !is_enough(problem, goal, &path, floor) {
        let next = next(&search, goal, &beam)?;
        let Some(best) = next.first() else { break };
        path.push(judge(best));
        beam = next;
    }
    // The last number deserves a search of its own, unless it had one.
    let has_search = !goal.is_some() && problem.start.len() == problem.fixed;
    if has_search
        && beam[0].lights() > problem.fixed
        && let Some(best) = search.best(beam)?
    {
        path.pop();
        path.push(judge(&best));
    }
    Ok(path)
}

/// The sets with more lights than those of `beam`, best first; none where no light helps.
fn next(search: &Search<'_>, goal: &Goal, beam: &[State]) -> Result<Vec<State>> {
    let problem = search.problem;
    let count = beam[0].lights();
    if count < problem.start.len() {
        let next = if goal.is_some() { problem.fixed.max(count + 1) } else { problem.start.len() };
        return Ok(vec![refilled(search, started(problem, next.min(problem.lights)))]);
    }
    let mut grown = search.grown(beam);
    if problem.start.len() > problem.fixed {
        // Lights that were given a start stay near it.
        grown.truncate(1);
        return Ok(grown.into_iter().map(|state| state.descend(problem, FINE)).collect());
    }
    if goal.is_some()
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
fn is_enough(problem: &Problem<'_>, goal: &Goal, path: &[Tried], floor: f64) -> bool {
    /// Lights that may fail to lower the error before no more are tried.
    const PATIENCE: usize = 3;
    let Some(last) = path.last() else { return false };
    let lights = last.state.lights();
    if lights < problem.fixed {
        return false;
    }
    let mut best = (f64::INFINITY, 0);
    for tried in path.iter().filter(|tried| tried.state.lights() >= problem.fixed) {
        if goal.compared(tried) < best.0 * (1.0 - WORTH_A_LIGHT) {
            best = (goal.compared(tried), tried.state.lights());
        }
    }
    last.state.stop == Some(StopReason::Exact)
        || last.error <= floor
        || goal.is_reached(last)
        || lights >= best.1.max(problem.fixed) + PATIENCE
}

/// The place that is worth its lights: the first that reaches what was asked for, or the fewest that do as well as
/// any, but none of the fixed and started ones less.
pub fn chosen(problem: &Problem<'_>, goal: &Goal, path: &[Tried], floor: f64) -> usize {
    let least = path.iter().map(|tried| goal.compared(tried)).fold(f64::INFINITY, f64::min);
    let enough = (least * (1.0 + WORTH_A_LIGHT)).max(floor);
    let is_reached = path.iter().any(|tried| goal.is_reached(tried));
    let is_enough =
        |tried: &Tried| if is_reached { goal.is_reached(tried) } else { goal.compared(tried) <= enough };
    let last = path.len() - 1;
    let given = problem.start.len().min(path[last].state.lights());
    path.iter().position(|tried| is_enough(tried) && tried.state.lights() >= given).unwrap_or(last)
}
