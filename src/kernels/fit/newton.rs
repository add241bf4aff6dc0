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

#![allow(clippy::inline_always, reason = "what is not inlined is compiled for the oldest of processors")]

use std::borrow::Cow;
use std::sync::Arc;

use glam::{DMat3, DVec3};
use nalgebra::{DMatrix, DVector};
use pulp::{Arch, Simd, WithSimd};

use super::ambient::Ambient;
use super::dense::{add, add_products, column_of};
use super::objective::{Derivatives, Given};
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
        let given = problem.objective.given();
        let derivatives = state.moments.derivatives(given, problem.fixed);
        let second = if is_exact { second_derivatives(problem, state) } else { None };
        let size = derivatives.gram.nrows();
        let first = given.ambient.coefficients() + problem.fixed;
        let radiance =
            DMatrix::from_fn(size, state.x.ncols(), |i, channel| state.x[(first + i / 2, channel)]);
        let slope = derivatives.rhs.clone();
        let channels = Channels { derivatives, radiance, slope, first, is_exact: second.is_some() };
        let (hessian, gradient) = (DMatrix::zeros(size, size), DVector::zeros(size));
        let mut out = Self { hessian, scale: gradient.clone(), gradient };
        Arch::new().dispatch(Sum { given, state, channels, out: &mut out });
        out.hessian.fill_upper_triangle_with_lower_triangle();
        for (i, second) in second.into_iter().flatten().enumerate() {
            let frame = tangents(state.moments.directions[problem.fixed + i]);
            for (a, b) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
                out.hessian[(2 * i + a, 2 * i + b)] += frame[a].dot(second * frame[b]);
            }
        }
        out
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

/// What the lights that may move do in each channel.
struct Channels {
    derivatives: Derivatives,
    /// The radiance `x_ic` of the light of each coordinate, and `Lambda_ic`: a column for each channel.
    radiance: DMatrix<f64>,
    slope: DMatrix<f64>,
    /// Column of the first light that may move.
    first: usize,
    is_exact: bool,
}

/// Adds up gradient, hessian and scale, but for the second derivatives of columns; of the hessian the lower triangle.
///
/// With D the products of the derivatives with each other, M with the columns, `K = M G_c^-1` and o(i) the column of the
/// light of i,
///
/// ```text
///   T_c G_c^-1 T_c^T = x_i x_k (K M^T)_ik - x_i Lambda_k K_i,o(k) - Lambda_i x_k K_k,o(i) + Lambda_i Lambda_k G_c^-1_o(i),o(k)
/// ```
///
/// so that channels that use the same columns share all products of matrices.
struct Sum<'a> {
    given: &'a Given,
    state: &'a State,
    channels: Channels,
    out: &'a mut Quadratic,
}

impl WithSimd for Sum<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { given, state, mut channels, out } = self;
        let count = state.x.ncols();
        for channel in 0..count {
            channels.add_gradient(column_of(&state.x, channel), channel, given.copies(channel), out);
        }
        let mut from = 0;
        while from < count {
            let alike = |channel: &usize| *channel == from || state.follow_alike(from, *channel);
            let to = from + (from..count).take_while(alike).count();
            let inverse = held(&state.supports[from].inverse, &state.dark[from]);
            let copies = (from..to).map(|channel| (channel, given.copies(channel)));
            channels.add_hessian(&inverse, copies, out);
            from = to;
        }
    }
}

impl State {
    /// Whether the radiances of two channels follow in the same way when a light turns.
    fn follow_alike(&self, a: usize, b: usize) -> bool {
        Arc::ptr_eq(&self.supports[a], &self.supports[b])
            && self.dark[a].is_empty()
            && self.dark[b].is_empty()
    }
}

impl Channels {
    /// `Lambda = <da, y> - <da, A> x`, and `-x Lambda`.
    #[inline(always)]
    fn add_gradient(&mut self, x: &[f64], channel: usize, copies: f64, out: &mut Quadratic) {
        let mut slope = self.slope.column_mut(channel);
        for (column, &x) in x.iter().enumerate() {
            add(slope.as_mut_slice(), -x, column_of(&self.derivatives.model, column));
        }
        let radiance = column_of(&self.radiance, channel);
        add_products(out.gradient.as_mut_slice(), -copies, radiance, column_of(&self.slope, channel));
    }

    /// Of channels with the same inverse Gram matrix.
    #[inline(always)]
    fn add_hessian(
        &self,
        inverse: &DMatrix<f64>,
        channels: impl Iterator<Item = (usize, f64)> + Clone,
        out: &mut Quadratic,
    ) {
        let Self { derivatives: Derivatives { model, gram, .. }, radiance, slope, first, is_exact } = self;
        let size = gram.nrows();
        let along = product(model, inverse);
        // A column of D - K M^T, of K^T and of G^-1.
        let (mut outside, mut back, mut both) = (vec![0.0; size], vec![0.0; size], vec![0.0; size]);
        for k in 0..size {
            let outside = &mut outside[k..];
            outside.copy_from_slice(&column_of(gram, k)[k..]);
            for column in 0..model.ncols() {
                add(outside, -model[(k, column)], &column_of(&along, column)[k..]);
            }
            let own = first + k / 2;
            if *is_exact {
                for i in k..size {
                    back[i] = along[(k, first + i / 2)];
                    both[i] = inverse[(first + i / 2, own)];
                }
            }
            let hessian = &mut out.hessian.as_mut_slice()[k * size + k..(k + 1) * size];
            for (channel, copies) in channels.clone() {
                let [radiance, slope] = [radiance, slope].map(|of| &column_of(of, channel)[k..]);
                add_products(hessian, copies * radiance[0], radiance, outside);
                out.scale[k] += (copies * radiance[0] * radiance[0] * outside[0]).max(0.0);
                if *is_exact {
                    add_products(hessian, copies * slope[0], radiance, &column_of(&along, own)[k..]);
                    add_products(hessian, copies * radiance[0], slope, &back[k..]);
                    add_products(hessian, -copies * slope[0], slope, &both[k..]);
                }
            }
        }
    }
}

/// `a b`
#[inline(always)]
fn product(a: &DMatrix<f64>, b: &DMatrix<f64>) -> DMatrix<f64> {
    let mut out = DMatrix::zeros(a.nrows(), b.ncols());
    for (k, out) in out.as_mut_slice().chunks_exact_mut(a.nrows().max(1)).enumerate() {
        column_of(b, k).iter().enumerate().for_each(|(i, &factor)| add(out, factor, column_of(a, i)));
    }
    out
}

/// `R = G^-1` where the ambient term, of rows C, is held at zero for the normals `dark`:
/// `R - R C^T (C R C^T)^-1 C R`.
fn held<'a>(inverse: &'a DMatrix<f64>, dark: &[DVec3]) -> Cow<'a, DMatrix<f64>> {
    if dark.is_empty() {
        return Cow::Borrowed(inverse);
    }
    let rows: Vec<[f64; 9]> = dark.iter().map(|&n| Ambient::Sh2.irradiance(n)).collect();
    let rows = DMatrix::from_fn(dark.len(), inverse.nrows(), |i, k| *rows[i].get(k).unwrap_or(&0.0));
    let along = &rows * inverse;
    let mut gram = &along * rows.transpose();
    // Two of the normals may be all but the same.
    (0..gram.nrows()).for_each(|i| gram[(i, i)] *= 1.0 + 1e-12);
    match gram.cholesky() {
        Some(factor) => Cow::Owned(inverse - along.tr_mul(&factor.solve(&along))),
        None => Cow::Borrowed(inverse),
    }
}

/// `-sum_c x_ic <d^2 a_ik, r_c>` by the direction of each light that may move. None where there are no second
/// derivatives.
///
/// Of `-r_c = sum of all columns - E_c`, light by light: the second derivative by its own direction.
fn second_derivatives(problem: &Problem<'_>, state: &State) -> Option<Vec<DMat3>> {
    let given = problem.objective.given();
    let (ambient, lights, channels) = (given.ambient.coefficients(), state.lights(), state.x.ncols());
    let mut sides = Vec::with_capacity(given.sides());
    let second_derivative = |light: usize| {
        let own = |channel: usize| given.copies(channel) * state.x[(ambient + light, channel)];
        let product = |row: usize| (0..channels).map(|c| own(c) * state.x[(row, c)]).sum::<f64>();
        sides.clear();
        sides.extend((0..ambient).map(product).chain((0..channels).map(|c| -own(c))));
        let weights: Vec<f64> = (0..lights).map(|k| product(ambient + k)).collect();
        let directions = &state.moments.directions;
        problem.objective.second_derivative(directions[light], directions, &weights, &sides)
    };
    (problem.fixed..lights).map(second_derivative).collect()
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
