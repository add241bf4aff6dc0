//! Gradient and hessian of `newton.rs` but for the second derivatives of columns, in wide vectors.
//!
//! With D the products of the derivatives with each other, M with the columns, `K = M G_c^-1` and o(i) the column of the
//! light of the coordinate i,
//!
//! ```text
//!   T_c G_c^-1 T_c^T = x_i x_k (K M^T)_ik - x_i Lambda_k K_i,o(k) - Lambda_i x_k K_k,o(i) + Lambda_i Lambda_k G_c^-1_o(i),o(k)
//! ```
//!
//! so that channels that use the same columns share the products of matrices.
#![allow(clippy::inline_always, reason = "what is not inlined is compiled for the oldest of processors")]

use std::ops::Range;
use std::sync::Arc;

use glam::DVec3;
use nalgebra::{DMatrix, DVector};
use pulp::{Simd, WithSimd};

use super::ambient::Ambient;
use super::dense::{TILE, add, column_of};
use super::nnls::Support;
use super::objective::{Derivatives, Objective};
use super::state::State;

/// The sums over channels: hessian, gradient, and the diagonal of Gauss and Newton's hessian.
pub struct Sums<'a> {
    pub objective: &'a dyn Objective,
    pub state: &'a State,
    /// Lights that may not move.
    pub fixed: usize,
    /// With Lambda, beyond Gauss and Newton.
    pub is_exact: bool,
}

impl WithSimd for Sums<'_> {
    type Output = (DMatrix<f64>, DVector<f64>, DVector<f64>);

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
        let Self { objective, state, fixed, is_exact } = self;
        let parts = Parts::new(simd, objective, state, fixed);
        let (rows, size) = parts.derivatives.gram.shape();
        let mut gradient = DVector::zeros(rows);
        for (channel, copies) in parts.copies.iter().enumerate() {
            let slopes = column_of(&parts.radiance, channel).iter().zip(column_of(&parts.slope, channel));
            gradient.iter_mut().zip(slopes).for_each(|(sum, (x, slope))| *sum -= copies * x * slope);
        }
        let mut hessian = DMatrix::zeros(rows, size);
        let groups: Vec<Group> = parts.groups(simd, state, is_exact);
        for group in &groups {
            parts.add_gauss(simd, group, &mut hessian);
        }
        let scale = DVector::from_fn(size, |i, _| hessian[(i, i)].max(0.0));
        for group in groups.iter().filter(|_| is_exact) {
            parts.add_slopes(simd, group, &mut hessian);
        }
        let mut hessian = hessian.resize_vertically(size, 0.0);
        hessian.fill_upper_triangle_with_lower_triangle();
        (hessian, gradient.resize_vertically(size, 0.0), scale)
    }
}

/// What the sums are made of: a row for each coordinate, and more until they fill whole vectors.
struct Parts {
    derivatives: Derivatives,
    /// Of each channel, the radiance `x_i` of the light of each coordinate, and `Lambda_i`.
    radiance: DMatrix<f64>,
    slope: DMatrix<f64>,
    /// How many of red, green, blue each channel stands for.
    copies: Vec<f64>,
    /// Column of the first light that may move.
    first: usize,
}

/// Channels whose radiances follow in the same way when a light turns.
struct Group {
    channels: Range<usize>,
    /// K; without slopes a matrix whose product with itself is `K M^T` as well, and which is made sooner.
    along: DMatrix<f64>,
    /// `G_c^-1`, beside K.
    inverse: Option<DMatrix<f64>>,
}

impl Parts {
    #[inline(always)]
    fn new<S: Simd>(simd: S, objective: &dyn Objective, state: &State, fixed: usize) -> Self {
        let (given, mut derivatives) = (objective.given(), objective.derivatives(&state.moments, fixed));
        let rows = derivatives.gram.nrows().next_multiple_of(S::F64_LANES);
        derivatives.model = derivatives.model.resize_vertically(rows, 0.0);
        derivatives.gram = derivatives.gram.resize_vertically(rows, 0.0);
        let mut slope = derivatives.rhs.clone().resize_vertically(rows, 0.0);
        for (channel, x) in state.x.column_iter().enumerate() {
            let mut slope = slope.column_mut(channel);
            for (column, &x) in x.iter().enumerate() {
                add(simd, slope.as_mut_slice(), -x, column_of(&derivatives.model, column));
            }
        }
        let first = given.ambient.coefficients() + fixed;
        let of = |i: usize, channel: usize| *state.x.get((first + i / 2, channel)).unwrap_or(&0.0);
        let radiance = DMatrix::from_fn(rows, state.x.ncols(), of);
        let copies = (0..state.x.ncols()).map(|channel| given.copies(channel)).collect();
        Self { derivatives, radiance, slope, copies, first }
    }

    #[inline(always)]
    fn groups<S: Simd>(&self, simd: S, state: &State, is_exact: bool) -> Vec<Group> {
        let mut groups = Vec::with_capacity(self.copies.len());
        let mut from = 0;
        while from < self.copies.len() {
            let alike = |channel: &usize| *channel == from || follow_alike(state, from, *channel);
            let to = from + (from..self.copies.len()).take_while(alike).count();
            let (support, dark) = (&state.supports[from], &state.dark[from]);
            let (along, inverse) = if is_exact || !dark.is_empty() {
                let inverse = held(support.inverse(simd, state.x.nrows()), dark);
                (product(simd, &self.derivatives.model, &inverse), Some(inverse))
            } else {
                (self.orthonormal(simd, support), None)
            };
            groups.push(Group { channels: from..to, along, inverse });
            from = to;
        }
        groups
    }

    /// M with orthonormal columns in place of those of the support.
    #[inline(always)]
    fn orthonormal<S: Simd>(&self, simd: S, support: &Support) -> DMatrix<f64> {
        let model = &self.derivatives.model;
        let is_all = support.columns.len() == model.ncols();
        let mut columns = if is_all { model.clone() } else { model.select_columns(&support.columns) };
        support.factors.orthonormalize(simd, &mut columns);
        columns
    }

    /// `sum_c x_i x_k (D - K M^T)_ik`, in and below the diagonal.
    #[inline(always)]
    fn add_gauss<S: Simd>(&self, simd: S, group: &Group, hessian: &mut DMatrix<f64>) {
        let rows = hessian.nrows() / S::F64_LANES;
        for k in (0..hessian.ncols()).step_by(2) {
            let first = k / S::F64_LANES;
            let tiled = first + (rows - first) / TILE * TILE;
            for i in (first..tiled).step_by(TILE) {
                self.add_gauss_tile::<S, TILE>(simd, group, hessian, i, k);
            }
            for i in tiled..rows {
                self.add_gauss_tile::<S, 1>(simd, group, hessian, i, k);
            }
        }
    }

    /// N vectors of that from the row i on, for both coordinates k of a light.
    #[inline(always)]
    fn add_gauss_tile<S: Simd, const N: usize>(
        &self,
        simd: S,
        Group { channels, along, inverse }: &Group,
        hessian: &mut DMatrix<f64>,
        i: usize,
        k: usize,
    ) {
        let back = if inverse.is_some() { &self.derivatives.model } else { along };
        let rows = hessian.nrows() / S::F64_LANES;
        let (gram, radiance) = (wide::<S>(&self.derivatives.gram), wide::<S>(&self.radiance));
        // `K M^T - D`
        let mut inside = [[simd.splat_f64s(0.0); N]; 2];
        for side in 0..2 {
            for n in 0..N {
                inside[side][n] = simd.neg_f64s(gram[(k + side) * rows + i + n]);
            }
        }
        add_products::<S, N, 2>(simd, &mut inside, along, i, back, k);
        let hessian = S::as_mut_simd_f64s(hessian.as_mut_slice()).0;
        for (side, inside) in inside.iter().enumerate() {
            for (n, &inside) in inside.iter().enumerate() {
                let mut share = simd.splat_f64s(0.0);
                for channel in channels.clone() {
                    let factor = simd.splat_f64s(self.copies[channel] * self.radiance[(k + side, channel)]);
                    share = simd.mul_add_f64s(radiance[channel * rows + i + n], factor, share);
                }
                let sum = &mut hessian[(k + side) * rows + i + n];
                *sum = simd.negate_mul_add_f64s(share, inside, *sum);
            }
        }
    }

    /// What Lambda adds to that.
    #[inline(always)]
    fn add_slopes<S: Simd>(&self, simd: S, group: &Group, hessian: &mut DMatrix<f64>) {
        let Some(inverse) = &group.inverse else { return };
        let (along, radiance, slope) =
            (wide::<S>(&group.along), wide::<S>(&self.radiance), wide::<S>(&self.slope));
        let (height, rows) = (hessian.nrows(), hessian.nrows() / S::F64_LANES);
        // `K_k,o(i)` and `G^-1_o(i),o(k)`
        let (mut back, mut both) = (vec![0.0; height], vec![0.0; height]);
        for (k, hessian) in hessian.as_mut_slice().chunks_exact_mut(height.max(1)).enumerate() {
            let own = self.first + k / 2;
            for (i, column) in (self.first..inverse.nrows()).enumerate() {
                back[2 * i..][..2].fill(group.along[(k, column)]);
                both[2 * i..][..2].fill(inverse[(column, own)]);
            }
            let (hessian, back, both) =
                (S::as_mut_simd_f64s(hessian).0, S::as_simd_f64s(&back).0, S::as_simd_f64s(&both).0);
            for channel in group.channels.clone() {
                let copies = self.copies[channel];
                let x = simd.splat_f64s(copies * self.radiance[(k, channel)]);
                let own_slope = simd.splat_f64s(copies * self.slope[(k, channel)]);
                for i in k / S::F64_LANES..rows {
                    let towards = simd.mul_f64s(own_slope, along[own * rows + i]);
                    let back = simd.negate_mul_add_f64s(own_slope, both[i], simd.mul_f64s(x, back[i]));
                    hessian[i] = simd.mul_add_f64s(radiance[channel * rows + i], towards, hessian[i]);
                    hessian[i] = simd.mul_add_f64s(slope[channel * rows + i], back, hessian[i]);
                }
            }
        }
    }
}

/// Whether the radiances of two channels follow in the same way when a light turns.
fn follow_alike(state: &State, a: usize, b: usize) -> bool {
    Arc::ptr_eq(&state.supports[a], &state.supports[b])
        && state.dark[a].is_empty()
        && state.dark[b].is_empty()
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

/// `a b`, where the columns of a fill whole vectors and b is symmetric.
#[inline(always)]
fn product<S: Simd>(simd: S, a: &DMatrix<f64>, b: &DMatrix<f64>) -> DMatrix<f64> {
    let mut out = DMatrix::zeros(a.nrows(), b.ncols());
    let rows = a.nrows() / S::F64_LANES;
    let tiled = rows / TILE * TILE;
    for (k, out) in S::as_mut_simd_f64s(out.as_mut_slice()).0.chunks_exact_mut(rows.max(1)).enumerate() {
        for i in (0..tiled).step_by(TILE) {
            let mut sums = [[simd.splat_f64s(0.0); TILE]];
            add_products(simd, &mut sums, a, i, b, k);
            out[i..][..TILE].copy_from_slice(&sums[0]);
        }
        for (i, out) in out.iter_mut().enumerate().skip(tiled) {
            let mut sums = [[simd.splat_f64s(0.0)]];
            add_products(simd, &mut sums, a, i, b, k);
            [[*out]] = sums;
        }
    }
    out
}

/// Adds `a b^T`: N vectors of rows from the vector i on, and K columns from k on.
///
/// Side by side, because a sum that stands alone waits for itself at every term.
#[inline(always)]
fn add_products<S: Simd, const N: usize, const K: usize>(
    simd: S,
    sums: &mut [[S::f64s; N]; K],
    a: &DMatrix<f64>,
    i: usize,
    b: &DMatrix<f64>,
    k: usize,
) {
    let (rows, wide) = (a.nrows() / S::F64_LANES, wide::<S>(a));
    for column in 0..a.ncols() {
        let a = &wide[column * rows + i..][..N];
        let b = &column_of(b, column)[k..][..K];
        for side in 0..K {
            let factor = simd.splat_f64s(b[side]);
            for n in 0..N {
                sums[side][n] = simd.mul_add_f64s(a[n], factor, sums[side][n]);
            }
        }
    }
}

/// All columns, where they fill whole vectors.
#[inline(always)]
fn wide<S: Simd>(matrix: &DMatrix<f64>) -> &[S::f64s] {
    S::as_simd_f64s(matrix.as_slice()).0
}
