//! From no light to more and more, until they are as many as allowed, good enough, or help no more.

use std::sync::atomic::{AtomicBool, Ordering};

use super::probe::Probe;
use super::search::{FINE, Search};
use super::solver::{Problem, State};
use super::{Goal, Request, StopReason};
use crate::error::Result;

/// The places that the search stops at, with more and more lights.
pub fn states(probe: &Probe, request: &Request<'_>) -> Result<Vec<State>> {
    /// More lights keep all threads busy by themselves, and even one try of them would take longer than the
    /// way to where they may turn out not to be needed.
    const FEW: usize = 8;
    let &Request { start, held, lights, max_steps, goal } = request;
    let is_over = AtomicBool::new(false);
    let search = Search::new(Problem { probe, start, held, max_steps, is_over: &is_over });
    let way = Way { request, search: &search };
    if goal.error.is_some() || start.len() > held || lights == held || lights > FEW {
        return Ok(way.to(lights)?.0);
    }
    // Only the last number of lights gets a second look, and that need not wait for the numbers before.
    let first = || {
        let (states, leads_on) = way.to(lights - 1)?;
        let last = states.last().filter(|_| leads_on);
        let grown = last.and_then(|last| search.exchanged_one_more(last));
        is_over.store(!leads_on, Ordering::Relaxed);
        Ok((states, leads_on, grown))
    };
    let (first, tries) = rayon::join(first, || search.tries(lights));
    let (mut states, leads_on, grown) = first?;
    if let Some(last) = states.last().filter(|_| leads_on) {
        states.extend(search.lowest(last, grown, tries?)?);
    }
    Ok(states)
}

/// From no light to more and more.
struct Way<'a> {
    request: &'a Request<'a>,
    search: &'a Search<'a>,
}

impl Way<'_> {
    /// The places up to so many lights, and whether the way leads on.
    fn to(&self, lights: usize) -> Result<(Vec<State>, bool)> {
        let Problem { probe, held, .. } = self.search.problem;
        let mut states = vec![self.started(0)];
        let mut progress = Progress::new(self.request.goal, held);
        while let Some(last) = states.last() {
            if progress.is_enough(probe, last) {
                return Ok((states, false));
            }
            if last.lights() >= lights {
                break;
            }
            let next = self.after(last)?.filter(|next| next.lights() > last.lights());
            let Some(next) = next else { return Ok((states, false)) };
            states.push(next);
        }
        Ok((states, true))
    }

    /// The next place with more lights than `last`, where these help.
    fn after(&self, last: &State) -> Result<Option<State>> {
        let &Request { start, held, lights, goal, .. } = self.request;
        if last.lights() < start.len() {
            let count = if goal.error.is_some() { held.max(last.lights() + 1) } else { start.len() };
            let next = self.started(count.min(lights));
            let lit = next.without_black(&self.search.problem);
            return Ok(Some(
                lit.map_or_else(|| next.clone(), |lit| self.search.grown_to(lit, next.lights())),
            ));
        }
        let is_last = goal.error.is_some() || last.lights() + 1 == lights;
        // Lights that were given a start stay near it.
        match (is_last, start.len() > held) {
            (true, false) => self.search.best(last),
            (true, true) => {
                let grown = self.search.grown(last);
                Ok(grown.map(|grown| grown.descend(&self.search.problem, FINE)))
            }
            (false, _) => Ok(self.search.grown(last)),
        }
    }

    /// The best lights near the first `count` starts.
    fn started(&self, count: usize) -> State {
        let problem = Problem { held: self.request.held.min(count), ..self.search.problem };
        State::new(problem.probe, &problem.start[..count]).descend(&problem, FINE)
    }
}

/// Whether more lights are worth a try.
struct Progress<'a> {
    goal: &'a Goal,
    held: usize,
    /// Least error so far, and the lights that reached it.
    best: (f64, usize),
}

impl<'a> Progress<'a> {
    fn new(goal: &'a Goal, held: usize) -> Self {
        Self { goal, held, best: (f64::INFINITY, 0) }
    }

    /// Nothing is left to explain, the error asked for is reached, or several more lights in a row have
    /// not lowered the error: what they explain is the pattern of the normals.
    fn is_enough(&mut self, probe: &Probe, last: &State) -> bool {
        /// Lights that may fail to lower the error before no more are tried.
        const PATIENCE: usize = 3;
        /// Share of the error that counts as lower.
        const LOWER: f64 = 1e-3;
        if last.lights() < self.held {
            return false;
        }
        let error = self.goal.judge.error(&last.rig(probe));
        if error < self.best.0 * (1.0 - LOWER) {
            self.best = (error, last.lights());
        }
        last.stop == Some(StopReason::Exact)
            || self.goal.error.is_some_and(|wanted| error <= wanted)
            || last.lights() >= self.best.1.max(self.held) + PATIENCE
    }
}
