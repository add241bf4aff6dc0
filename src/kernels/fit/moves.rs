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
const NEAR: f64 = 0.5;

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
        State::at(probe, state.moments.with(probe, &kept.collect::<Vec<_>>(), &self.new), state.steps, &[])
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
            // To merge a black light would be to take it out, in another order.
            let are_lit = power(j) > 0.0 && power(k) > 0.0;
            if are_lit && directions[j].dot(directions[k]) > NEAR {
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

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::kernels::fit::{Ambient, Rig, Samples, irradiance};
    use crate::kernels::sampling;

    fn probe_of(directions: &[DVec3]) -> Probe {
        let (normals, weights) = sampling::icosphere(320).unwrap();
        let rig = Rig {
            ambient: vec![DVec3::splat(0.1)],
            directions: directions.to_vec(),
            irradiance: vec![DVec3::ONE; directions.len()],
        };
        let seen = irradiance(&rig, normals.view()).unwrap();
        Probe::new(Samples::new(normals.view(), weights.view(), seen.view()).unwrap(), Ambient::Constant)
    }

    #[test]
    fn a_light_is_added_where_one_is_missing() {
        let probe = probe_of(&[DVec3::Y, DVec3::X]);
        let state = State::new(&probe, &[DVec3::Y]);
        let best = &added(&Candidates::new(&probe), &probe, &state, 2)[0];
        assert!(best.new[0].dot(DVec3::X) > 0.9, "{best:?}");
        assert!(best.from(&probe, &state).cost < state.cost);
    }

    #[test]
    fn the_light_that_is_not_needed_is_the_one_exchanged() {
        let probe = probe_of(&[DVec3::Y, DVec3::X]);
        let state = State::new(&probe, &[DVec3::Y, DVec3::NEG_Z]);
        let candidates = Candidates::new(&probe);
        let best = &exchanged(&candidates, &probe, &state, 0, 1)[0];
        assert_eq!(best.gone, [1]);
        assert!(best.new[0].dot(DVec3::X) > 0.9, "{best:?}");
        // None goes back to where it was.
        let all = exchanged(&candidates, &probe, &state, 0, 100);
        assert!(all.iter().all(|one| one.new[0].dot(state.moments.directions[one.gone[0]]) < BACK));
        assert!(all.len() > 2);
        // A light that is held is not.
        assert!(exchanged(&candidates, &probe, &state, 2, 1).is_empty());
    }

    #[test]
    fn neighbours_are_merged_where_one_light_stood() {
        let probe = probe_of(&[DVec3::Y]);
        let parted = &split(&State::new(&probe, &[DVec3::Y]), 0)[0];
        let state = parted.from(&probe, &State::new(&probe, &[DVec3::Y]));
        let merged = reduced(&state, 0).pop().unwrap();
        assert_eq!(merged.gone, [0, 1]);
        assert!(merged.new[0].dot(DVec3::Y) > 1.0 - 1e-4, "{merged:?}");
    }
}
