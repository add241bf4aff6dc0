//! The search for the best set of lights, among the many that no small step improves.
//!
//! [`Search::best`] is the whole story. From one light less, and from many sets of lights spread evenly,
//! tries go downhill; the most promising exchange lights until no exchange pays; the lights of the best
//! are then nudged to the lowest of the small valleys around them.

use std::ops::RangeInclusive;
use std::sync::OnceLock;

use glam::DVec3;
use rayon::prelude::*;

use super::candidates::Candidates;
use super::moves::{self, Move};
use super::solver::{Problem, State};
use super::{StopReason, spread};
use crate::error::Result;

// The numbers below were chosen with 1 to 8 lights, with and without an ambient term, on 64 random maps
// and on those that `benchmarks/fit_search.py` judges by, as they are and turned, against the best of
// 200 random starts that go downhill in the same steps. On 32 random maps that chose nothing, 95 % end
// within 1.01 of the error of those.

/// Relative fall of the cost in one step at which a try has shown what it is worth.
const ROUGH: f64 = 1e-2;
/// The same of a nudge: the small valleys differ by little.
const CLOSE: f64 = 1e-3;
/// Relative fall of the cost in one step at which an answer is final.
pub const FINE: f64 = 1e-9;
/// Relative fall of the cost for which lights are exchanged, and nudged once more.
const WORTH_AN_EXCHANGE: f64 = 2e-3;
const WORTH_A_NUDGE: f64 = 1e-6;
/// Places where a further light starts, and exchanges that are tried together.
const ADDED: usize = 2;
const EXCHANGED: usize = 8;
/// Moves that are still in the race after a look at their cost, and those among them that take a light
/// from a try: most tries are given up a little later.
const RACING: usize = 12;
const RACING_WITH_ONE_LESS: usize = 4;
/// Lights that a try from an even start has to spare, but for the first.
const SPARE: usize = 1;
/// Tries from even starts for each light, how many in all, and how many lights they have together at most.
const TRIES_FOR_EACH: usize = 4;
const TRIES: RangeInclusive<usize> = 12..=24;
const MOST_TRIED_LIGHTS: usize = 288;
/// Of so many tries, one is worth that its lights are exchanged.
const FOR_EACH_PROMISING: usize = 4;
/// Nudges that are tried together at least, and how many lights they turn together at least.
const NUDGES: usize = 16;
const NUDGED_LIGHTS: usize = 64;

/// The search for the best lights for one probe.
#[derive(Debug)]
pub struct Search<'a> {
    pub problem: Problem<'a>,
    /// Made only when a light has no start.
    candidates: OnceLock<Candidates>,
}

impl<'a> Search<'a> {
    /// For any number of lights.
    pub fn new(problem: Problem<'a>) -> Self {
        Self { problem, candidates: OnceLock::new() }
    }

    fn candidates(&self) -> &Candidates {
        self.candidates.get_or_init(|| Candidates::new(self.problem.probe))
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
        let (grown, tries) = rayon::join(|| self.exchanged_one_more(last), || self.tries(last.lights() + 1));
        self.lowest(last, grown, tries?)
    }

    /// One light more than `last` has, and lights exchanged while that pays.
    pub fn exchanged_one_more(&self, last: &State) -> Option<State> {
        self.more(last).map(|grown| self.exchanged(grown))
    }

    /// Where even starts of so many lights lead to, unless the search is over before.
    pub fn tries(&self, lights: usize) -> Result<Vec<State>> {
        let free = lights - self.problem.held;
        let starts = spread::starts(tries(free), free, SPARE)?;
        let tried = starts.par_iter().filter_map(|start| self.tried(start, lights)).collect();
        Ok(promising(tried).into_par_iter().map(|state| self.exchanged(state)).collect())
    }

    /// The lowest place around the best of `grown` and `tries`, where it is lower than `last`.
    pub fn lowest(&self, last: &State, grown: Option<State>, tries: Vec<State>) -> Result<Option<State>> {
        let mut field: Vec<State> = tries.into_iter().chain(grown).collect();
        let least = field.iter().map(|state| state.cost).fold(f64::INFINITY, f64::min);
        // At the bottom of their valleys the best may change places.
        field.retain(|state| state.cost <= least * (1.0 + ROUGH));
        let settled = field.into_par_iter().map(|state| state.descend(&self.problem, FINE));
        // Of those in the same place the first, whatever rounding says of the others.
        let lower =
            |best: State, next: State| if is_lower(&next, &best, WORTH_A_NUDGE) { next } else { best };
        let best = settled.collect::<Vec<_>>().into_iter().reduce(lower);
        let best = best.map(|best| self.nudged(best)).transpose()?;
        Ok(best.filter(|best| best.cost < last.cost))
    }

    /// What an even start leads to, without the lights to spare that are needed least.
    fn tried(&self, start: &[DVec3], lights: usize) -> Option<State> {
        let Problem { probe, start: given, held, .. } = self.problem;
        if self.problem.is_over() {
            return None;
        }
        let mut state = State::new(probe, &[&given[..held], start].concat());
        // Without any to spare it must not be left for what only seems lower.
        let still = if state.lights() > lights { ROUGH } else { FINE };
        state = state.descend(&self.problem, still).resumed();
        while state.lights() > lights {
            state = self.best_move(&state, &moves::reduced(&state, held), RACING_WITH_ONE_LESS)?;
        }
        Some(state)
    }

    /// Lights taken out and put elsewhere, while that pays.
    fn exchanged(&self, mut best: State) -> State {
        loop {
            let Problem { probe, held, .. } = self.problem;
            let moves = moves::exchanged(self.candidates(), probe, &best, held, EXCHANGED);
            match self.best_move(&best, &moves, RACING) {
                Some(next) if is_lower(&next, &best, WORTH_AN_EXCHANGE) => best = next,
                _ => return best,
            }
        }
    }

    /// All lights turned a little and downhill again, while that pays.
    fn nudged(&self, mut best: State) -> Result<State> {
        for round in 0.. {
            match self.nudge(&best, round)? {
                Some(next) if is_lower(&next, &best, WORTH_A_NUDGE) => best = next,
                _ => break,
            }
        }
        Ok(best)
    }

    /// The lowest place that a nudge of all lights leads to, unless nothing is left to explain.
    fn nudge(&self, best: &State, round: usize) -> Result<Option<State>> {
        if best.stop == Some(StopReason::Exact) {
            return Ok(None);
        }
        let Problem { probe, held, .. } = self.problem;
        let count = NUDGES.max(NUDGED_LIGHTS / (best.lights() - held).max(1));
        let settled = spread::nudges(best, held, count, round)?
            .into_par_iter()
            .map(|directions| best.turned_to(probe, directions).descend(&self.problem, CLOSE).resumed());
        let lowest = settled.collect::<Vec<_>>().into_iter().min_by(by_cost);
        Ok(lowest.map(|lowest| lowest.descend(&self.problem, FINE)))
    }

    /// One light more, where it helps most: added, or by splitting one.
    fn more(&self, last: &State) -> Option<State> {
        let mut moves = moves::added(self.candidates(), self.problem.probe, last, ADDED);
        moves.extend(moves::split(last, self.problem.held));
        self.best_move(last, &moves, RACING)
    }

    /// Where the best of `moves` leads, after a race of so many.
    fn best_move(&self, from: &State, moves: &[Move], racing: usize) -> Option<State> {
        let mut field: Vec<State> = moves.par_iter().map(|one| one.from(self.problem.probe, from)).collect();
        field.sort_by(by_cost);
        field.truncate(racing);
        self.race(field)
    }

    /// The best of a `field` that goes downhill side by side: after each step the worse half is out.
    fn race(&self, mut field: Vec<State>) -> Option<State> {
        while field.len() > 1 {
            if self.problem.is_over() {
                return None;
            }
            field = field.into_par_iter().map(|state| state.step(&self.problem, ROUGH)).collect();
            field.sort_by(by_cost);
            field.truncate(field.len().div_ceil(2));
        }
        Some(field.pop()?.descend(&self.problem, ROUGH).resumed())
    }
}

/// How many even starts so many free lights are worth.
fn tries(lights: usize) -> usize {
    let (least, most) = TRIES.into_inner();
    (TRIES_FOR_EACH * lights).clamp(least, most).min(MOST_TRIED_LIGHTS / lights).max(1)
}

/// The first of the tries, which is the paper's start, and the lowest of the others.
fn promising(mut tried: Vec<State>) -> Vec<State> {
    let count = tried.len().div_ceil(FOR_EACH_PROMISING);
    if let Some(others) = tried.get_mut(1..) {
        others.sort_by(by_cost);
    }
    tried.truncate(count);
    tried
}

/// Whether the cost of `next` is lower by more than the share `worth`.
fn is_lower(next: &State, best: &State, worth: f64) -> bool {
    next.cost < best.cost * (1.0 - worth)
}

/// With the digits of single precision, at any scale: costs that differ by rounding alone, as those of
/// mirror images do, are equal and keep their order.
fn by_cost(a: &State, b: &State) -> std::cmp::Ordering {
    const SPARE_DIGITS: u32 = f64::MANTISSA_DIGITS - f32::MANTISSA_DIGITS;
    // The bits of numbers that are not negative are in the order of the numbers.
    let rounded = |state: &State| state.cost.to_bits() >> SPARE_DIGITS;
    rounded(a).cmp(&rounded(b))
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::kernels::fit::{Ambient, Probe, Samples};
    use crate::kernels::sampling;
    use std::cmp::Ordering;

    #[test]
    fn places_are_ranked_by_their_cost_but_for_rounding_at_any_scale() {
        let (normals, weights) = sampling::icosphere(20).unwrap();
        let seen = normals.mapv(f64::abs);
        let probe =
            Probe::new(Samples::new(normals.view(), weights.view(), seen.view()).unwrap(), Ambient::None);
        let costing = |cost: f64| {
            let mut state = State::new(&probe, &[DVec3::Y]);
            state.cost = cost;
            state
        };
        for scale in [1.0, 1e-60, 1e60] {
            let [one, same, more] = [1.5, 1.5 * (1.0 + 1e-12), 1.50001].map(|cost| costing(scale * cost));
            assert_eq!(by_cost(&one, &same), Ordering::Equal);
            assert_eq!(by_cost(&one, &more), Ordering::Less);
        }
        assert_eq!(by_cost(&costing(0.0), &costing(1e-60)), Ordering::Less);
    }
}
