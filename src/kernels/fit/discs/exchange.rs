//! Escape from a local minimum beside harmonics: add the disc that lowers the cost most, then remove the one that lowers
//! it least.
//!
//! A descent moves lights, but takes none from a broad disc that two of them share to a lamp that has none. Beside harmonics
//! the error of a sized fit with 4 lights is up to 1.5 times as large without this, on real maps.

use super::disc_cost::Shadows;
use super::forward_selection::CandidateDiscs;
use crate::kernels::fit::damped_newton::Descent;
use crate::kernels::fit::objective::Objective;
use crate::kernels::fit::settings::DISCS;
use crate::kernels::fit::state::State;

/// A lower state than `best`, if an exchange of one light leads to one.
pub fn exchange(shadows: &Shadows<'_>, descent: &Descent<'_>, best: State) -> State {
    if best.lights() <= descent.fixed {
        return best;
    }
    let Some(more) = CandidateDiscs::new(shadows).added_to(&best) else { return best };
    let more = descent.run(more, DISCS.rough);
    let without = |light: usize| {
        let kept: Vec<usize> = (0..more.lights()).filter(|&other| other != light).collect();
        State::at(shadows, shadows.subset(&more.moments, &kept), more.steps, &[])
    };
    let fewer = (descent.fixed..more.lights()).map(without).min_by(|a, b| a.cost.total_cmp(&b.cost));
    let Some(next) = fewer.map(|state| descent.run(state, DISCS.fine)) else { return best };
    if next.cost < best.cost { next } else { best }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernels::fit::comparison::Comparison;
    use crate::kernels::fit::variable_projection::tests::{target, world};
    use crate::kernels::fit::{Ambient, Sphere};
    use crate::kernels::sphere::direction;

    /// The cost by the flux of a new disc is a parabola in each channel: three values give its depth.
    #[test]
    fn a_disc_lowers_the_cost_to_the_minimum_of_a_parabola() {
        let map = world(1.0);
        for (ambient, has_floor) in
            [(Ambient::Constant, false), (Ambient::Constant, true), (Ambient::Sh2, false)]
        {
            let sphere = Sphere::new(&map, ambient, has_floor);
            let target = target(&map, Comparison::Mixed, ambient, has_floor);
            let shadows = Shadows::new(&target, sphere.reference());
            let disc = |theta, phi, radius| shadows.disc(direction(theta, phi), radius);
            let state = shadows.state(vec![disc(1.2, 4.0, 0.3)]);
            let candidates = [disc(0.5, 2.2, 0.2), disc(0.8, 1.8, 0.4), disc(1.3, 5.0, 0.2)];
            let decreases = shadows.decreases(&candidates, &shadows.with_map(&candidates), &state);
            assert!(decreases.iter().any(|decrease| *decrease > 0.0));
            for (candidate, decrease) in candidates.iter().zip(decreases) {
                let moments = shadows.state(vec![state.moments.discs[0], *candidate]).moments;
                let of_channel = |c: usize| {
                    let cost = |flux: f64| {
                        let x = state.x.column(c).push(flux);
                        (&moments.gram * &x).dot(&x) - 2.0 * moments.rhs.column(c).dot(&x)
                    };
                    let [here, one, two] = [0.0, 1.0, 2.0].map(cost);
                    let (second, slope) = (two - 2.0 * one + here, 2.0 * one - 0.5 * two - 1.5 * here);
                    shadows.reference().copies(c) * slope.min(0.0).powi(2) / (2.0 * second)
                };
                let expected: f64 = (0..state.x.ncols()).map(of_channel).sum();
                assert!((decrease - expected).abs() < 1e-6 * state.cost, "{decrease} {expected}");
            }
        }
    }
}
