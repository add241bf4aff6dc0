//! Small dense matrices, column by column in wide vectors: inlined, so that their callers choose how wide these are.
//! Closures are not always inlined, so the loops have none.
#![allow(clippy::inline_always, reason = "what is not inlined is compiled for the oldest of processors")]

use nalgebra::DMatrix;
use pulp::{Arch, Simd, WithSimd};

/// Vectors of rows that are summed side by side.
pub const TILE: usize = 4;

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

/// The factors of a symmetric positive definite matrix `L D L^T`: L has ones in its diagonal and zeros above, D has
/// nothing else.
///
/// No roots, and one division for each column: a chain of them is what a small matrix waits for.
#[derive(Clone, Debug, Default)]
pub struct Factors {
    /// L, and rows below it until they fill whole vectors. What stands above the diagonal means nothing.
    lower: DMatrix<f64>,
    /// D
    pivots: Vec<f64>,
}

impl Factors {
    /// Of the lower triangle of a matrix; none where it is not positive definite.
    pub fn new(matrix: DMatrix<f64>) -> Option<Self> {
        Arch::new().dispatch(Factoring(matrix))
    }

    /// How many columns there are.
    pub fn size(&self) -> usize {
        self.pivots.len()
    }

    /// Squared length of each column beside the span of those before it, where this is a Gram matrix.
    pub fn pivots(&self) -> &[f64] {
        &self.pivots
    }

    /// `L_ik` below the diagonal of column k, i from k + 1 on.
    #[inline(always)]
    pub fn below(&self, k: usize) -> &[f64] {
        &column_of(&self.lower, k)[k + 1..self.size()]
    }

    /// The solution for one right-hand side, in its place.
    pub fn solve(&self, right: &mut [f64]) {
        Arch::new().dispatch(Solving { factors: self, right });
    }

    /// `L^-T D^-1 L^-1`
    #[inline(always)]
    pub fn inverse<S: Simd>(&self, simd: S) -> DMatrix<f64> {
        let (height, size) = self.lower.shape();
        // `L^-T`, a column after those before it, and its product with its transpose: in whole vectors.
        let mut rows = vec![0.0; height * size];
        let mut out = DMatrix::zeros(height, size);
        for k in 0..size {
            let (used, inverse) = ((k + 1).next_multiple_of(S::F64_LANES), 1.0 / self.pivots[k]);
            let (done, row) = rows.split_at_mut(k * height);
            row[k] = 1.0;
            for i in 0..k {
                add(simd, &mut row[..used], -self.lower[(k, i)], &done[i * height..][..used]);
            }
            for j in 0..=k {
                add(simd, &mut out.as_mut_slice()[j * height..][..used], inverse * row[j], &row[..used]);
            }
        }
        out.resize_vertically(size, 0.0)
    }

    /// `rows (L D^1/2)^-T`, in their place: with the factors of the Gram matrix of some columns, inner products with these
    /// become those with orthonormal columns that span the same.
    ///
    /// All rows at once, column by column: each column is long, the triangle is small.
    #[inline(always)]
    pub fn orthonormalize<S: Simd>(&self, simd: S, rows: &mut DMatrix<f64>) {
        let height = rows.nrows();
        for i in 0..self.size() {
            let (done, rest) = rows.as_mut_slice().split_at_mut((i + 1) * height);
            let own = &mut done[i * height..];
            for (k, l) in self.below(i).iter().enumerate() {
                add(simd, &mut rest[k * height..][..height], -l, own);
            }
            let scale = 1.0 / self.pivots[i].sqrt();
            for value in own {
                *value *= scale;
            }
        }
    }
}

/// What [`Factors::solve`] asks for.
struct Solving<'a> {
    factors: &'a Factors,
    right: &'a mut [f64],
}

impl WithSimd for Solving<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { factors, right } = self;
        let (lower, rows, size) = (factors.lower.as_slice(), factors.lower.nrows(), factors.size());
        for k in 0..size {
            let value = right[k];
            add(simd, &mut right[k + 1..size], -value, factors.below(k));
        }
        right.iter_mut().zip(&factors.pivots).for_each(|(right, pivot)| *right /= pivot);
        // Row by row, because each waits for the last alone.
        for i in (0..size).rev() {
            let value = right[i];
            for k in 0..i {
                right[k] -= lower[k * rows + i] * value;
            }
        }
    }
}

/// What [`Factors::new`] asks for.
struct Factoring(DMatrix<f64>);

impl WithSimd for Factoring {
    type Output = Option<Factors>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Option<Factors> {
        let size = self.0.ncols();
        let mut lower = self.0.resize_vertically(size.next_multiple_of(S::F64_LANES), 0.0);
        let (height, rows) = (lower.nrows(), lower.nrows() / S::F64_LANES);
        let mut pivots = Vec::with_capacity(size);
        for k in 0..size {
            let (done, own) = lower.as_mut_slice()[..(k + 1) * height].split_at_mut(k * height);
            let (first, wide) = (k / S::F64_LANES, S::as_mut_simd_f64s(own).0);
            let tiled = first + (rows - first) / TILE * TILE;
            for i in (first..tiled).step_by(TILE) {
                subtract_done::<S, TILE>(simd, done, &pivots, k, i, wide);
            }
            for i in tiled..rows {
                subtract_done::<S, 1>(simd, done, &pivots, k, i, wide);
            }
            let pivot = own[k];
            if pivot.is_nan() || pivot <= 0.0 {
                return None;
            }
            let scale = simd.splat_f64s(1.0 / pivot);
            for value in &mut S::as_mut_simd_f64s(own).0[first..] {
                *value = simd.mul_f64s(*value, scale);
            }
            pivots.push(pivot);
        }
        Some(Factors { lower, pivots })
    }
}

/// Takes `sum_j L_kj D_j L_j` of the columns that are done from N vectors of column k, from the vector i on: side by
/// side, because a sum that stands alone waits for itself at every term.
#[inline(always)]
fn subtract_done<S: Simd, const N: usize>(
    simd: S,
    done: &[f64],
    pivots: &[f64],
    k: usize,
    i: usize,
    own: &mut [S::f64s],
) {
    let (rows, height) = (own.len(), own.len() * S::F64_LANES);
    let wide = S::as_simd_f64s(done).0;
    let own = &mut own[i..][..N];
    let mut sums = [simd.splat_f64s(0.0); N];
    sums.copy_from_slice(own);
    for (j, pivot) in pivots.iter().enumerate() {
        let factor = simd.splat_f64s(done[j * height + k] * pivot);
        let column = &wide[j * rows + i..][..N];
        for n in 0..N {
            sums[n] = simd.negate_mul_add_f64s(factor, column[n], sums[n]);
        }
    }
    own.copy_from_slice(&sums);
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
            let wanted = DMatrix::from_column_slice(size, 1, &values[400 - size..]);
            let mut seen = &gram * &wanted;
            let factors = Factors::new(gram.clone()).expect("columns that are independent");
            factors.solve(seen.as_mut_slice());
            prop_assert!((seen - wanted).amax() < 1e-8);
            // With a direction that lowers it, it has none.
            prop_assert!(Factors::new(&gram - DMatrix::identity(size, size) * (gram.trace() + 1.0)).is_none());
        }
    }
}
