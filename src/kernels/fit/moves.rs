//! Changes of one light that no small step leads to.

use glam::DVec3;

use super::candidates::{Candidates, Prediction};
use super::objective::PointObjective;
use super::settings::SEARCH;
use super::state::State;

/// A light to remove, if any, and one to add.
#[derive(Clone, Copy, Debug)]
pub struct Move {
    /// Predicted cost.
    pub predicted: f64,
    pub gone: Option<usize>,
    pub new: DVec3,
}

impl Move {
    /// The state after the move.
    pub fn from(&self, objective: &dyn PointObjective, state: &State) -> State {
        let kept: Vec<usize> = (0..state.lights()).filter(|light| Some(*light) != self.gone).collect();
        state.exchange(objective, &kept, &[self.new])
    }
}

/// One more light in the `count` best directions.
pub fn additions(candidates: &Candidates<'_>, state: &State, count: usize) -> Vec<Move> {
    let Some(beside) = candidates.beside(state) else { return Vec::new() };
    let predictions = apart(beside.additions(), count);
    predictions.into_iter().map(|(predicted, new)| Move { predicted, gone: None, new }).collect()
}

/// The `count` best exchanges of one light after the first `fixed`.
///
/// Their predicted cost is at most `most_predicted` times that of `state`. Forward selection keeps the light that lowers
/// the cost most alone; beside its neighbours, another set is often better.
pub fn exchanges(
    candidates: &Candidates<'_>,
    state: &State,
    fixed: usize,
    most_predicted: f64,
    count: usize,
) -> Vec<Move> {
    let Some(beside) = candidates.beside(state) else { return Vec::new() };
    let mut moves: Vec<Move> = Vec::new();
    for light in fixed..state.lights() {
        let mut predictions = beside.relocations(light, most_predicted * state.cost);
        predictions.retain(|(_, direction)| direction.dot(state.moments.directions[light]) < SEARCH.back);
        let predictions = apart(predictions, SEARCH.directions_of_light).into_iter();
        moves.extend(predictions.map(|(predicted, new)| Move { predicted, gone: Some(light), new }));
    }
    moves.sort_by(|a, b| a.predicted.total_cmp(&b.predicted));
    moves.truncate(count);
    moves
}

/// The best `count` predictions whose directions are apart.
fn apart(mut predictions: Vec<Prediction>, count: usize) -> Vec<Prediction> {
    let mut chosen: Vec<Prediction> = Vec::new();
    while chosen.len() < count
        && let Some(&best) = predictions.iter().min_by(|a, b| a.0.total_cmp(&b.0))
    {
        chosen.push(best);
        predictions.retain(|next| next.1.dot(best.1) < SEARCH.apart);
    }
    chosen
}
