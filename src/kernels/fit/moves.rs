//! Moves from one set of lights to another that a small step would never find.

use glam::DVec3;

use super::candidates::Candidates;
use super::probe::Probe;
use super::solver::State;
use crate::kernels::sphere::{exponential_map, tangents};

/// Starts of added lights closer than this (cosine) would end in the same place.
const APART: f64 = 0.8;
/// A light that starts closer than this (cosine) to where it was would go back there.
const BACK: f64 = 0.9;
/// Half the angle between the parts of a split light, in radians: about that of neighbours among
/// eight even lights.
const ASIDE: f64 = 0.4;
/// Lights farther apart than this (cosine) are not merged.
const NEAR: f64 = 0.3;

/// Lights that go, and lights that come in their place.
#[derive(Clone, Debug)]
pub struct Move {
    /// Which go, in ascending order.
    pub gone: Vec<usize>,
    /// Towards those that come.
    pub new: Vec<DVec3>,
}

impl Move {
    fn new(gone: impl Into<Vec<usize>>, new: impl Into<Vec<DVec3>>) -> Self {
        Self { gone: gone.into(), new: new.into() }
    }

    /// The state it leads to from `state`.
    pub fn from(&self, probe: &Probe, state: &State) -> State {
        let kept = (0..state.moments.directions.len()).filter(|light| !self.gone.contains(light));
        State::at(probe, state.moments.with(probe, &kept.collect::<Vec<_>>(), &self.new), state.steps)
    }
}

/// One more light where it would explain most, the best `count` places.
pub fn added(candidates: &Candidates, probe: &Probe, state: &State, count: usize) -> Vec<Move> {
    let products = candidates.products(probe, state);
    let places = apart(candidates.left(probe, state, &products, None), count);
    places.into_iter().map(|(_, place)| Move::new([], [place])).collect()
}

/// One light, not of the first `held`, taken out and put where it would explain most: the best `count`.
///
/// A greedy start keeps the light that explained most *alone*; with its neighbours in place a
/// different set is often better.
pub fn exchanged(
    candidates: &Candidates,
    probe: &Probe,
    state: &State,
    held: usize,
    count: usize,
) -> Vec<Move> {
    /// Places that are tried for each light.
    const PLACES: usize = 2;
    let products = candidates.products(probe, state);
    let mut ranked: Vec<(f64, Move)> = Vec::new();
    for light in held..state.moments.directions.len() {
        let old = state.moments.directions[light];
        let mut places = candidates.left(probe, state, &products, Some(light));
        places.retain(|(_, place)| place.dot(old) < BACK);
        let places = apart(places, PLACES).into_iter();
        ranked.extend(places.map(|(left, place)| (left, Move::new([light], [place]))));
    }
    ranked.sort_by(|a, b| a.0.total_cmp(&b.0));
    ranked.into_iter().map(|(_, exchange)| exchange).take(count).collect()
}

/// Each light, not of the first `held`, split in two along each of its tangents.
///
/// Two lamps side by side look like one in between to a light that starts alone; it never parts them.
pub fn split(state: &State, held: usize) -> Vec<Move> {
    let parts = |l: DVec3, along: DVec3| [1.0, -1.0].map(|side| exponential_map(l, along * (side * ASIDE)));
    let lights = state.moments.directions.iter().enumerate().skip(held);
    lights.flat_map(|(light, &l)| tangents(l).map(|along| Move::new([light], parts(l, along)))).collect()
}

/// One light less: each, not of the first `held`, taken out, and each two neighbours made one.
pub fn reduced(state: &State, held: usize) -> Vec<Move> {
    let directions = &state.moments.directions;
    let power = |light: usize| state.irradiance().row(light).sum();
    let mut moves: Vec<Move> = (held..directions.len()).map(|light| Move::new([light], [])).collect();
    for j in held..directions.len() {
        for k in held..j {
            let middle = directions[j] * power(j) + directions[k] * power(k);
            if directions[j].dot(directions[k]) > NEAR && middle.length() > 0.0 {
                moves.push(Move::new([k, j], [middle.normalize()]));
            }
        }
    }
    moves
}

/// The first `count` of `places`, best first, that do not crowd each other.
fn apart(mut places: Vec<(f64, DVec3)>, count: usize) -> Vec<(f64, DVec3)> {
    places.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut chosen: Vec<(f64, DVec3)> = Vec::new();
    for place in places {
        if chosen.len() < count && chosen.iter().all(|other| other.1.dot(place.1) < APART) {
            chosen.push(place);
        }
    }
    chosen
}
