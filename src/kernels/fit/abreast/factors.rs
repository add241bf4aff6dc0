//! `L D L^T` of symmetric positive definite matrices side by side.
#![allow(clippy::inline_always, reason = "what is not inlined is compiled for the oldest of processors")]

use pulp::Simd;

use crate::kernels::fit::wide::{Matrix, Wide, add};

/// Share of its diagonal value below which a pivot is rounding: it counts as this.
const LEAST_PIVOT: f64 = 1e-12;

/// The factors: L has ones in its diagonal, D has nothing else.
pub struct Factors {
    /// `-L^T`, a row for each column of L; what stands in and below the diagonal means nothing.
    upper: Matrix,
    inverse_pivots: Vec<Wide>,
}

impl Factors {
    /// Of matrices, of which only what is in and above the diagonal is read.
    #[inline(always)]
    pub fn new<S: Simd>(simd: S, mut upper: Matrix) -> Self {
        let size = upper.rows();
        let mut inverse_pivots = Vec::with_capacity(size);
        for k in 0..size {
            inverse_pivots.push(upper[(k, k)] * Wide::splat(LEAST_PIVOT));
        }
        for k in 0..size {
            let inverse = upper[(k, k)].max(simd, inverse_pivots[k]).recip(simd);
            inverse_pivots[k] = inverse;
            for i in k + 1..size {
                let factor = (upper[(k, i)] * inverse).negated();
                let (row, done) = upper.row_after(i);
                add(simd, &mut row[i..], factor, &done[k * size..][i..size]);
            }
            for value in &mut upper.row_mut(k)[k + 1..] {
                *value = (*value * inverse).negated();
            }
        }
        Self { upper, inverse_pivots }
    }

    /// `1 / D`
    pub fn inverse_pivots(&self) -> &[Wide] {
        &self.inverse_pivots
    }

    /// `L^-1 rows`, in their place.
    #[inline(always)]
    pub fn forward<S: Simd>(&self, simd: S, rows: &mut Matrix) {
        let columns = rows.columns();
        for i in 1..rows.rows() {
            let (row, done) = rows.row_after(i);
            for k in 0..i {
                add(simd, row, self.upper[(k, i)], &done[k * columns..][..columns]);
            }
        }
    }

    /// The solution for one right-hand side, in its place.
    #[inline(always)]
    pub fn solve<S: Simd>(&self, simd: S, right: &mut [Wide]) {
        for k in 0..right.len() {
            let (done, rest) = right.split_at_mut(k + 1);
            add(simd, rest, done[k], &self.upper.row(k)[k + 1..]);
            done[k] = done[k] * self.inverse_pivots[k];
        }
        for k in (0..right.len()).rev() {
            let (own, done) = right[k..].split_first_mut().expect("k is a place in it");
            for (value, factor) in done.iter().zip(&self.upper.row(k)[k + 1..]) {
                own.add_product(simd, *factor, *value);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernels::fit::lanes::LANES;
    use nalgebra::DMatrix;
    use proptest::prelude::*;
    use pulp::Scalar;

    proptest! {
        #[test]
        fn the_solution_solves_in_each_lane(values in proptest::collection::vec(-1.0..1.0_f64, 100 * LANES), size in 1..9_usize) {
            let grams: Vec<DMatrix<f64>> = values
                .chunks(100)
                .map(|values| DMatrix::from_column_slice(11, size, &values[..11 * size]))
                .map(|a| a.tr_mul(&a))
                .collect();
            let mut upper = Matrix::zeros(size, size);
            let mut right = vec![Wide::ZERO; size];
            for (lane, gram) in grams.iter().enumerate() {
                for i in 0..size {
                    (i..size).for_each(|k| upper[(i, k)].0[lane] = gram[(i, k)]);
                    right[i].0[lane] = values[lane + i];
                }
            }
            let mut x = right.clone();
            Factors::new(Scalar::new(), upper).solve(Scalar::new(), &mut x);
            for (lane, gram) in grams.iter().enumerate() {
                let [x, right] = [&x, &right].map(|column| DMatrix::from_fn(size, 1, |i, _| column[i].0[lane]));
                let seen = gram * &x - right;
                prop_assert!(seen.amax() < 1e-9 * (1.0 + x.amax()), "{seen}");
            }
        }
    }
}
