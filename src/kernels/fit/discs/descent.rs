//! Down to the bottom of a valley: damped Newton steps (Levenberg 1944, Marquardt 1963).

use super::newton::Quadratic;
use super::state::{Problem, State};
use crate::kernels::fit::state::StopReason;

/// A light never turns by more than this in one step, in radians, and its radius changes by no more than the
/// exponential of it.
const LONGEST_STEP: f64 = 0.7;
/// Damping of the first step, the least, and the one at which a step no longer moves anything.
const FIRST_DAMPING: f64 = 1e-2;
const LEAST_DAMPING: f64 = 1e-7;
const STIFFEST: f64 = 1e7;

/// Where a descent ended.
#[derive(Clone, Debug)]
pub struct Descended {
    pub state: State,
    pub steps: usize,
    pub stop: StopReason,
}

/// Downhill until a step lowers the cost by less than the share `tolerance` of it.
pub fn descend(problem: &Problem<'_>, mut state: State, tolerance: f64) -> Descended {
    let mut damping = FIRST_DAMPING;
    for steps in 0..problem.max_steps {
        let model = Quadratic::around(problem, &state);
        let Some(next) = lower(problem, &state, &model, tolerance, &mut damping) else {
            return Descended { state, steps, stop: StopReason::Converged };
        };
        let gain = (state.cost - next.cost) / state.cost.max(f64::MIN_POSITIVE);
        state = next;
        if gain <= tolerance && damping < FIRST_DAMPING {
            return Descended { state, steps: steps + 1, stop: StopReason::Converged };
        }
    }
    Descended { state, steps: problem.max_steps, stop: StopReason::OutOfSteps }
}

/// The first step that lowers the cost, with more and more damping.
fn lower(
    problem: &Problem<'_>,
    state: &State,
    model: &Quadratic,
    tolerance: f64,
    damping: &mut f64,
) -> Option<State> {
    while *damping < STIFFEST {
        if let Some(mut step) = model.step(*damping) {
            let longest = step.amax();
            if longest > LONGEST_STEP {
                step *= LONGEST_STEP / longest;
            }
            // Less than that is not worth the try.
            let promised = model.fall(&step);
            if promised <= 0.1 * tolerance * state.cost {
                return None;
            }
            let next = state.moved(problem, step.as_slice());
            if next.cost < state.cost {
                let kept = (state.cost - next.cost) / promised;
                *damping = (*damping * softer(kept)).max(LEAST_DAMPING);
                return Some(next);
            }
        }
        *damping *= 10.0;
    }
    None
}

/// What the damping is multiplied by after a step that lowered the cost by this share of what its model had promised
/// (Nielsen 1999): a step that kept less than half of the promise asks for more damping, not for less.
fn softer(kept: f64) -> f64 {
    const LEAST: f64 = 0.1;
    (1.0 - (2.0 * kept - 1.0).powi(3)).max(LEAST)
}
