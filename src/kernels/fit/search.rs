//! The search for the best set of lights, among the many that no small step improves.
//!
//! Lights are added one at a time where they promise most, in a few sets side by side (a beam). At the number
//! that is wanted, the sets of the beam and sets spread evenly over the sphere go downhill; the best of them
//! exchange lights, one at a time, while that pays; the best of all goes to the bottom of its valley. Over given
//! normals each valley holds many small ones, between kinks: there the search goes on from perturbed lights.

use glam::DVec3;
use rayon::prelude::*;

use super::candidates::Candidates;
use super::moves::{self, Move};
use super::multistart;
use super::problem::Problem;
use super::state::State;
use super::StopReason;
use crate::error::Result;

/// Relative fall of the cost in one step at which a start has shown what it is worth.
const ROUGH: f64 = 3e-2;
/// The same where starts are compared for good.
const CLOSE: f64 = 1e-3;
/// Relative fall of the cost in one step at which an answer is final.
pub const FINE: f64 = 1e-9;
/// Relative fall of the cost for which a light is exchanged.
const WORTH_AN_EXCHANGE: f64 = 2e-3;
/// Relative fall of the cost for which lights are perturbed once more.
const WORTH_A_ROUND: f64 = 1e-6;
/// Sets of lights that grow side by side.
const BEAM: usize = 4;
/// Places where a light is added to each, and exchanges that are tried together.
const ADDED: usize = 2;
const EXCHANGED: usize = 2;
/// Even starts, and how many of them go on.
const STARTS: usize = 8;
const PROMISING: usize = 4;

fn var(name: &str, default: usize) -> usize { std::env::var(name).map_or(default, |v| v.parse().unwrap()) }
fn fvar(name: &str, default: f64) -> f64 { std::env::var(name).map_or(default, |v| v.parse().unwrap()) }

/// The search for the best lights of one problem.
#[derive(Debug)]
pub struct Search<'a> {
    pub problem: &'a Problem<'a>,
    candidates: Candidates<'a>,
}

impl<'a> Search<'a> {
    /// For any number of lights.
    pub fn new(problem: &'a Problem<'a>) -> Self {
        Self { problem, candidates: Candidates::new(problem.objective) }
    }

    /// The best sets with one light more than those of `beam`, best first; none where no light helps.
    pub fn grown(&self, beam: &[State]) -> Vec<State> {
        let added = |(set, state): (usize, &State)| {
            let moves = moves::added(&self.candidates, state, var("ADDED", ADDED));
            moves.into_iter().map(move |one| (set, one)).collect::<Vec<(usize, Move)>>()
        };
        let mut moves: Vec<(usize, Move)> = beam.iter().enumerate().flat_map(added).collect();
        moves.sort_by(|a, b| a.1.promise.total_cmp(&b.1.promise));
        let grown = moves.par_iter().map(|(set, one)| one.from(self.problem.objective, &beam[*set]));
        let grown = best_of(grown.collect(), var("HALVED", BEAM));
        let grown = grown.into_par_iter().map(|state| state.descend(self.problem, fvar("ROUGH", ROUGH)).resumed());
        let mut grown: Vec<State> = grown.collect();
        grown.retain(|state| state.cost < beam[0].cost);
        best_of(grown, var("BEAM", BEAM))
    }

    /// The best lights, from the `beam` of as many.
    pub fn best(&self, beam: Vec<State>) -> Result<Option<State>> {
        let Some(lights) = beam.first().map(State::lights) else { return Ok(None) };
        let mut starts = best_of(self.even(lights)?, var("GOING", 12));
        starts.extend(beam);
        let close = starts.into_par_iter().map(|state| state.descend(self.problem, fvar("CLOSE", CLOSE)).resumed());
        let distinct = distinct(close.collect(), fvar("APART", 3e-3), var("PROMISING", PROMISING));
        let settled = distinct.into_par_iter().map(|state| self.settled(state)).collect::<Vec<State>>();
        let best = best_of(settled, 1).pop().map(|best| best.resumed().descend(self.problem, FINE));
        best.map(|best| self.from_perturbed(best)).transpose()
    }

    /// Where even starts lead to, roughly.
    fn even(&self, lights: usize) -> Result<Vec<State>> {
        let Problem { objective, start, fixed, .. } = *self.problem;
        let starts = multistart::even(var("STARTS", STARTS), lights - fixed)?;
        let descend = |start_of: &Vec<DVec3>| {
            let directions = [&start[..fixed], start_of].concat();
            let directions = directions.into_iter().map(|l| objective.nearest_allowed(l)).collect::<Vec<_>>();
            State::new(objective, &directions).descend(self.problem, fvar("ROUGH", ROUGH)).resumed()
        };
        Ok(starts.par_iter().map(descend).collect())
    }

    /// Downhill, with lights taken out and put elsewhere while that pays.
    fn settled(&self, state: State) -> State {
        let mut best = state;
        loop {
            let moves = moves::exchanged(&self.candidates, &best, self.problem.fixed, var("EXCHANGED", EXCHANGED));
            let rough = moves.iter().map(|one| {
                one.from(self.problem.objective, &best).descend(self.problem, fvar("ROUGH", ROUGH)).resumed()
            });
            let near = rough.filter(|state| state.cost < best.cost * fvar("NEAR", 1.3));
            let exchanged = near.map(|state| state.descend(self.problem, fvar("CLOSE", CLOSE)).resumed());
            match best_of(exchanged.collect(), 1).pop() {
                Some(next) if is_lower(&next, &best, fvar("WORTH_AN_EXCHANGE", WORTH_AN_EXCHANGE)) => best = next,
                _ => return best,
            }
        }
    }

    /// All lights turned a little and downhill again, while that pays: where the cost has kinks.
    fn from_perturbed(&self, mut best: State) -> Result<State> {
        for round in 0.. {
            if !self.problem.objective.has_kinks() || best.stop == Some(StopReason::Exact) {
                break;
            }
            match self.perturbed(&best, round)? {
                Some(next) if is_lower(&next, &best, WORTH_A_ROUND) => best = next,
                _ => break,
            }
        }
        Ok(best)
    }

    /// The lowest place that a perturbation of all lights leads to.
    fn perturbed(&self, best: &State, round: usize) -> Result<Option<State>> {
        /// Perturbations that are tried together at least, and how many lights they turn together at least.
        const PERTURBED: usize = 16;
        const PERTURBED_LIGHTS: usize = 64;
        let Problem { objective, fixed, .. } = *self.problem;
        let count = PERTURBED.max(PERTURBED_LIGHTS / (best.lights() - fixed).max(1));
        let starts = multistart::perturbed(best, fixed, count, round)?;
        let settled = starts
            .into_par_iter()
            .map(|directions| best.turned_to(objective, directions).descend(self.problem, fvar("CLOSE", CLOSE)).resumed());
        let lowest = best_of(settled.collect(), 1).pop();
        Ok(lowest.map(|lowest| lowest.descend(self.problem, FINE)))
    }
}

/// The `count` best of some places, best first, each of another cost.
fn best_of(mut places: Vec<State>, count: usize) -> Vec<State> {
    places.sort_by_key(rounded_cost);
    places.dedup_by_key(|state| rounded_cost(state));
    places.truncate(count);
    places
}

fn distinct(mut places: Vec<State>, apart: f64, count: usize) -> Vec<State> {
    places.sort_by_key(rounded_cost);
    places.dedup_by(|next, last| next.cost <= last.cost * (1.0 + apart));
    places.truncate(count);
    places
}

/// Whether the cost of `next` is lower by more than the share `worth`.
fn is_lower(next: &State, best: &State, worth: f64) -> bool {
    next.cost < best.cost * (1.0 - worth)
}

/// The cost with the digits of single precision, at any scale: costs that differ by rounding alone, as those of
/// mirror images do, are equal and keep their order.
fn rounded_cost(state: &State) -> u64 {
    const SPARE_DIGITS: u32 = f64::MANTISSA_DIGITS - f32::MANTISSA_DIGITS;
    // The bits of numbers that are not negative are in the order of the numbers.
    state.cost.max(0.0).to_bits() >> SPARE_DIGITS
}
