//! Moves from one set of lights to another that a small step would never find.

use glam::DVec3;

use super::candidates::{Candidates, Promise};
use super::objective::PointObjective;
use super::state::State;

/// Starts of added lights closer than this (cosine) would end in the same place.
const APART: f64 = 0.8;
/// A light that starts closer than this (cosine) to where it was would go back there.
const BACK: f64 = 0.9;

/// A light that goes, if any, and one that comes.
#[derive(Clone, Copy, Debug)]
pub struct Move {
    /// The cost that is left, at least.
    pub promise: f64,
    pub gone: Option<usize>,
    pub new: DVec3,
}

impl Move {
    /// The state it leads to from `state`.
    pub fn from(&self, objective: &dyn PointObjective, state: &State) -> State {
        let kept: Vec<usize> = (0..state.lights()).filter(|light| Some(*light) != self.gone).collect();
        state.exchanged(objective, &kept, &[self.new])
    }
}

/// One more light where it would explain most, the best `count` places.
pub fn added(candidates: &Candidates<'_>, state: &State, count: usize) -> Vec<Move> {
    let Some(beside) = candidates.beside(state) else { return Vec::new() };
    let places = apart(beside.added(), count);
    places.into_iter().map(|(promise, new)| Move { promise, gone: None, new }).collect()
}

/// One light, not of the first `fixed`, taken out and put where it would explain most: the best `count` of those that
/// promise at most `promised` times the cost of `state`.
///
/// A greedy start keeps the light that explained most *alone*; with its neighbours in place a
/// different set is often better.
pub fn exchanged(
    candidates: &Candidates<'_>,
    state: &State,
    fixed: usize,
    promised: f64,
    count: usize,
) -> Vec<Move> {
    /// Places that are tried for each light.
    const PLACES: usize = 2;
    let Some(beside) = candidates.beside(state) else { return Vec::new() };
    let mut moves: Vec<Move> = Vec::new();
    for light in fixed..state.lights() {
        let mut places = beside.moved(light, promised * state.cost);
        places.retain(|(_, place)| place.dot(state.moments.directions[light]) < BACK);
        let places = apart(places, PLACES).into_iter();
        moves.extend(places.map(|(promise, new)| Move { promise, gone: Some(light), new }));
    }
    moves.sort_by(|a, b| a.promise.total_cmp(&b.promise));
    moves.truncate(count);
    moves
}

/// The first `count` of `places`, best first, that do not crowd each other.
fn apart(mut places: Vec<Promise>, count: usize) -> Vec<Promise> {
    let mut chosen: Vec<Promise> = Vec::new();
    while chosen.len() < count
        && let Some(&best) = places.iter().min_by(|a, b| a.0.total_cmp(&b.0))
    {
        chosen.push(best);
        places.retain(|place| place.1.dot(best.1) < APART);
    }
    chosen
}
