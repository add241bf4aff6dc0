//! Loops over columns of small dense matrices: inlined, so that their callers choose how wide vectors are.
#![allow(clippy::inline_always, reason = "what is not inlined is compiled for the oldest of processors")]

use nalgebra::DMatrix;

/// Column `k`.
#[inline(always)]
pub fn column_of(matrix: &DMatrix<f64>, k: usize) -> &[f64] {
    let rows = matrix.nrows();
    &matrix.as_slice()[k * rows..(k + 1) * rows]
}

/// `out += factor a`
#[inline(always)]
pub fn add(out: &mut [f64], factor: f64, a: &[f64]) {
    out.iter_mut().zip(a).for_each(|(out, a)| *out += factor * a);
}

/// `out += factor a b`, element by element.
#[inline(always)]
pub fn add_products(out: &mut [f64], factor: f64, a: &[f64], b: &[f64]) {
    out.iter_mut().zip(a).zip(b).for_each(|((out, a), b)| *out += factor * a * b);
}
