//! The cost around a state, to second order in the tangent coordinates `t` of its lights.
//!
//! With the best radiances `x` for every t, Kaufman's approximation of the Jacobian (1975), and `P_c` the
//! projection on the columns that channel c uses,
//!
//! ```text
//!   J_c = -(1 - P_c) D_c        D_c[:, jk] = x_jc da_j/dt_k
//!   J^T J [jk, j'k'] = sum_c x_jc x_j'c ( da_jk.da_j'k' - (A_c^T da_jk)^T G_c^-1 (A_c^T da_j'k') )
//!   J^T r [jk]       = -sum_c x_jc da_jk.r_c
//! ```
//!
//! all of them inner products that [`Derivatives`] holds.

use std::sync::Arc;

use glam::DVec3;
use nalgebra::{DMatrix, DVector, DVectorView};

use super::ambient::Ambient;
use super::moments::Derivatives;
use super::nnls::Support;
use super::solver::{Problem, State};

/// `cost + 2 slope.t + t^T H t`.
#[derive(Debug)]
pub struct Quadratic {
    curvature: DMatrix<f64>,
    slope: DVector<f64>,
}

/// Where a light stands on the horizon of a normal: `n.l = 0`, to first order `across.t = ahead` for its
/// two coordinates from `first` on.
#[derive(Clone, Copy, Debug)]
pub struct Crease {
    pub first: usize,
    pub across: [f64; 2],
    pub ahead: f64,
}

impl Quadratic {
    /// For the lights that may move.
    pub fn around(problem: &Problem<'_>, state: &State) -> Self {
        let derivatives = state.moments.derivatives(problem.probe, problem.held);
        let size = derivatives.gram.nrows();
        let left = &derivatives.right - &derivatives.model * &state.x;
        let mut sum = Self { curvature: DMatrix::zeros(size, size), slope: DVector::zeros(size) };
        let mut shared: Option<(&Arc<Support>, DMatrix<f64>)> = None;
        for (channel, (support, dark)) in state.supports.iter().zip(&state.dark).enumerate() {
            // Channels that use the same lights share the projection.
            if !dark.is_empty() || shared.as_ref().is_none_or(|(last, _)| !Arc::ptr_eq(last, support)) {
                shared = Some((support, outside(&derivatives, support, dark)));
            }
            let Some((_, outside)) = &shared else { continue };
            let irradiance = state.irradiance();
            let of = DVector::from_fn(size, |i, _| irradiance[(problem.held + i / 2, channel)]);
            sum.add(problem.probe.copies(channel), &of, outside, &left.column(channel));
        }
        sum
    }

    /// Add so many `copies` of a channel with this irradiance `of` each coordinate's light.
    fn add(&mut self, copies: f64, of: &DVector<f64>, outside: &DMatrix<f64>, left: &DVectorView<'_, f64>) {
        self.slope.zip_zip_apply(of, left, |slope, of, left| *slope -= copies * of * left);
        for (a, mut curvature) in self.curvature.column_iter_mut().enumerate() {
            curvature.zip_zip_apply(of, &outside.column(a), |curvature, of_b, outside| {
                *curvature += copies * of[a] * of_b * outside;
            });
        }
    }

    /// What the cost falls by with `step`.
    pub fn fall(&self, step: &DVector<f64>) -> f64 {
        -(2.0 * self.slope.dot(step) + step.dot(&(&self.curvature * step)))
    }

    /// `(H + damping diag H) step = -slope` (Levenberg 1944, Marquardt 1963), onto the `creases`: on
    /// either side of them stands a wall, `wall (across.step - ahead)^2`.
    pub fn step(&self, damping: f64, creases: &[Crease]) -> Option<DVector<f64>> {
        const STEEP: f64 = 1e8;
        let highest = self.curvature.diagonal().iter().copied().fold(0.0, f64::max);
        if highest <= 0.0 {
            return None;
        }
        let (mut damped, mut slope) = (self.curvature.clone(), self.slope.clone());
        for i in 0..slope.len() {
            // A light that no channel uses has no slope and no curvature: it stays where it is.
            damped[(i, i)] += damping * self.curvature[(i, i)] + 1e-14 * highest;
        }
        for &Crease { first, across, ahead } in creases {
            let across = DVector::from_column_slice(&across);
            let mut own = damped.view_mut((first, first), (2, 2));
            own.ger(STEEP * highest, &across, &across, 1.0);
            slope.rows_mut(first, 2).axpy(-STEEP * highest * ahead, &across, 1.0);
        }
        damped.cholesky().map(|factor| factor.solve(&-slope))
    }
}

/// Inner products of the derivatives outside the span of the columns in use.
///
/// With the factor L of the used columns' Gram matrix, `V = D^T A L^-T` holds what is inside. Where
/// the ambient term is held at zero for the normals `dark`, with rows C, the used columns may not
/// follow along `U = C L^-T`: that part of V is outside again.
fn outside(derivatives: &Derivatives, support: &Support, dark: &[DVec3]) -> DMatrix<f64> {
    let inside = support.orthonormal(derivatives.model.select_columns(&support.columns));
    let mut outside = derivatives.gram.clone();
    outside.gemm(-1.0, &inside, &inside.transpose(), 1.0);
    if !dark.is_empty() {
        let rows: Vec<[f64; 9]> = dark.iter().map(|&n| Ambient::Sh2.irradiance(n)).collect();
        let at = |i: usize, j: usize| *rows[i].get(support.columns[j]).unwrap_or(&0.0);
        let held = DMatrix::from_fn(dark.len(), support.columns.len(), at);
        let back = inside * support.orthonormal(held).transpose().col_piv_qr().q();
        outside += &back * back.transpose();
    }
    outside
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::kernels::sphere::direction;
    use proptest::prelude::*;

    /// `D^T (1 - P) D`, with the projection P on the columns `A x` that keep `C x = 0`.
    fn by_projection(a: &DMatrix<f64>, d: &DMatrix<f64>, c: &DMatrix<f64>) -> DMatrix<f64> {
        let held = c.transpose().qr().q();
        let free = (a - a * &held * held.transpose()).col_piv_qr();
        let basis = free.q().columns(0, a.ncols() - c.nrows()).into_owned();
        let inside = basis.transpose() * d;
        d.transpose() * d - inside.transpose() * inside
    }

    proptest! {
        /// From random columns, of which one is not in use, with and without normals held at zero.
        #[test]
        fn what_is_outside_is_what_a_projection_leaves(
            seed in 0_u64..1 << 20,
            dark in proptest::collection::vec((0.0..3.1, 0.0..6.2), 0..4),
        ) {
            // Scattered numbers that do not shrink: columns must not depend on each other.
            let scattered = |i: usize, j: usize| (1e4 * ((seed + (18 * i + j) as u64) as f64).sin()).fract();
            let all = DMatrix::from_fn(40, 18, scattered);
            let (columns, d) = (all.columns(0, 12).into_owned(), all.columns(12, 6).into_owned());
            let used: Vec<usize> = (0..12).filter(|&i| i != 10).collect();
            let dark: Vec<DVec3> = dark.into_iter().map(|(theta, phi)| direction(theta, phi)).collect();
            let support = Support::new(&(columns.transpose() * &columns), used.clone()).unwrap();
            let (model, gram) = (d.transpose() * &columns, d.transpose() * &d);
            let derivatives = Derivatives { model, gram, right: DMatrix::zeros(6, 3) };
            let seen = outside(&derivatives, &support, &dark);
            let c = DMatrix::from_fn(dark.len(), used.len(), |i, j| {
                *Ambient::Sh2.irradiance(dark[i]).get(used[j]).unwrap_or(&0.0)
            });
            let wanted = by_projection(&columns.select_columns(&used), &d, &c);
            prop_assert!((&seen - &wanted).amax() < 1e-9, "{} {seen} {wanted}", (&seen - &wanted).amax());
        }
    }
}
