//! Numbers side by side, in vectors as wide as the processor has, and matrices of them.
//!
//! Arrays, for they pass through the [`Objective`](super::Objective), which knows no vectors. Sums and products of them
//! become vectors of whoever calls from within [`pulp::Arch::dispatch`]; what the compiler does not find is written out.
//! Closures are not always inlined, so the loops have none.
#![allow(clippy::inline_always, reason = "what is not inlined is compiled for the oldest of processors")]

use std::ops::{Add, AddAssign, Index, IndexMut, Mul, Sub, SubAssign};

use pulp::Simd;

use super::lanes::LANES;

/// Numbers side by side.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Wide(pub [f64; LANES]);

/// An operator, lane by lane.
macro_rules! lane_by_lane {
    ($operator:ident, $function:ident, $assigning:ident, $assign:ident) => {
        impl $assigning for Wide {
            #[inline(always)]
            fn $assign(&mut self, other: Self) {
                for i in 0..LANES {
                    $assigning::$assign(&mut self.0[i], other.0[i]);
                }
            }
        }

        impl $operator for Wide {
            type Output = Self;

            #[inline(always)]
            fn $function(mut self, other: Self) -> Self {
                $assigning::$assign(&mut self, other);
                self
            }
        }
    };
}

lane_by_lane!(Add, add, AddAssign, add_assign);
lane_by_lane!(Sub, sub, SubAssign, sub_assign);

impl Mul for Wide {
    type Output = Self;

    #[inline(always)]
    fn mul(mut self, other: Self) -> Self {
        for i in 0..LANES {
            self.0[i] *= other.0[i];
        }
        self
    }
}

impl Wide {
    pub const ZERO: Self = Self([0.0; LANES]);
    pub const ONE: Self = Self([1.0; LANES]);

    /// The same number everywhere.
    #[inline(always)]
    pub const fn splat(value: f64) -> Self {
        Self([value; LANES])
    }

    /// With a product added, rounded once where the processor does so.
    #[inline(always)]
    pub fn add_product<S: Simd>(&mut self, simd: S, one: Self, other: Self) {
        let sums = S::as_mut_simd_f64s(&mut self.0).0;
        let (one, other) = (S::as_simd_f64s(&one.0).0, S::as_simd_f64s(&other.0).0);
        for i in 0..sums.len() {
            sums[i] = simd.mul_add_e_f64s(one[i], other[i], sums[i]);
        }
    }

    /// With a product taken away, rounded once where the processor does so.
    #[inline(always)]
    pub fn subtract_product<S: Simd>(&mut self, simd: S, one: Self, other: Self) {
        let sums = S::as_mut_simd_f64s(&mut self.0).0;
        let (one, other) = (S::as_simd_f64s(&one.0).0, S::as_simd_f64s(&other.0).0);
        for i in 0..sums.len() {
            sums[i] = simd.negate_mul_add_e_f64s(one[i], other[i], sums[i]);
        }
    }

    /// The same numbers below zero.
    #[inline(always)]
    pub fn negated(self) -> Self {
        Self::ZERO - self
    }

    /// The larger one of each pair.
    #[inline(always)]
    pub fn max<S: Simd>(mut self, simd: S, other: Self) -> Self {
        let (own, other) = (S::as_mut_simd_f64s(&mut self.0).0, S::as_simd_f64s(&other.0).0);
        for i in 0..own.len() {
            own[i] = simd.max_f64s(own[i], other[i]);
        }
        self
    }

    /// 1 where a number is above the other, else 0: of what is not a number as well.
    #[inline(always)]
    pub fn above<S: Simd>(mut self, simd: S, other: Self) -> Self {
        let (own, other) = (S::as_mut_simd_f64s(&mut self.0).0, S::as_simd_f64s(&other.0).0);
        let (one, zero) = (simd.splat_f64s(1.0), simd.splat_f64s(0.0));
        for i in 0..own.len() {
            own[i] = simd.select_f64s(simd.less_than_f64s(other[i], own[i]), one, zero);
        }
        self
    }

    #[inline(always)]
    pub fn recip<S: Simd>(mut self, simd: S) -> Self {
        let own = S::as_mut_simd_f64s(&mut self.0).0;
        for own in own {
            *own = simd.div_f64s(simd.splat_f64s(1.0), *own);
        }
        self
    }

    #[inline(always)]
    pub fn sqrt<S: Simd>(mut self, simd: S) -> Self {
        let own = S::as_mut_simd_f64s(&mut self.0).0;
        for own in own {
            *own = simd.sqrt_f64s(*own);
        }
        self
    }

    #[inline(always)]
    pub fn abs<S: Simd>(mut self, simd: S) -> Self {
        let own = S::as_mut_simd_f64s(&mut self.0).0;
        for own in own {
            *own = simd.abs_f64s(*own);
        }
        self
    }

    /// The numbers of `other` where `chosen` is 1, not 0.
    #[inline(always)]
    pub fn take<S: Simd>(&mut self, simd: S, other: Self, chosen: Self) {
        let own = S::as_mut_simd_f64s(&mut self.0).0;
        let (other, chosen) = (S::as_simd_f64s(&other.0).0, S::as_simd_f64s(&chosen.0).0);
        for i in 0..own.len() {
            let is_chosen = simd.less_than_f64s(simd.splat_f64s(0.0), chosen[i]);
            own[i] = simd.select_f64s(is_chosen, other[i], own[i]);
        }
    }
}

/// `sum a_i b_i`
#[inline(always)]
pub fn dot<S: Simd>(simd: S, a: &[Wide], b: &[Wide]) -> Wide {
    let mut sum = Wide::ZERO;
    for (a, b) in a.iter().zip(b) {
        sum.add_product(simd, *a, *b);
    }
    sum
}

/// Whether all numbers are the same.
#[inline(always)]
pub fn are_same<S: Simd>(simd: S, a: &[Wide], b: &[Wide]) -> bool {
    let mut difference = Wide::ZERO;
    for (a, b) in a.iter().zip(b) {
        difference = difference.max(simd, (*a - *b).abs(simd));
    }
    difference == Wide::ZERO
}

/// `out += factor a`
#[inline(always)]
pub fn add<S: Simd>(simd: S, out: &mut [Wide], factor: Wide, a: &[Wide]) {
    for (out, a) in out.iter_mut().zip(a) {
        out.add_product(simd, factor, *a);
    }
}

/// The numbers of `b` in place of those of `a` in the lanes where `chosen` is 1, not 0.
#[inline(always)]
pub fn take<S: Simd>(simd: S, a: &mut [Wide], b: &[Wide], chosen: Wide) {
    for (a, b) in a.iter_mut().zip(b) {
        a.take(simd, *b, chosen);
    }
}

/// Matrices side by side, row after row.
#[derive(Clone, Debug, Default)]
pub struct Matrix {
    columns: usize,
    pub values: Vec<Wide>,
}

impl Matrix {
    pub fn zeros(rows: usize, columns: usize) -> Self {
        Self { columns, values: vec![Wide::ZERO; rows * columns] }
    }

    #[inline(always)]
    pub fn row(&self, row: usize) -> &[Wide] {
        &self.values[row * self.columns..][..self.columns]
    }

    #[inline(always)]
    pub fn row_mut(&mut self, row: usize) -> &mut [Wide] {
        &mut self.values[row * self.columns..][..self.columns]
    }

    /// A row that is changed, and those before it.
    #[inline(always)]
    pub fn row_after(&mut self, row: usize) -> (&mut [Wide], &[Wide]) {
        let (done, rest) = self.values.split_at_mut(row * self.columns);
        (&mut rest[..self.columns], done)
    }

    pub fn columns(&self) -> usize {
        self.columns
    }

    /// How many rows there are; none of nothing.
    pub fn rows(&self) -> usize {
        self.values.len().checked_div(self.columns).unwrap_or(0)
    }

    /// That value everywhere in a lane.
    pub fn fill_lane(&mut self, lane: usize, value: f64) {
        for own in &mut self.values {
            own.0[lane] = value;
        }
    }

    /// The values of `other` in the lanes where `chosen` is 1, not 0.
    #[inline(always)]
    pub fn take<S: Simd>(&mut self, simd: S, other: &Self, chosen: Wide) {
        take(simd, &mut self.values, &other.values, chosen);
    }
}

impl Index<(usize, usize)> for Matrix {
    type Output = Wide;

    #[inline(always)]
    fn index(&self, (row, column): (usize, usize)) -> &Wide {
        &self.values[row * self.columns + column]
    }
}

impl IndexMut<(usize, usize)> for Matrix {
    #[inline(always)]
    fn index_mut(&mut self, (row, column): (usize, usize)) -> &mut Wide {
        &mut self.values[row * self.columns + column]
    }
}
