//! The search for the best set of lights, among the many that no small step improves.
//!
//! [`Search::best`] is the whole story. From one light less, and from lights spread evenly, several
//! tries each exchange lights until no exchange pays; the best of them is then tried with one light
//! more, of which it gives up another one, until that does not pay either.

use glam::DVec3;
use rayon::prelude::*;

use super::candidates::Candidates;
use super::moves::{self, Move};
use super::solver::{Problem, State};
use crate::error::Result;
use crate::kernels::sampling;

// The numbers below were chosen on 30 random maps with 1 to 8 lights, with and without an ambient
// term, against the best of 100 random starts that go downhill in the same steps.

/// Relative fall of the cost in one step at which a try has shown what it is worth.
const ROUGH: f64 = 1e-2;
/// Relative fall of the cost in one step at which an answer is final.
pub const FINE: f64 = 1e-9;
/// Relative fall of the cost for which lights are moved.
const WORTHWHILE: f64 = 2e-3;
/// Places where a further light starts, and exchanges that are tried together.
const ADDED: usize = 2;
const EXCHANGED: usize = 8;
/// Moves that are still in the race after a look at their cost.
const RACING: usize = 12;
/// Even starts that race for one try.
const EVEN: usize = 2;
/// Tries from even starts at most, and how many lights they have together at most.
const MOST_TRIES: usize = 12;
const MOST_TRIED_LIGHTS: usize = 96;

/// The search for the best lights for one probe.
#[derive(Debug)]
pub struct Search<'a> {
    problem: Problem<'a>,
    candidates: Candidates,
}

impl<'a> Search<'a> {
    /// Prepares what all numbers of lights have in common.
    pub fn new(problem: Problem<'a>) -> Self {
        Self { problem, candidates: Candidates::new(problem.probe) }
    }

    /// One light more than `last` has, where that helps, without a second look.
    pub fn grown(&self, last: &State) -> Option<State> {
        self.more(last).filter(|grown| grown.cost < last.cost)
    }

    /// `state` with as many as `lights`, as long as more help, at the bottom of its valley.
    pub fn grown_to(&self, mut state: State, lights: usize) -> State {
        while state.lights() < lights {
            let Some(next) = self.grown(&state) else { break };
            state = next;
        }
        state.descend(&self.problem, FINE)
    }

    /// The best lights, one more than `last` has, where that helps.
    pub fn best(&self, last: &State) -> Result<Option<State>> {
        let Some(grown) = self.more(last) else { return Ok(None) };
        let lights = grown.lights();
        let (tries, grown) = rayon::join(|| self.even_tries(lights), || self.exchanged(grown));
        let best = tries?.into_iter().chain([grown]).min_by(by_cost);
        let best = best.map(|best| self.overshot(best).descend(&self.problem, FINE));
        Ok(best.filter(|best| best.cost < last.cost))
    }

    /// Tries that begin with lights spread evenly, each try elsewhere.
    fn even_tries(&self, lights: usize) -> Result<Vec<State>> {
        let Problem { probe, start, held, .. } = self.problem;
        let free = lights - held;
        let points = sampling::halton(tries(free) * EVEN * free, &[2, 3])?;
        let points = sampling::uniform_sphere(points.view())?;
        let points: Vec<DVec3> = points.rows().into_iter().map(|p| DVec3::new(p[0], p[1], p[2])).collect();
        let start = |points: &[DVec3]| State::new(probe, &[&start[..held], points].concat());
        let tries = points.par_chunks(EVEN * free).filter_map(|points| {
            let field = points.chunks(free).map(start).collect();
            Some(self.exchanged(self.race(field, 3)?))
        });
        Ok(tries.collect())
    }

    /// Lights taken out and put elsewhere, while that pays.
    fn exchanged(&self, mut best: State) -> State {
        loop {
            let Problem { probe, held, .. } = self.problem;
            let moves = moves::exchanged(&self.candidates, probe, &best, held, EXCHANGED);
            match self.best_move(&best, &moves) {
                Some(next) if is_better(&next, &best) => best = next,
                _ => return best,
            }
        }
    }

    /// One light more and then one less, while that pays.
    fn overshot(&self, mut best: State) -> State {
        loop {
            let less = self.more(&best).and_then(|more| {
                let moves = moves::reduced(&more, self.problem.held);
                self.best_move(&more, &moves)
            });
            match less {
                Some(next) if is_better(&next, &best) => best = self.exchanged(next),
                _ => return best,
            }
        }
    }

    /// One light more, where it helps most: added, or by splitting one.
    fn more(&self, last: &State) -> Option<State> {
        let mut moves = moves::added(&self.candidates, self.problem.probe, last, ADDED);
        moves.extend(moves::split(last, self.problem.held));
        self.best_move(last, &moves)
    }

    /// Where the best of `moves` leads.
    fn best_move(&self, from: &State, moves: &[Move]) -> Option<State> {
        let mut field: Vec<State> = moves.par_iter().map(|one| one.from(self.problem.probe, from)).collect();
        field.sort_by(by_cost);
        field.truncate(RACING);
        self.race(field, 1)
    }

    /// The best of a `field` that goes downhill side by side: after so many `steps` each, the worse
    /// half is out.
    fn race(&self, mut field: Vec<State>, steps: usize) -> Option<State> {
        let run = |state: State| (0..steps).fold(state, |state, _| state.step(&self.problem, ROUGH));
        while field.len() > 1 {
            field = field.into_par_iter().map(run).collect();
            field.sort_by(by_cost);
            field.truncate(field.len().div_ceil(2));
        }
        Some(field.pop()?.descend(&self.problem, ROUGH).resumed())
    }
}

/// How many even starts so many free lights are worth: two are found by exchanges alone.
fn tries(lights: usize) -> usize {
    if lights < 3 { 0 } else { (4 * ((lights - 1) / 2)).min(MOST_TRIES).min(MOST_TRIED_LIGHTS / lights) }
}

fn is_better(next: &State, best: &State) -> bool {
    next.cost < best.cost * (1.0 - WORTHWHILE)
}

fn by_cost(a: &State, b: &State) -> std::cmp::Ordering {
    a.cost.total_cmp(&b.cost)
}
