//! The cost around a state, to second order in the tangent coordinates `t` of its lights.
//!
//! With the best radiances `x` for every t (variable projection: Golub and Pereyra 1973), the columns `A_c` that
//! channel c uses, their Gram matrix `G_c`, the derivatives `da_i` of the columns of the lights and the residual
//! `r_c`, half the gradient and half the second derivative are
//!
//! ```text
//!   g_i  = -sum_c x_ic <da_i, r_c>
//!   H_ik = sum_c [ x_ic x_kc <da_i, da_k> - T_c G_c^-1 T_c^T - x_ic <d^2 a_ik, r_c> ]
//!   T_c  = X_c <da, A_c> - Lambda_c S                     Lambda_ic = <da_i, r_c>
//! ```
//!
//! where `x_ic` is the radiance of the light of the coordinate i, S picks its column, and `d^2 a_ik` is 0 for
//! coordinates of two lights. Without Lambda and the last term this is the step of Gauss and Newton in Kaufman's
//! form (1975), which needs no second derivatives, and is never bent downwards.

use glam::DMat3;
use nalgebra::{DMatrix, DVector};
use pulp::Arch;

use super::curvature::Sums;
use super::dense::Factors;
use super::problem::Problem;
use super::state::State;
use crate::kernels::sphere::tangents;

/// `cost + 2 gradient.t + t^T hessian t`.
#[derive(Clone, Debug)]
pub struct Quadratic {
    pub hessian: DMatrix<f64>,
    gradient: DVector<f64>,
    /// Diagonal of Gauss and Newton's hessian, which is not negative: the scale of each coordinate.
    scale: DVector<f64>,
}

/// Where a light stands on the horizon of a normal: `n.l = 0`, to first order `across.t = ahead` for its
/// two coordinates from `first` on.
#[derive(Clone, Copy, Debug)]
pub struct Kink {
    pub first: usize,
    pub across: [f64; 2],
    pub ahead: f64,
}

impl Quadratic {
    /// For the lights that may move; with second derivatives where it `is_exact` and the objective has them.
    pub fn around(problem: &Problem<'_>, state: &State, is_exact: bool) -> Self {
        let second = if is_exact { second_derivatives(problem, state) } else { None };
        let sums =
            Sums { objective: problem.objective, state, fixed: problem.fixed, is_exact: second.is_some() };
        let (mut hessian, gradient, scale) = Arch::new().dispatch(sums);
        for (i, second) in second.into_iter().flatten().enumerate() {
            let frame = tangents(state.moments.directions[problem.fixed + i]);
            for (a, b) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
                hessian[(2 * i + a, 2 * i + b)] += frame[a].dot(second * frame[b]);
            }
        }
        Self { hessian, gradient, scale }
    }

    /// What the cost falls by with `step`.
    pub fn fall(&self, step: &DVector<f64>) -> f64 {
        -(2.0 * self.gradient.dot(step) + step.dot(&(&self.hessian * step)))
    }

    /// `(H + damping scale) step = -gradient` (Levenberg 1944, Marquardt 1963), onto the `kinks`: on
    /// either side of them stands a wall, `wall (across.step - ahead)^2`. None where that leads uphill.
    pub fn step(&self, damping: f64, kinks: &[Kink]) -> Option<DVector<f64>> {
        const STEEP: f64 = 1e8;
        let highest = self.scale.max();
        if highest <= 0.0 {
            return None;
        }
        let (mut damped, mut gradient) = (self.hessian.clone(), self.gradient.clone());
        for i in 0..gradient.len() {
            // A light that no channel uses has no slope and no curvature: it stays where it is.
            damped[(i, i)] += damping * self.scale[i] + 1e-14 * highest;
        }
        for &Kink { first, across, ahead } in kinks {
            let across = DVector::from_column_slice(&across);
            let mut own = damped.view_mut((first, first), (2, 2));
            own.ger(STEEP * highest, &across, &across, 1.0);
            gradient.rows_mut(first, 2).axpy(-STEEP * highest * ahead, &across, 1.0);
        }
        gradient.neg_mut();
        Factors::new(damped)?.solve(gradient.as_mut_slice());
        Some(gradient)
    }
}

/// `-sum_c x_ic <d^2 a_ik, r_c>` by the direction of each light that may move. None where there are no second
/// derivatives.
///
/// Of `-r_c = sum of all columns - E_c`, light by light: the second derivative by its own direction.
fn second_derivatives(problem: &Problem<'_>, state: &State) -> Option<Vec<DMat3>> {
    let given = problem.objective.given();
    let (ambient, lights, channels) = (given.ambient.coefficients(), state.lights(), state.x.ncols());
    let (mut sides, mut weights) = (Vec::with_capacity(given.sides()), Vec::with_capacity(lights));
    let second_derivative = |light: usize| {
        let own = |channel: usize| given.copies(channel) * state.x[(ambient + light, channel)];
        let product = |row: usize| (0..channels).map(|c| own(c) * state.x[(row, c)]).sum::<f64>();
        sides.clear();
        sides.extend((0..ambient).map(product).chain((0..channels).map(|c| -own(c))));
        weights.clear();
        weights.extend((0..lights).map(|k| product(ambient + k)));
        let directions = &state.moments.directions;
        problem.objective.second_derivative(directions[light], directions, &weights, &sides)
    };
    (problem.fixed..lights).map(second_derivative).collect()
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::kernels::fit::{Ambient, Objective, Sphere};
    use crate::kernels::image;
    use crate::kernels::sphere::{Registration, exponential_map};
    use glam::DVec3;
    use ndarray::Array3;

    fn sphere(ambient: Ambient) -> Sphere {
        let map = Array3::from_shape_fn((32, 64, 3), |(y, x, c)| {
            let hot = if (y, x % 20) == (9 + x / 8, 7 + c) { 400.0 } else { 0.0 };
            (1.0 + (0.2 * x as f64).sin() + hot) as f32
        });
        let working = image::reduce(map.view(), Registration::CellCentred, 256, 3e-3, false).unwrap();
        Sphere::new(&working, ambient, false)
    }

    /// Along random ways through the directions of all lights, one of which stays: the radiances are refitted at
    /// every place.
    #[test]
    fn gradient_and_hessian_are_the_slopes_of_the_reduced_cost() {
        const STEP: f64 = 2e-4;
        for ambient in [Ambient::None, Ambient::Constant, Ambient::Sh2] {
            let sphere = sphere(ambient);
            let lights = [DVec3::new(0.2, 0.9, 0.1), DVec3::new(-1.0, 0.3, 0.2), DVec3::new(0.5, -0.2, 1.0)];
            let start = lights.map(DVec3::normalize);
            let problem = Problem {
                objective: &sphere,
                start: &start,
                fixed: 1,
                lights: 3,
                error: None,
                max_steps: 10,
            };
            let state = State::new(&sphere, &start);
            let model = Quadratic::around(&problem, &state, true);
            let frames = sphere.derivatives(&state.moments, 1).frames;
            for seed in 0..8 {
                let way = DVector::from_fn(4, |i, _| (1.0 + 3.7 * (seed * 4 + i) as f64).sin());
                let cost = |step: f64| {
                    let turn = |i: usize| {
                        let [s, t] = frames[i - 1];
                        exponential_map(start[i], (s * way[2 * i - 2] + t * way[2 * i - 1]) * step)
                    };
                    State::new(&sphere, &[start[0], turn(1), turn(2)]).cost
                };
                let slope = (cost(STEP) - cost(-STEP)) / (2.0 * STEP);
                let wanted = 2.0 * model.gradient.dot(&way);
                assert!(
                    (slope - wanted).abs() < 1e-5 * sphere.given().energy,
                    "{ambient:?}: {slope} {wanted}"
                );
                let bend = (cost(STEP) - 2.0 * cost(0.0) + cost(-STEP)) / (STEP * STEP);
                let wanted = 2.0 * way.dot(&(&model.hessian * &way));
                // The residual of the first kind is what second derivatives are about: most of the bend.
                assert!((bend - wanted).abs() < 1e-5 * sphere.given().energy, "{ambient:?}: {bend} {wanted}");
            }
        }
    }
}
