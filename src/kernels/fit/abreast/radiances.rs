//! The best radiances of lights in fixed directions, none negative, side by side.
#![allow(clippy::inline_always, reason = "what is not inlined is compiled for the oldest of processors")]

use std::rc::Rc;

use pulp::Simd;

use super::factors::Factors;
use crate::kernels::fit::wide::{Matrix, Wide, are_same, dot};

/// Rounds after which columns may still change places: what is negative then counts as none.
const ROUNDS: usize = 5;
/// Share of a column's product with the irradiance by which the cost has to fall along it.
const ROUNDING: f64 = 1e-13;

/// Columns that are used, 1 or 0 for each, and the factors of their Gram matrix.
pub struct Support {
    pub used: Vec<Wide>,
    pub factors: Factors,
}

impl Support {
    /// A column that is not used has a row of the identity in the Gram matrix instead.
    #[inline(always)]
    fn new<S: Simd>(simd: S, gram: &Matrix, used: &[Wide]) -> Self {
        let mut masked = gram.clone();
        for (i, own) in used.iter().enumerate() {
            let row = &mut masked.row_mut(i)[i..];
            for (value, other) in row.iter_mut().zip(&used[i..]) {
                *value = *value * *own * *other;
            }
            row[0] += Wide::ONE - *own;
        }
        Self { used: used.to_vec(), factors: Factors::new(simd, masked) }
    }

    /// That of the `used` columns, which may be the `last` one.
    #[inline(always)]
    fn after<S: Simd>(simd: S, gram: &Matrix, used: &[Wide], last: Option<Rc<Self>>) -> Rc<Self> {
        match last {
            Some(last) if are_same(simd, &last.used, used) => last,
            _ => Rc::new(Self::new(simd, gram, used)),
        }
    }
}

/// The values `x`, a row for each channel, from the columns on that are `used`: both are changed. Channels in a row that
/// use the same columns share their support.
///
/// Block principal pivoting, as in `nnls.rs`.
#[inline(always)]
pub fn solve<S: Simd>(
    simd: S,
    gram: &Matrix,
    right: &Matrix,
    used: &mut Matrix,
    x: &mut Matrix,
) -> Vec<Rc<Support>> {
    let mut supports = Vec::with_capacity(right.rows());
    let mut last = None;
    for channel in 0..right.rows() {
        let (right, used, x) = (right.row(channel), used.row_mut(channel), x.row_mut(channel));
        let mut is_settled = false;
        for _ in 0..ROUNDS {
            let support = Support::after(simd, gram, used, last);
            for i in 0..right.len() {
                x[i] = right[i] * used[i];
            }
            support.factors.solve(simd, x);
            last = Some(support);
            is_settled = !pivot(simd, gram, right, used, x);
            if is_settled {
                break;
            }
        }
        if !is_settled {
            for x in x {
                *x = x.max(simd, Wide::ZERO);
            }
        }
        supports.extend(last.clone());
    }
    supports
}

/// Give up columns that are negative, and use those along which the cost falls; whether there were any.
#[inline(always)]
fn pivot<S: Simd>(simd: S, gram: &Matrix, right: &[Wide], used: &mut [Wide], x: &[Wide]) -> bool {
    let mut changed = Wide::ZERO;
    for i in 0..right.len() {
        let fall = right[i] - dot(simd, gram.row(i), x);
        let comes = fall.above(simd, right[i].abs(simd) * Wide::splat(ROUNDING));
        let wanted = used[i] * x[i].above(simd, Wide::ZERO) + (Wide::ONE - used[i]) * comes;
        changed = changed.max(simd, (wanted - used[i]).abs(simd));
        used[i] = wanted;
    }
    changed != Wide::ZERO
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernels::fit::lanes::LANES;
    use crate::kernels::fit::nnls;
    use nalgebra::DMatrix;
    use pulp::Scalar;

    /// Block pivoting may go in circles. What is left then is not the best, but none of it is negative.
    #[test]
    fn lanes_have_the_values_that_nnls_finds_but_for_a_few() {
        const PROBLEMS: usize = 100;
        let random = |i: usize| (1.0 + 12.9898 * i as f64).sin() * 43758.5453 % 1.0;
        let mut found = 0;
        for problem in 0..PROBLEMS {
            let (mut gram, mut right) = (Matrix::zeros(5, 5), Matrix::zeros(2, 5));
            let alone: [(DMatrix<f64>, DMatrix<f64>); LANES] = std::array::from_fn(|lane| {
                let first = 56 * (problem * LANES + lane);
                let a = DMatrix::from_fn(8, 5, |i, k| random(first + 5 * i + k).abs());
                (a.tr_mul(&a), a.tr_mul(&DMatrix::from_fn(8, 2, |i, k| random(first + 40 + 2 * i + k))))
            });
            for (lane, (own, b)) in alone.iter().enumerate() {
                for i in 0..5 {
                    (0..5).for_each(|k| gram[(i, k)].0[lane] = own[(i, k)]);
                    (0..2).for_each(|channel| right[(channel, i)].0[lane] = b[(i, channel)]);
                }
            }
            let (mut used, mut x) = (Matrix::zeros(2, 5), Matrix::zeros(2, 5));
            used.values.fill(Wide::ONE);
            solve(Scalar::new(), &gram, &right, &mut used, &mut x);
            for (lane, (gram, right)) in alone.iter().enumerate() {
                let wanted = nnls::solve(gram, right, 0, &[]).0;
                let seen = DMatrix::from_fn(5, 2, |i, channel| x[(channel, i)].0[lane]);
                assert!(seen.min() >= 0.0, "{seen}");
                found += usize::from((seen - &wanted).amax() < 1e-9 * (1.0 + wanted.amax()));
            }
        }
        assert!(found * 100 >= 99 * LANES * PROBLEMS, "{found}");
    }
}
