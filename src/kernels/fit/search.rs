//! The search for the best set of lights, among the many that no small step improves.
//!
//! Lights are added one at a time where they promise most, in one set or a few side by side (a beam). At the number
//! that is wanted, the sets of the beam and sets spread evenly over the sphere go downhill, these side by side where
//! the objective knows how. Where even sets have lights to spare, the one that is needed least goes, on the way. The
//! best sets exchange lights, one at a time, while that pays; the best of all goes to the bottom of its valley. Over
//! given normals each valley holds many small ones, between kinks: there the search goes on from perturbed lights.

use glam::DVec3;
use rayon::prelude::*;

use super::abreast::{self, IN_A_QUEUE, Rough};
use super::candidates::Candidates;
use super::moves;
use super::multistart;
use super::problem::Problem;
use super::state::{State, StopReason};
use crate::error::Result;

/// Relative fall of the cost in one step at which a start has shown what it is worth.
const ROUGH: f64 = 4e-2;
/// The same for starts side by side, which go in longer strides.
const ROUGH_ABREAST: f64 = 6e-2;
/// The same where exact steps take over from them.
const NEARLY_CLOSE: f64 = 1e-2;
/// Valleys of these that are followed on: with eight starts for 3 lights, the best was once not among the first two.
const VALLEYS: usize = 4;
/// Relative fall of the cost in one step at which an answer is final.
pub const FINE: f64 = 1e-9;
/// Relative fall of the cost for which a light is exchanged. Starts that differ by less end in the same place.
const WORTH_AN_EXCHANGE: f64 = 2e-3;
/// Relative fall of the cost for which lights are perturbed once more.
const WORTH_A_ROUND: f64 = 1e-6;
/// Places from which lights are perturbed.
const PERTURBED_ON: usize = 6;
/// An exchange that is not near the best after rough steps, by this factor of its cost, is given up.
const NEAR: f64 = 1.2;

/// How many ways are tried side by side.
#[derive(Clone, Copy, Debug)]
struct Breadth {
    /// Sets of lights that grow side by side, places where a light is added to each, and how many of the sets
    /// with one light more go downhill.
    beam: usize,
    added: usize,
    descended: usize,
    /// Even starts for that many lights, and lights that each has to spare at first.
    starts: fn(usize) -> (usize, usize),
    /// Of how many starts one goes on after rough steps where they do not go side by side, and how many places exchange
    /// lights.
    one_in: usize,
    promising: usize,
    /// Exchanges that are tried together, and how much more than the cost of a place they may promise: the other lights
    /// follow.
    exchanged: usize,
    promised: f64,
    /// Relative fall of the cost in one step at which starts are compared for good.
    close: f64,
    /// Share of the least cost above which a place that has settled is given up.
    settled: f64,
    /// Whether the best gets one more light before another goes. With harmonics that lowered the error of 2 of 120 fits,
    /// by .5 and 4 %, for less than a hundredth of the time; without, of none of 420.
    replaces: bool,
}

impl Breadth {
    /// Where a candidate's promise is nearly its cost.
    ///
    /// Of starts for 8 lights, .49 reach the best valley where two lights are to spare, and .35 where none are; 12 starts
    /// all miss it in 5 % of cases in place of 12 % (64 starts for each of 200 blends of two real maps). Starts for few
    /// lights that have some to spare are too much alike: of 5 lights, 8 of them missed it in 2 %, and 8 others never.
    /// Exchanges from three places in place of six end higher in 1 of 3216 searches; where other valleys pay, as under two
    /// softboxes, the search of 8 lights takes .79 of the time.
    const USUAL: Self = Self {
        beam: 1,
        added: 1,
        descended: 1,
        starts: |lights| {
            if lights < 7 { (4 * lights, 0) } else { ((2 * lights).next_multiple_of(IN_A_QUEUE), 2) }
        },
        one_in: 2,
        promising: 3,
        exchanged: 2,
        promised: 1.2,
        close: 3e-3,
        settled: 1e-3,
        replaces: false,
    };
    /// Over a floor starts do not go side by side, and lights to spare would cost more than they bring.
    const FLOOR: Self = Self { starts: |lights| (3 * lights, 0), promising: 6, ..Self::USUAL };
    /// With harmonics that may not turn negative, a promise says little, and there are more valleys: of 114 fits of real
    /// and generated maps, the best came from the first place in 92, from the seventeenth at the latest.
    const HARMONICS: Self = Self {
        beam: 12,
        added: 6,
        descended: 24,
        starts: |lights| (12 * lights, 0),
        one_in: 1,
        promising: 20,
        exchanged: 8,
        promised: 1.2,
        close: 1e-3,
        settled: 1e-3,
        replaces: true,
    };
    /// Over given normals each valley holds many small ones, and what is lowest shows late.
    const KINKS: Self = Self {
        beam: 4,
        added: 4,
        descended: 12,
        starts: |lights| (8 * lights, 1),
        one_in: 2,
        promising: 16,
        exchanged: 8,
        promised: 1.0,
        close: 3e-3,
        settled: 1e-2,
        replaces: false,
    };
    /// Even starts at most, and lights of all of them together: more lights take longer each.
    const MOST_STARTS: usize = 96;
    const MOST_STARTED: usize = 768;

    fn of(problem: &Problem<'_>) -> Self {
        match problem.objective.given().free() {
            0 if problem.objective.has_kinks() => Self::KINKS,
            0 if problem.objective.given().has_floor => Self::FLOOR,
            0 => Self::USUAL,
            _ => Self::HARMONICS,
        }
    }
}

/// The search for the best lights of one problem.
#[derive(Debug)]
pub struct Search<'a> {
    pub problem: &'a Problem<'a>,
    candidates: Candidates<'a>,
    breadth: Breadth,
}

impl<'a> Search<'a> {
    /// For any number of lights.
    pub fn new(problem: &'a Problem<'a>) -> Self {
        let (candidates, breadth) = (Candidates::new(problem.objective), Breadth::of(problem));
        Self { problem, candidates, breadth }
    }

    /// The best sets with one light more than those of `beam`, best first; none where no light helps.
    pub fn grown(&self, beam: &[State]) -> Vec<State> {
        let Breadth { beam: width, added, descended, .. } = self.breadth;
        let added = |state: &State| {
            let moves = moves::added(&self.candidates, state, added);
            moves.iter().map(|one| one.from(self.problem.objective, state)).collect::<Vec<State>>()
        };
        let grown = best_of(beam.par_iter().flat_map_iter(added).collect(), descended);
        let mut grown: Vec<State> = grown.into_par_iter().map(|state| self.descended(state, ROUGH)).collect();
        let noise = self.problem.objective.noise() * self.problem.objective.given().energy;
        grown.retain(|state| state.cost < beam[0].cost - noise);
        best_of(grown, width)
    }

    /// The best lights, from the `beam` of as many.
    pub fn best(&self, beam: Vec<State>) -> Result<Option<State>> {
        let Some(lights) = beam.first().map(State::lights) else { return Ok(None) };
        let mut starts = self.even(lights)?;
        starts.extend(self.likely(lights).into_iter().chain(beam));
        let close = starts.into_par_iter().map(|state| self.descended(state, self.breadth.close)).collect();
        let settled = distinct(close, |state: &State| state.cost, self.breadth.promising)
            .into_par_iter()
            .map(|state| self.settled(state));
        let settled = best_of(settled.collect(), self.breadth.promising);
        let least = settled.first().map_or(0.0, |best| best.cost);
        // At the bottom of their valleys the best may change places.
        let near = settled.into_iter().filter(|state| state.cost <= least * (1.0 + self.breadth.settled));
        let near: Vec<State> = near.chain(self.paper_start(lights)?).collect();
        let finest = near.into_par_iter().map(|state| state.descend(self.problem, FINE));
        let best = best_of(finest.collect(), PERTURBED_ON).into_iter().map(|state| self.perturbed_on(state));
        let best = best_of(best.collect::<Result<Vec<State>>>()?, 1).pop();
        Ok(best.map(|best| if self.breadth.replaces { self.replaced(best) } else { best }))
    }

    /// Lights where they are likeliest, if there are as many such places.
    fn likely(&self, lights: usize) -> Option<State> {
        let Problem { objective, start, fixed, .. } = *self.problem;
        let likely = objective.likely().get(..lights - fixed)?;
        Some(State::new(objective, &[&start[..fixed], likely].concat()))
    }

    /// Even lights as they are (Madsen et al. 2003, section 3.2), where a valley may be too small for others to meet.
    fn paper_start(&self, lights: usize) -> Result<Option<State>> {
        let Problem { objective, start, fixed, .. } = *self.problem;
        let even = multistart::even(1, lights - fixed)?.pop().filter(|_| objective.has_kinks());
        Ok(even.map(|even| State::new(objective, &[&start[..fixed], even.as_slice()].concat())))
    }

    /// Where the best of even starts lead to.
    fn even(&self, lights: usize) -> Result<Vec<State>> {
        let starts = self.even_starts(lights)?;
        if let Some(ends) = self.rough_abreast(&starts, lights) {
            return Ok(self.nearly_close(ends));
        }
        let rough = starts.par_iter().map(|start| self.rough(start, lights)).collect();
        Ok(best_of(rough, starts.len().div_ceil(self.breadth.one_in)))
    }

    /// Lights spread evenly, beside those that are fixed.
    fn even_starts(&self, lights: usize) -> Result<Vec<Vec<DVec3>>> {
        let Problem { objective, start, fixed, .. } = *self.problem;
        let most = Breadth::MOST_STARTS.min(Breadth::MOST_STARTED / lights.max(1)).max(1);
        let (count, spare) = (self.breadth.starts)(lights);
        let with_fixed = |even: Vec<DVec3>| {
            let placed = even.into_iter().map(|l| objective.placed(l));
            start[..fixed].iter().copied().chain(placed).collect()
        };
        let even = multistart::even(count.clamp(1, most), lights - fixed + spare)?;
        Ok(even.into_iter().map(with_fixed).collect())
    }

    /// Where a start leads to, roughly, without the lights that it has to spare.
    fn rough(&self, start: &[DVec3], lights: usize) -> State {
        let mut state = self.descended(State::new(self.problem.objective, start), ROUGH);
        while state.lights() > lights {
            state = self.descended(self.without_one(&state), ROUGH);
        }
        state
    }

    /// Where starts lead to, roughly and side by side, without the lights that they have to spare.
    fn rough_abreast(&self, starts: &[Vec<DVec3>], lights: usize) -> Option<Vec<Rough>> {
        let mut ends = abreast::descents(self.problem, starts, ROUGH_ABREAST)?;
        for _ in lights..starts.first().map_or(lights, Vec::len) {
            let fewer: Vec<Vec<DVec3>> = ends.into_par_iter().map(|end| self.without_weakest(end)).collect();
            ends = abreast::descents(self.problem, &fewer, ROUGH_ABREAST)?;
        }
        Some(ends)
    }

    /// The directions of an end without the light that it needs least.
    fn without_weakest(&self, end: Rough) -> Vec<DVec3> {
        let Problem { objective, fixed, .. } = *self.problem;
        let mut directions = end.directions;
        directions.remove(moves::weakest(objective.given(), end.gram, &end.x, fixed));
        directions
    }

    /// On from the `ends` of rough descents side by side, and the best of where that leads to.
    fn nearly_close(&self, ends: Vec<Rough>) -> Vec<State> {
        let starts: Vec<Vec<DVec3>> = ends.into_iter().map(|end| end.directions).collect();
        let ends = abreast::descents(self.problem, &starts, NEARLY_CLOSE).unwrap_or_default();
        let best = distinct(ends, |end| end.cost, VALLEYS);
        best.iter().map(|end| end.state(self.problem.objective)).collect()
    }

    /// With one more light where most is missing, and then without the one that is missed least, while that pays.
    fn replaced(&self, mut best: State) -> State {
        while best.stop != Some(StopReason::Exact) {
            let Some(more) = self.grown(std::slice::from_ref(&best)).into_iter().next() else { break };
            let fewer = self.without_one(&more);
            if fewer.cost > NEAR * best.cost {
                break;
            }
            let next = self.descended(fewer, self.breadth.close);
            if !is_lower(&next, &best, WORTH_AN_EXCHANGE) {
                break;
            }
            best = self.settled(next).descend(self.problem, FINE);
        }
        best
    }

    /// Without the light that is needed least.
    fn without_one(&self, state: &State) -> State {
        let without = |gone: usize| {
            let kept: Vec<usize> = (0..state.lights()).filter(|&light| light != gone).collect();
            state.exchanged(self.problem.objective, &kept, &[])
        };
        let reduced = (self.problem.fixed..state.lights()).map(without).collect();
        best_of(reduced, 1).pop().unwrap_or_else(|| state.clone())
    }

    /// With lights taken out and put elsewhere while that pays.
    fn settled(&self, mut best: State) -> State {
        let Problem { objective, fixed, .. } = *self.problem;
        loop {
            let Breadth { exchanged, promised, .. } = self.breadth;
            let moves = moves::exchanged(&self.candidates, &best, fixed, promised, exchanged);
            let rough = moves.par_iter().map(|one| self.descended(one.from(objective, &best), ROUGH));
            let near = rough.filter(|state| state.cost < NEAR * best.cost);
            let exchanged = near.map(|state| self.descended(state, self.breadth.close)).collect();
            match best_of(exchanged, 1).pop() {
                Some(next) if is_lower(&next, &best, WORTH_AN_EXCHANGE) => best = next,
                _ => return best,
            }
        }
    }

    /// Downhill, and ready to go on.
    fn descended(&self, state: State, tolerance: f64) -> State {
        state.descend(self.problem, tolerance).resumed()
    }

    /// All lights turned a little and downhill again, while that pays: where the cost has kinks.
    fn perturbed_on(&self, mut best: State) -> Result<State> {
        for round in 0.. {
            if !self.problem.objective.has_kinks() || best.stop == Some(StopReason::Exact) {
                break;
            }
            match self.perturbed_once(&best, round)? {
                Some(next) if is_lower(&next, &best, WORTH_A_ROUND) => best = next,
                _ => break,
            }
        }
        Ok(best)
    }

    /// The lowest place that a perturbation of all lights leads to.
    fn perturbed_once(&self, best: &State, round: usize) -> Result<Option<State>> {
        /// Perturbations that are tried together at least, and how many lights they turn together at least.
        const PERTURBED: usize = 24;
        const PERTURBED_LIGHTS: usize = 64;
        let Problem { objective, fixed, .. } = *self.problem;
        let count = PERTURBED.max(PERTURBED_LIGHTS / (best.lights() - fixed).max(1));
        let starts = multistart::perturbed(best, fixed, count, round)?;
        let settled = starts
            .into_par_iter()
            .map(|directions| self.descended(best.turned_to(objective, directions), self.breadth.close));
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

/// The `count` best of some places that are not the same, best first.
fn distinct<A>(mut places: Vec<A>, cost: impl Fn(&A) -> f64, count: usize) -> Vec<A> {
    places.sort_by_key(|place| rounded(cost(place)));
    places.dedup_by(|next, last| cost(last) >= cost(next) * (1.0 - WORTH_AN_EXCHANGE));
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
    rounded(state.cost)
}

fn rounded(cost: f64) -> u64 {
    const SPARE_DIGITS: u32 = f64::MANTISSA_DIGITS - f32::MANTISSA_DIGITS;
    // The bits of numbers that are not negative are in the order of the numbers.
    cost.max(0.0).to_bits() >> SPARE_DIGITS
}
