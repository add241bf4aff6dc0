//! Factors of small symmetric matrices.
//!
//! Inside [`pulp::Arch::dispatch`] the loops over columns become wide vectors. They hold no closures, which are not
//! always inlined.
#![allow(clippy::inline_always, reason = "only inlined functions use the vectors of the processor")]

use nalgebra::DMatrix;
use pulp::{Arch, Simd, WithSimd};

/// Column `k` of a matrix.
#[inline(always)]
pub fn column_of(matrix: &DMatrix<f64>, k: usize) -> &[f64] {
    let rows = matrix.nrows();
    &matrix.as_slice()[k * rows..(k + 1) * rows]
}

/// `out += factor a`
#[inline(always)]
pub fn add(out: &mut [f64], factor: f64, a: &[f64]) {
    for (out, a) in out.iter_mut().zip(a) {
        *out += factor * a;
    }
}

/// Factors `L D L^T` of a symmetric positive definite matrix, where L is unit lower triangular and D diagonal.
///
/// They take no roots and one division for each column, because chains of these dominate for a small matrix.
#[derive(Clone, Debug, Default)]
pub struct Factors {
    /// L; the values above its diagonal are unused.
    lower: DMatrix<f64>,
    /// D
    pivots: Vec<f64>,
}

impl Factors {
    /// Factor a matrix, from its lower triangle; `None` if it is not positive definite.
    pub fn new(matrix: DMatrix<f64>) -> Option<Self> {
        Arch::new().dispatch(Factoring(matrix))
    }

    /// D: for a Gram matrix, the squared distance of each column from the span of those before it.
    pub fn pivots(&self) -> &[f64] {
        &self.pivots
    }

    /// `L_ik` below the diagonal of column k.
    #[inline(always)]
    fn below(&self, k: usize) -> &[f64] {
        &column_of(&self.lower, k)[k + 1..]
    }

    /// Replace a right-hand side by its solution.
    #[inline(always)]
    pub fn solve(&self, right: &mut [f64]) {
        let size = self.pivots.len();
        for k in 0..size {
            let (done, rest) = right.split_at_mut(k + 1);
            add(rest, -done[k], self.below(k));
        }
        right.iter_mut().zip(&self.pivots).for_each(|(right, pivot)| *right /= pivot);
        for k in (0..size).rev() {
            let (own, solved) = right.split_at_mut(k + 1);
            let known: f64 = solved.iter().zip(self.below(k)).map(|(x, l)| x * l).sum();
            own[k] -= known;
        }
    }

    /// Replace `rows` by `rows (L D^1/2)^-T`.
    ///
    /// Inner products with columns of this Gram matrix become inner products with orthonormal columns of the same span.
    #[inline(always)]
    pub fn orthonormalize(&self, rows: &mut DMatrix<f64>) {
        let height = rows.nrows();
        for i in 0..self.pivots.len() {
            let (done, rest) = rows.as_mut_slice().split_at_mut((i + 1) * height);
            let own = &mut done[i * height..];
            for (k, l) in self.below(i).iter().enumerate() {
                add(&mut rest[k * height..][..height], -l, own);
            }
            let scale = 1.0 / self.pivots[i].sqrt();
            for value in own {
                *value *= scale;
            }
        }
    }
}

/// See [`Factors::new`].
struct Factoring(DMatrix<f64>);

impl WithSimd for Factoring {
    type Output = Option<Factors>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Option<Factors> {
        let mut lower = self.0;
        let size = lower.ncols();
        let mut pivots = Vec::with_capacity(size);
        for k in 0..size {
            let (done, rest) = lower.as_mut_slice().split_at_mut((k + 1) * size);
            let own = &mut done[k * size..];
            let pivot = own[k];
            if pivot.is_nan() || pivot <= 0.0 {
                return None;
            }
            for value in &mut own[k + 1..] {
                *value /= pivot;
            }
            for j in k + 1..size {
                let column = &mut rest[(j - k - 1) * size..][..size];
                add(&mut column[j..], -own[j] * pivot, &own[j..]);
            }
            pivots.push(pivot);
        }
        Some(Factors { lower, pivots })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn the_solution_solves(values in proptest::collection::vec(-1.0..1.0_f64, 400), size in 1..18_usize) {
            let a = DMatrix::from_column_slice(20, size, &values[..20 * size]);
            let gram = a.tr_mul(&a);
            let expected = DMatrix::from_column_slice(size, 1, &values[400 - size..]);
            let mut solution = &gram * &expected;
            let factors = Factors::new(gram.clone()).expect("columns that are independent");
            factors.solve(solution.as_mut_slice());
            prop_assert!((solution - expected).amax() < 1e-8);
            // An indefinite matrix has no factors.
            prop_assert!(Factors::new(&gram - DMatrix::identity(size, size) * (gram.trace() + 1.0)).is_none());
        }
    }
}
