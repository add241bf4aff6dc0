//! Forward selection of discs: one at a time where it lowers the cost most, with a descent of all after each.
//!
//! Its first discs do not depend on the number of lights, so that one more light lowers its cost. Without it, one light
//! more raised the error with shadows of 14 % of the fits to five real maps with up to 16 lights, by up to 45 %; with it,
//! of 5 %, by up to 11 %.

use glam::DVec3;

use super::disc_cost::Shadows;
use crate::kernels::expansion::DiscSum;
use crate::kernels::fit::damped_newton::Descent;
use crate::kernels::fit::light_disc::Disc;
use crate::kernels::fit::settings::DISCS;
use crate::kernels::fit::state::State;
use crate::kernels::sampling::even_sphere;
use crate::kernels::sphere::to_vectors;

/// A minimum with `count` discs, if each lowers the cost: `fixed` directions first, then one disc at a time.
pub fn forward_selection(
    shadows: &Shadows<'_>,
    descent: &Descent<'_>,
    fixed: &[DVec3],
    count: usize,
) -> Option<State> {
    let discs = fixed.iter().map(|&direction| shadows.disc(direction, DISCS.new)).collect();
    let candidates = CandidateDiscs::new(shadows);
    let mut state = descent.run(shadows.state(discs), DISCS.rough);
    while state.lights() < count {
        let larger = descent.run(candidates.added_to(&state)?, DISCS.rough);
        if larger.cost >= state.cost {
            return None;
        }
        state = State { steps: state.steps + larger.steps, ..larger };
    }
    Some(descent.run(state.resume(), DISCS.fine))
}

/// Discs in a few directions that may be added to a state, with their products with the map.
#[derive(Debug)]
pub struct CandidateDiscs<'a> {
    shadows: &'a Shadows<'a>,
    discs: Vec<Disc>,
    products: Vec<DiscSum>,
}

impl<'a> CandidateDiscs<'a> {
    /// Discs spread evenly over the sphere.
    pub fn new(shadows: &'a Shadows<'a>) -> Self {
        let directions = to_vectors(even_sphere(DISCS.directions).view()).into_iter();
        let discs: Vec<Disc> = directions.map(|direction| shadows.disc(direction, DISCS.new)).collect();
        let products = shadows.with_map(&discs);
        Self { shadows, discs, products }
    }

    /// The `state` with the disc that lowers the cost most.
    pub fn added_to(&self, state: &State) -> Option<State> {
        let decreases = self.shadows.decreases(&self.discs, &self.products, state);
        let best = self.discs.iter().zip(decreases).max_by(|(_, a), (_, b)| a.total_cmp(b));
        best.map(|(&best, _)| self.shadows.state(state.moments.discs.iter().copied().chain([best]).collect()))
    }
}
