//! Moves from one set of lights to another that a small step would never find.

use glam::DVec3;
use nalgebra::DMatrix;

use super::candidates::{Candidates, Promise};
use super::nnls::Support;
use super::objective::{Given, Objective};
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
    pub fn from(&self, objective: &dyn Objective, state: &State) -> State {
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

/// The light, not of the first `fixed`, without which the cost grows least where no radiance turns negative: by
/// `sum_c x_jc^2 / R_jj`, R the inverse of the Gram matrix of the columns that a channel uses (`candidates.rs`).
pub fn weakest(given: &Given, mut gram: DMatrix<f64>, x: &DMatrix<f64>, fixed: usize) -> usize {
    /// Share that keeps columns apart which depend on each other, as those of lights in one place: none is needed.
    const APART: f64 = 1e-9;
    (0..gram.nrows()).for_each(|i| gram[(i, i)] *= 1.0 + APART);
    let first = given.ambient.coefficients() + fixed;
    let mut needs = vec![0.0; x.nrows()];
    for (channel, x) in x.column_iter().enumerate() {
        let used = (0..x.len()).filter(|&column| x[column] > 0.0).collect();
        let Some(support) = Support::new(&gram, used) else { continue };
        for (place, &column) in support.columns.iter().enumerate() {
            let mut inverse = vec![0.0; support.columns.len()];
            inverse[place] = 1.0;
            support.factors.solve(&mut inverse);
            needs[column] += given.copies(channel) * x[column].powi(2) / inverse[place];
        }
    }
    let weakest = (first..x.nrows()).min_by(|&a, &b| needs[a].total_cmp(&needs[b]));
    weakest.map_or(fixed, |row| row - given.ambient.coefficients())
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

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::kernels::fit::{Ambient, Sphere};
    use crate::kernels::image;
    use crate::kernels::sphere::Registration;
    use ndarray::Array3;

    #[test]
    fn the_weakest_light_is_the_one_without_which_the_refitted_cost_is_lowest() {
        let map = Array3::from_shape_fn((32, 64, 3), |(y, x, c)| {
            let hot = if (y, x % 13) == (9 + x / 8, 7 + c) { 40.0 } else { 0.0 };
            (2.5 + (0.2 * x as f64).sin() + (0.3 * y as f64).cos() + hot) as f32
        });
        let working = image::reduce(map.view(), Registration::CellCentred, 256, 3e-3, false).unwrap();
        let mut compared = 0;
        for (seed, ambient) in (0..40).flat_map(|seed| [(seed, Ambient::None), (seed, Ambient::Constant)]) {
            let sphere = Sphere::new(&working, ambient, false);
            let direction = |i: usize| {
                let [x, y, z] = [1.3, 2.1, 3.7].map(|turn| (turn * (5 * seed + i + 1) as f64).sin());
                DVec3::new(x, y, z).normalize()
            };
            let state = State::new(&sphere, &[0, 1, 2, 3, 4].map(direction));
            let without = |gone: usize| {
                let kept: Vec<usize> = (0..5).filter(|&light| light != gone).collect();
                state.exchanged(&sphere, &kept, &[])
            };
            let best = (1..5).min_by(|&a, &b| without(a).cost.total_cmp(&without(b).cost)).unwrap();
            if state.x.min() > 0.0 && (1..5).all(|gone| without(gone).x.min() > 0.0) {
                assert_eq!(weakest(sphere.given(), state.moments.gram.clone(), &state.x, 1), best);
                compared += 1;
            }
        }
        assert!(compared >= 10, "{compared}");
    }

    #[test]
    fn of_two_lights_in_one_place_one_is_weakest() {
        let mut given = Given::nothing(Ambient::None, false);
        (given.channels, given.like) = (vec![0], [Some(0); 3]);
        // Two alike, of which each has half of the radiance; the others are far from them, and dim.
        let gram = DMatrix::from_row_slice(
            4,
            4,
            &[2.0, 0.1, 0.1, 0.1, 0.1, 2.0, 0.1, 2.0, 0.1, 0.1, 2.0, 0.1, 0.1, 2.0, 0.1, 2.0],
        );
        let x = DMatrix::from_column_slice(4, 1, &[0.3, 5.0, 0.2, 5.0]);
        assert!([1, 3].contains(&weakest(&given, gram, &x, 0)));
    }
}
