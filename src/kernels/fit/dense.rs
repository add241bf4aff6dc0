//! Loops over columns of small dense matrices: inlined, so that their callers choose how wide vectors are.
//! Closures are not always inlined, so there are none.
#![allow(clippy::inline_always, reason = "what is not inlined is compiled for the oldest of processors")]

use nalgebra::DMatrix;
use pulp::Simd;

/// Column `k`.
#[inline(always)]
pub fn column_of(matrix: &DMatrix<f64>, k: usize) -> &[f64] {
    let rows = matrix.nrows();
    &matrix.as_slice()[k * rows..(k + 1) * rows]
}

/// `out += factor a`
#[inline(always)]
pub fn add<S: Simd>(simd: S, out: &mut [f64], factor: f64, a: &[f64]) {
    let (out, out_rest) = S::as_mut_simd_f64s(out);
    let (a, a_rest) = S::as_simd_f64s(a);
    let factors = simd.splat_f64s(factor);
    for (out, &a) in out.iter_mut().zip(a) {
        *out = simd.mul_add_f64s(factors, a, *out);
    }
    for (out, a) in out_rest.iter_mut().zip(a_rest) {
        *out += factor * a;
    }
}
