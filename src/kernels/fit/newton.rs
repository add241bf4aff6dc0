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

use std::sync::Arc;

use glam::DVec3;
use nalgebra::{DMatrix, DVector};
use pulp::{Arch, Simd, WithSimd};

use super::ambient::Ambient;
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
        let first = given.ambient.coefficients() + problem.fixed;
        let channels = (0..state.x.ncols()).map(|channel| Channel {
            copies: given.copies(channel),
            radiance: (0..size).map(|i| state.x[(first + i / 2, channel)]).collect(),
            slope: (derivatives.rhs.column(channel) - &derivatives.model * state.x.column(channel))
                .data
                .into(),
        });
        let channels: Vec<Channel> = channels.collect();
        let mut gradient = DVector::zeros(size);
        for Channel { copies, radiance, slope } in &channels {
            (0..size).for_each(|i| gradient[i] -= copies * radiance[i] * slope[i]);
        }
        let bend = is_exact.then(|| bend(problem, state, &derivatives)).flatten();
        let (mut hessian, mut scale) = (DMatrix::zeros(size, size), DVector::zeros(size));
        for (channels, inverse) in alike(state, &channels) {
            let with_slopes = bend.is_some();
            let share = Share { derivatives: &derivatives, channels, inverse: &inverse, first, with_slopes };
            Arch::new().dispatch(Add { share, hessian: &mut hessian, scale: &mut scale });
        }
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

/// What a channel does with the derivatives.
struct Channel {
    copies: f64,
    /// The radiance `x_i` of the light of each coordinate.
    radiance: Vec<f64>,
    /// `Lambda_i`
    slope: Vec<f64>,
}

/// Channels whose radiances follow in the same way when a light turns, and that way: `G^-1`, 0 where no column is in
/// use.
fn alike<'a>(state: &'a State, channels: &'a [Channel]) -> Vec<(&'a [Channel], DMatrix<f64>)> {
    let same = |a: usize, b: usize| {
        Arc::ptr_eq(&state.supports[a], &state.supports[b])
            && state.dark[a].is_empty()
            && state.dark[b].is_empty()
    };
    let mut out = Vec::new();
    let mut first = 0;
    while first < channels.len() {
        let count =
            (first..channels.len()).take_while(|&channel| channel == first || same(first, channel)).count();
        let inverse = held(state.supports[first].inverse(state.x.nrows()), &state.dark[first]);
        out.push((&channels[first..first + count], inverse));
        first += count;
    }
    out
}

/// `R = G^-1` where the ambient term, of rows C, is held at zero for the normals `dark`:
/// `R - R C^T (C R C^T)^-1 C R`.
fn held(inverse: DMatrix<f64>, dark: &[DVec3]) -> DMatrix<f64> {
    if dark.is_empty() {
        return inverse;
    }
    let rows: Vec<[f64; 9]> = dark.iter().map(|&n| Ambient::Sh2.irradiance(n)).collect();
    let rows = DMatrix::from_fn(dark.len(), inverse.nrows(), |i, k| *rows[i].get(k).unwrap_or(&0.0));
    let along = &rows * &inverse;
    let mut gram = &along * rows.transpose();
    // Two of the normals may be all but the same.
    (0..gram.nrows()).for_each(|i| gram[(i, i)] *= 1.0 + 1e-12);
    match gram.cholesky() {
        Some(factor) => inverse - along.tr_mul(&factor.solve(&along)),
        None => inverse,
    }
}

/// The share of the hessian that some channels have, without second derivatives of columns. With D the products of the
/// derivatives with each other, M with the columns, `K = M G^-1` and o(i) the column of the light of i,
///
/// ```text
///   T_c G_c^-1 T_c^T = x_i x_k (K M^T)_ik - x_i Lambda_k K_i,o(k) - Lambda_i x_k K_k,o(i) + Lambda_i Lambda_k G^-1_o(i),o(k)
/// ```
///
/// so that only sums over channels of products of x and Lambda are needed, not T.
struct Share<'a> {
    derivatives: &'a Derivatives,
    channels: &'a [Channel],
    inverse: &'a DMatrix<f64>,
    /// Column of the first light that may turn.
    first: usize,
    with_slopes: bool,
}

/// Adds a share to the hessian, and what it is without slopes to the scale.
struct Add<'a> {
    share: Share<'a>,
    hessian: &'a mut DMatrix<f64>,
    scale: &'a mut DVector<f64>,
}

impl WithSimd for Add<'_> {
    type Output = ();

    #[inline(always)]
    #[allow(clippy::inline_always, reason = "what is not inlined is compiled for the oldest of processors")]
    fn with_simd<S: Simd>(self, _: S) {
        let Share { derivatives: Derivatives { model, gram, .. }, channels, inverse, first, with_slopes } =
            self.share;
        let (size, columns) = (gram.nrows(), model.ncols());
        if size == 0 {
            return;
        }
        // K, then D - K M^T a column at a time.
        let mut along = vec![0.0; size * columns];
        for (along, inverse) in along.chunks_exact_mut(size).zip(inverse.as_slice().chunks_exact(columns)) {
            for (model, &factor) in model.as_slice().chunks_exact(size).zip(inverse) {
                add(along, factor, model);
            }
        }
        let mut outside = vec![0.0; size];
        let (mut back, mut both) = (vec![0.0; size], vec![0.0; size]);
        for (k, hessian) in self.hessian.as_mut_slice().chunks_exact_mut(size).enumerate() {
            outside.copy_from_slice(&gram.as_slice()[k * size..][..size]);
            for (along, model) in along.chunks_exact(size).zip(model.as_slice().chunks_exact(size)) {
                add(&mut outside, -model[k], along);
            }
            for Channel { copies, radiance, .. } in channels {
                add_products(hessian, copies * radiance[k], radiance, &outside);
                self.scale[k] += (copies * radiance[k] * radiance[k] * outside[k]).max(0.0);
            }
            if !with_slopes {
                continue;
            }
            let own = first + k / 2;
            for i in 0..size {
                back[i] = along[(first + i / 2) * size + k];
                both[i] = inverse[(first + i / 2, own)];
            }
            for Channel { copies, radiance, slope } in channels {
                add_products(hessian, copies * slope[k], radiance, &along[own * size..][..size]);
                add_products(hessian, copies * radiance[k], slope, &back);
                add_products(hessian, -copies * slope[k], slope, &both);
            }
        }
    }
}

/// `out + factor a`
#[inline(always)]
#[allow(clippy::inline_always, reason = "what is not inlined is compiled for the oldest of processors")]
fn add(out: &mut [f64], factor: f64, a: &[f64]) {
    out.iter_mut().zip(a).for_each(|(out, a)| *out += factor * a);
}

/// `out + factor a b`, element by element.
#[inline(always)]
#[allow(clippy::inline_always, reason = "what is not inlined is compiled for the oldest of processors")]
fn add_products(out: &mut [f64], factor: f64, a: &[f64], b: &[f64]) {
    out.iter_mut().zip(a).zip(b).for_each(|((out, a), b)| *out += factor * a * b);
}

/// `-sum_c x_ic <d^2 a_ik, r_c>`: a block for each light. None where there are no second derivatives.
///
/// Of `-r_c = sum of all columns - E_c`, light by light: the second derivative by its own direction.
fn bend(problem: &Problem<'_>, state: &State, derivatives: &Derivatives) -> Option<DMatrix<f64>> {
    let given = problem.objective.given();
    let (ambient, lights) = (given.ambient.coefficients(), state.lights());
    let mut out = DMatrix::zeros(derivatives.gram.nrows(), derivatives.gram.nrows());
    let (mut others, mut sides) = (Vec::with_capacity(lights), Vec::with_capacity(given.sides()));
    for (i, frame) in derivatives.frames.iter().enumerate() {
        let own = |channel: usize| given.copies(channel) * state.x[(ambient + problem.fixed + i, channel)];
        let product = |row: usize| (0..state.x.ncols()).map(|c| own(c) * state.x[(row, c)]).sum::<f64>();
        others.clear();
        others.extend((0..lights).map(|k| (product(ambient + k), state.moments.directions[k])));
        sides.clear();
        sides.extend((0..ambient).map(product).chain((0..state.x.ncols()).map(|c| -own(c))));
        let l = state.moments.directions[problem.fixed + i];
        let second = problem.objective.second_derivative(l, &others, &sides)?;
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
