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


use glam::DVec3;
use nalgebra::{DMatrix, DVector};

use super::ambient::Ambient;
use super::nnls::Support;
use super::objective::Derivatives;
use super::problem::Problem;
use super::state::State;

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
        let given = problem.objective.given();
        let derivatives = state.moments.derivatives(given, problem.fixed);
        let size = derivatives.gram.nrows();
        let residual = &derivatives.rhs - &derivatives.model * &state.x;
        let bend = is_exact.then(|| bend(problem, state, &derivatives)).flatten();
        let (mut gradient, mut shares) = (DVector::zeros(size), DMatrix::zeros(size / 2, size / 2));
        let mut insides = DMatrix::zeros(size, state.supports.iter().map(|support| support.columns.len()).sum());
        let (first, mut filled) = (given.ambient.coefficients() + problem.fixed, 0);
        for (channel, (support, dark)) in state.supports.iter().zip(&state.dark).enumerate() {
            let copies = given.copies(channel);
            let of = state.irradiance().column(channel).rows_range(problem.fixed..).into_owned();
            // Slope: the radiance of each light times what its derivatives have in common with the residual.
            (0..size).for_each(|i| gradient[i] -= copies * of[i / 2] * residual[(i, channel)]);
            shares.ger(copies, &of, &of, 1.0);
            // What the radiances follow when a light turns.
            let mut products = derivatives.model.clone();
            for mut column in products.column_iter_mut() {
                column.iter_mut().enumerate().for_each(|(i, product)| *product *= of[i / 2]);
            }
            if bend.is_some() {
                (0..size).for_each(|i| products[(i, first + i / 2)] -= residual[(i, channel)]);
            }
            let inside = inside(products, support, dark) * copies.sqrt();
            insides.columns_mut(filled, inside.ncols()).copy_from(&inside);
            filled += inside.ncols();
        }
        let mut hessian = DMatrix::from_fn(size, size, |i, k| shares[(i / 2, k / 2)] * derivatives.gram[(i, k)]);
        hessian.gemm(-1.0, &insides, &insides.transpose(), 1.0);
        let scale = hessian.diagonal().map(|value| value.max(0.0));
        if let Some(bend) = bend {
            hessian += bend;
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
        damped.cholesky().map(|factor| factor.solve(&-gradient))
    }
}

/// The part of the derivatives inside the span of the columns in use, in coordinates of an orthonormal basis.
///
/// With the factor L of the used columns' Gram matrix these are `T L^-T`. Where the ambient term is held at zero
/// for the normals `dark`, with rows C, the used columns may not follow along `U = C L^-T`.
fn inside(products: DMatrix<f64>, support: &Support, dark: &[DVec3]) -> DMatrix<f64> {
    let all = support.columns.len() == products.ncols();
    let inside = support.orthonormal(if all { products } else { products.select_columns(&support.columns) });
    if dark.is_empty() {
        return inside;
    }
    let rows: Vec<[f64; 9]> = dark.iter().map(|&n| Ambient::Sh2.irradiance(n)).collect();
    let at = |i: usize, j: usize| *rows[i].get(support.columns[j]).unwrap_or(&0.0);
    let held = DMatrix::from_fn(dark.len(), support.columns.len(), at);
    let basis = support.orthonormal(held).transpose().col_piv_qr().q();
    let back = &inside * &basis;
    inside - back * basis.transpose()
}

/// `-sum_c x_ic <d^2 a_ik, r_c>`: a block for each light. None where there are no second derivatives.
///
/// Of `-r_c = sum of all columns - E_c`, light by light: the second derivative by its own direction.
fn bend(problem: &Problem<'_>, state: &State, derivatives: &Derivatives) -> Option<DMatrix<f64>> {
    let given = problem.objective.given();
    let (ambient, lights) = (given.ambient.coefficients(), state.lights());
    let mut out = DMatrix::zeros(derivatives.gram.nrows(), derivatives.gram.nrows());
    for (i, frame) in derivatives.frames.iter().enumerate() {
        let own = |channel: usize| given.copies(channel) * state.x[(ambient + problem.fixed + i, channel)];
        let product = |row: usize| (0..state.x.ncols()).map(|c| own(c) * state.x[(row, c)]).sum::<f64>();
        let others: Vec<(f64, DVec3)> =
            (0..lights).map(|k| (product(ambient + k), state.moments.directions[k])).collect();
        let sides = (0..ambient).map(product).chain((0..state.x.ncols()).map(|c| -own(c)));
        let l = state.moments.directions[problem.fixed + i];
        let second = problem.objective.second_derivative(l, &others, &sides.collect::<Vec<f64>>())?;
        for (a, s) in frame.iter().enumerate() {
            for (b, t) in frame.iter().enumerate() {
                out[(2 * i + a, 2 * i + b)] = s.dot(second * *t);
            }
        }
    }
    Some(out)
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::kernels::fit::{Objective, Sphere};
    use crate::kernels::image;
    use crate::kernels::sphere::{Registration, exponential_map};
    use ndarray::Array3;

    fn sphere(ambient: Ambient) -> Sphere {
        let map = Array3::from_shape_fn((32, 64, 3), |(y, x, c)| {
            let hot = if (y, x % 20) == (9 + x / 8, 7 + c) { 400.0 } else { 0.0 };
            (1.0 + (0.2 * x as f64).sin() + hot) as f32
        });
        let working = image::reduce(map.view(), Registration::CellCentred, 256, 3e-3).unwrap();
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
            let problem =
                Problem { objective: &sphere, start: &start, fixed: 1, lights: 3, error: None, max_steps: 10 };
            let state = State::new(&sphere, &start);
            let model = Quadratic::around(&problem, &state, true);
            let frames = state.moments.derivatives(sphere.given(), 1).frames;
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
                assert!((slope - wanted).abs() < 1e-5 * sphere.given().energy, "{ambient:?}: {slope} {wanted}");
                let bend = (cost(STEP) - 2.0 * cost(0.0) + cost(-STEP)) / (STEP * STEP);
                let wanted = 2.0 * way.dot(&(&model.hessian * &way));
                // The residual of the first kind is what second derivatives are about: most of the bend.
                assert!((bend - wanted).abs() < 1e-5 * sphere.given().energy, "{ambient:?}: {bend} {wanted}");
            }
        }
    }
}
