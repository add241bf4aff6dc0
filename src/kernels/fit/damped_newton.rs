//! Descent of a set of lights to a local minimum of the cost: damped Newton steps (Levenberg 1944, Marquardt 1963).
//!
//! The tangent plane of a direction has no pole, where the paper's angles theta and phi lose a rank.
//!
//! The cost over known normals has a kink where a light crosses the horizon of one, and a minimum often lies in such a
//! kink: both sides descend to it, and no step across lowers the cost. From there the descent follows the kink.

use nalgebra::{DMatrix, DVector};

use super::objective::{Constraint, Objective};
use super::state::{RESOLUTION, State, StopReason};
use super::variable_projection::{Quadratic, Subspace};

/// Numbers of every descent.
struct DescentSettings {
    /// Damping of the first step, as a fraction of the curvature of each coordinate.
    first_damping: f64,
    /// Least damping: with less, rounding chooses the step along coordinates that the cost hardly depends on.
    least_damping: f64,
    /// Damping at which a step is too short to change anything.
    greatest_damping: f64,
    /// Damping from which a small decrease does not mean that a minimum is near.
    stiff: f64,
    /// Smallest factor of the damping after one step.
    softest: f64,
    /// Longest step, in radians or as the logarithm of a radius: the quadratic is accurate only nearby.
    longest_step: f64,
    /// Longest first step without damping, near the minimum.
    longest_polish: f64,
    /// Relative decrease of the cost in one step below which second derivatives are worth their time.
    exact_below: f64,
}

const SETTINGS: DescentSettings = DescentSettings {
    first_damping: 1e-2,
    least_damping: 1e-6,
    greatest_damping: 1e8,
    stiff: 0.1,
    softest: 0.1,
    longest_step: 0.5,
    longest_polish: 1e-3,
    exact_below: 0.03,
};

/// A descent of the lights of one objective.
#[derive(Clone, Copy, Debug)]
pub struct Descent<'a> {
    pub objective: &'a dyn Objective,
    /// Number of first lights that keep their directions.
    pub fixed: usize,
    /// Greatest number of steps.
    pub max_steps: usize,
}

impl Descent<'_> {
    /// The state after steps that each lower the cost, until one lowers it by less than the fraction `tolerance`.
    ///
    /// Steps of Gauss and Newton come first: they never lead to a saddle. Where they gain little, exact ones finish.
    pub fn run(&self, mut state: State, tolerance: f64) -> State {
        let (mut damping, mut is_exact) = (SETTINGS.first_damping, false);
        for _ in 0..self.max_steps {
            if state.stop.is_some() {
                return state;
            }
            let next = self.step(&state, is_exact, tolerance, &mut damping);
            let gain = next.as_ref().map_or(0.0, |next| 1.0 - next.cost / state.cost);
            let is_last = is_exact || tolerance >= SETTINGS.exact_below;
            is_exact |= gain < SETTINGS.exact_below;
            let has_converged = gain <= tolerance && is_last && (next.is_none() || damping < SETTINGS.stiff);
            state = next.unwrap_or(state);
            if has_converged {
                state.stop = state.stop.or(Some(StopReason::Converged));
            }
        }
        state.stop = state.stop.or(Some(StopReason::OutOfSteps));
        state
    }

    /// One step that lowers the cost, if there is one.
    fn step(&self, state: &State, is_exact: bool, tolerance: f64, damping: &mut f64) -> Option<State> {
        let model = Quadratic::around(self.objective, state, is_exact);
        let held = self.constraints(state, &model);
        let mut own = *damping;
        let next = self.lower(&Local { state, model: &model, held, tolerance }, &[], &mut own)?;
        *damping = own;
        Some(next)
    }

    /// The last digits of a minimum, by undamped steps while each is less than half as long as the one before.
    pub fn polish(&self, mut state: State) -> State {
        let resolution = RESOLUTION * self.objective.reference().energy;
        let mut longest = SETTINGS.longest_polish;
        loop {
            let model = Quadratic::around(self.objective, &state, true);
            let constraints = self.constraints(&state, &model);
            let Some(step) = model.step(&constraints, 0.0) else { break };
            let next = self.after_step(&state, &step);
            // Not a number without a light that may move.
            if !(step.amax() < longest && next.cost <= state.cost + resolution) {
                break;
            }
            longest = 0.5 * step.amax();
            state = State { stop: state.stop, ..next };
        }
        state
    }

    /// Constraints of fixed lights, and of bounds that lights press against.
    pub fn constraints(&self, state: &State, model: &Quadratic) -> Vec<Constraint> {
        let fixed = (0..self.fixed).flat_map(|light| [0, 1].map(|axis| Constraint::hold(light, axis)));
        fixed.chain(self.objective.bounds(&state.moments, model.gradient.as_slice(), self.fixed)).collect()
    }

    /// The first step that lowers the cost, with more and more damping, onto `kinks` if there are any.
    fn lower(&self, local: &Local<'_>, kinks: &[Constraint], damping: &mut f64) -> Option<State> {
        let Local { state, model, held, tolerance } = local;
        let constraints = [held.as_slice(), kinks].concat();
        while *damping < SETTINGS.greatest_damping {
            if let Some(step) = model.step(&constraints, *damping) {
                let step = shorten(step);
                let predicted = model.fall(&step);
                // A smaller fall is not worth the attempt.
                if predicted <= 0.1 * tolerance * state.cost {
                    return None;
                }
                let next = self.after_step(state, &step);
                if next.cost < state.cost {
                    *damping =
                        (*damping * softer((state.cost - next.cost) / predicted)).max(SETTINGS.least_damping);
                    return Some(next);
                }
                if kinks.is_empty()
                    && let Some(next) = self.along_kinks(local, &next, damping)
                {
                    return Some(next);
                }
            }
            *damping *= 10.0;
        }
        None
    }

    /// A lower state on the kinks on the way to `next`.
    fn along_kinks(&self, local: &Local<'_>, next: &State, damping: &mut f64) -> Option<State> {
        let kinks = self.objective.kinks(&local.state.moments, &next.moments);
        if kinks.is_empty() {
            return None;
        }
        let mut own = *damping;
        let next = self.lower(local, &kinks, &mut own)?;
        *damping = own;
        Some(next)
    }

    fn after_step(&self, state: &State, step: &DVector<f64>) -> State {
        let moments = self.objective.after_step(&state.moments, step.as_slice());
        State::at(self.objective, moments, state.steps + 1, &state.supports)
    }
}

/// The cost around a state, and the constraints of a step.
struct Local<'a> {
    state: &'a State,
    model: &'a Quadratic,
    held: Vec<Constraint>,
    /// Relative decrease of the cost that ends the descent.
    tolerance: f64,
}

/// The step, at most as long as the quadratic is accurate.
fn shorten(step: DVector<f64>) -> DVector<f64> {
    let longest = step.amax();
    if longest > SETTINGS.longest_step { step * (SETTINGS.longest_step / longest) } else { step }
}

/// Factor of the damping after a step whose decrease of the cost was this `ratio` of the predicted one (Nielsen 1999).
fn softer(ratio: f64) -> f64 {
    (1.0 - (2.0 * ratio - 1.0).powi(3)).max(SETTINGS.softest)
}

impl Quadratic {
    /// The minimum of the quadratic under `constraints` and with `damping`; none if nothing can move.
    ///
    /// `(H + damping D) step = -gradient`, where D holds the curvature of each coordinate. A negative eigenvalue of H over
    /// D counts with its size (Nocedal and Wright 2006, section 3.4).
    pub fn step(&self, constraints: &[Constraint], damping: f64) -> Option<DVector<f64>> {
        /// Least curvature that damping assumes, over the greatest. Second derivatives may cancel it; without them only
        /// rounding does, and lights 22 stops below others still converge.
        const FLATTEST: f64 = 1e-6;
        const ROUNDING: f64 = 1e-14;
        let constraints = [constraints, &self.idle()].concat();
        let space = Subspace::new(self.gradient.len(), self.each, &constraints);
        let (hessian, gradient) = space.reduce(self);
        let curvature = hessian.diagonal().abs();
        let greatest = curvature.max();
        if gradient.is_empty() || greatest <= 0.0 {
            return None;
        }
        let least = if self.is_exact { FLATTEST } else { ROUNDING } * greatest;
        let scale = curvature.map(|own| own.max(least).sqrt());
        let scaled =
            DMatrix::from_fn(scale.len(), scale.len(), |i, k| hessian[(i, k)] / (scale[i] * scale[k]));
        let step = downhill(scaled, damping, gradient.component_div(&scale));
        Some(space.full(step.component_div(&scale)))
    }

    /// Constraints that hold the coordinates on which the cost does not depend, those of black lights. Without them,
    /// eigenvectors take a tenth of a fit's time, and those of many zeros may be no numbers (nalgebra 0.35).
    fn idle(&self) -> Vec<Constraint> {
        let is_idle = |&i: &usize| self.hessian.column(i).amax() == 0.0;
        let idle = (0..self.gradient.len()).filter(is_idle);
        idle.map(|i| Constraint::hold(i / self.each, i % self.each)).collect()
    }
}

/// The step against a `gradient`. Cholesky and eigenvectors give the same where the Hessian is positive definite.
fn downhill(mut hessian: DMatrix<f64>, damping: f64, gradient: DVector<f64>) -> DVector<f64> {
    /// Damping of coordinates that the cost does not depend on.
    const LEAST: f64 = 1e-14;
    if hessian.clone().cholesky().is_some() {
        (0..gradient.len()).for_each(|i| hessian[(i, i)] += damping);
        if let Some(factor) = hessian.clone().cholesky() {
            return -factor.solve(&gradient);
        }
    }
    let eigen = hessian.symmetric_eigen();
    let along = eigen.eigenvectors.tr_mul(&gradient);
    let sizes = eigen.eigenvalues.map(|value| value.abs() + damping.max(LEAST));
    -(&eigen.eigenvectors * along.component_div(&sizes))
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::super::variable_projection::tests::{target, world};
    use super::*;
    use crate::kernels::fit::comparison::Comparison;
    use crate::kernels::fit::discs::Shadows;
    use crate::kernels::fit::{Ambient, Sphere};
    use crate::kernels::sampling;
    use crate::kernels::sphere::direction;

    /// Rounding must not move a radius from its bound under a map, but not under a brighter one.
    #[test]
    fn a_brighter_map_has_the_same_steps_to_the_bit() {
        let held = [Constraint::hold(1, 2), Constraint::hold(2, 1)];
        let steps = |scale: f32| {
            let map = world(scale);
            let sphere = Sphere::new(&map, Ambient::Constant, false);
            let target = target(&map, Comparison::Mixed, Ambient::Constant, false);
            let shadows = Shadows::new(&target, sphere.reference());
            let of_turned = |turn: i32| {
                let turn = 0.8 * f64::from(turn);
                let discs =
                    [(1.0, 1.8, 0.3), (0.8, 4.4 + turn, 0.1), (1.1, 2.5 + turn, 1.0), (2.0, turn, 0.5)];
                let discs = discs.map(|(theta, phi, radius)| shadows.disc(direction(theta, phi), radius));
                let model = Quadratic::around(&shadows, &shadows.state(discs.to_vec()), true);
                let space = Subspace::new(model.gradient.len(), model.each, &held);
                (model.step(&held, 1e-4).unwrap(), space.reduce(&model).0.symmetric_eigenvalues().min() < 0.0)
            };
            (0..8).map(of_turned).collect::<Vec<_>>()
        };
        let expected = steps(1.0);
        assert!(expected.iter().filter(|(_, is_indefinite)| *is_indefinite).count() > 2);
        assert!(expected.iter().all(|(step, _)| step[5] == 0.0 && step[7] == 0.0));
        assert_eq!(expected, steps(32.0));
    }

    /// Along an eigenvector the step divides by the size of its eigenvalue, whatever its sign.
    #[test]
    fn a_step_goes_down_along_directions_of_negative_curvature() {
        let model = |curvature: [f64; 2]| Quadratic {
            gradient: DVector::from_vec(vec![1.0, 2.0]),
            hessian: DMatrix::from_diagonal(&DVector::from_vec(curvature.to_vec())),
            each: 2,
            is_exact: true,
        };
        for curvature in [[4.0, 8.0], [4.0, -8.0], [-4.0, -8.0]] {
            let step = model(curvature).step(&[], 0.0).unwrap();
            assert!((step[0] + 0.25).abs() < 1e-12 && (step[1] + 0.25).abs() < 1e-12, "{step}");
        }
        assert!(model([0.0, 0.0]).step(&[], 0.0).is_none());
        let damped = model([4.0, 8.0]).step(&[], 1.0).unwrap();
        assert!((damped[0] + 0.125).abs() < 1e-12, "{damped}");
    }

    /// Ten black lights between two others: eigenvectors of 3 % of such matrices are not a number.
    #[test]
    fn black_lights_stay_and_leave_the_step_of_the_others() {
        let place = |i: usize| if i < 2 { i } else { i + 20 };
        for values in sampling::halton(200, &[2, 3, 5, 7, 11, 13, 17, 19, 23, 29]).unwrap().rows() {
            let pair = |i: usize, k: usize| 2.0 * values[i.max(k) * (i.max(k) + 1) / 2 + i.min(k)] - 1.0;
            let others = Quadratic {
                gradient: DVector::from_fn(4, |i, _| values[i]),
                hessian: DMatrix::from_fn(4, 4, pair),
                each: 2,
                is_exact: true,
            };
            let (gradient, hessian) = (DVector::zeros(24), DMatrix::zeros(24, 24));
            let mut all = Quadratic { gradient, hessian, ..others.clone() };
            for i in 0..4 {
                all.gradient[place(i)] = others.gradient[i];
                (0..4).for_each(|k| all.hessian[(place(i), place(k))] = pair(i, k));
            }
            let (step, expected) = (all.step(&[], 0.1).unwrap(), others.step(&[], 0.1).unwrap());
            assert!((step.norm() - expected.norm()).abs() <= 1e-9 * expected.norm(), "{step} {expected}");
            assert!((0..4).all(|i| (step[place(i)] - expected[i]).abs() <= 1e-9 * expected.norm()));
        }
    }

    #[test]
    fn a_descent_ends_where_the_gradient_is_zero_and_the_curvature_is_not_negative() {
        let map = world(1.0);
        let sphere = Sphere::new(&map, Ambient::Constant, false);
        let start = [direction(0.8, 1.0), direction(1.7, 4.0), direction(2.5, 2.0)];
        let descent = Descent { objective: &sphere, fixed: 1, max_steps: 100 };
        let state = descent.run(State::new(&sphere, &start), 1e-9);
        assert_eq!(state.stop, Some(StopReason::Converged));
        assert_eq!(state.moments.directions[0], start[0]);
        let polished = descent.polish(state);
        let model = Quadratic::around(&sphere, &polished, true);
        let space = Subspace::new(6, 2, &descent.constraints(&polished, &model));
        let (hessian, gradient) = space.reduce(&model);
        assert!(gradient.amax() < 1e-10 * hessian.amax(), "{gradient}");
        assert!(hessian.symmetric_eigenvalues().min() > -1e-12 * hessian.amax());
    }

    #[test]
    fn a_descent_without_enough_steps_says_so() {
        let sphere = Sphere::new(&world(1.0), Ambient::Constant, false);
        let descent = Descent { objective: &sphere, fixed: 0, max_steps: 1 };
        let state = descent.run(State::new(&sphere, &[direction(0.8, 1.0), direction(1.7, 4.0)]), 1e-9);
        assert_eq!((state.stop, state.steps), (Some(StopReason::OutOfSteps), 1));
    }
}
