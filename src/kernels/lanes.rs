//! One number type for formulas: a single number, or one vector of the processor with a number in each lane.

#![allow(clippy::inline_always, reason = "only inlined functions use the vectors of the processor")]

use std::ops::{Add, Mul, Sub};

use pulp::Simd;

/// A single number or a vector of numbers.
pub trait Number: Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> {
    /// Number of lanes.
    const COUNT: usize;

    /// `value` in every lane.
    fn like(self, value: f64) -> Self;

    /// The first of `values`, one for each lane.
    fn like_all(self, values: &[f64]) -> Self;

    /// The number in lane `i`.
    fn lane(self, i: usize) -> f64;

    /// Sum of the lanes.
    fn sum(self) -> f64;

    /// `self + one * other`, rounded once if the processor has fused multiply-add.
    fn add_product(self, one: Self, other: Self) -> Self;

    fn sqrt(self) -> Self;

    fn recip(self) -> Self;

    /// The larger number in each lane.
    fn max(self, other: Self) -> Self;

    /// `one` in lanes where this number is below 0, `other` elsewhere.
    fn select_negative(self, one: Self, other: Self) -> Self;
}

impl Number for f64 {
    const COUNT: usize = 1;

    #[inline(always)]
    fn like(self, value: f64) -> Self {
        value
    }

    #[inline(always)]
    fn like_all(self, values: &[f64]) -> Self {
        values[0]
    }

    #[inline(always)]
    fn lane(self, _: usize) -> f64 {
        self
    }

    #[inline(always)]
    fn sum(self) -> f64 {
        self
    }

    #[inline(always)]
    fn add_product(self, one: Self, other: Self) -> Self {
        self + one * other
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        Self::sqrt(self)
    }

    #[inline(always)]
    fn recip(self) -> Self {
        Self::recip(self)
    }

    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Self::max(self, other)
    }

    #[inline(always)]
    fn select_negative(self, one: Self, other: Self) -> Self {
        if self < 0.0 { one } else { other }
    }
}

/// Greatest number of lanes, that of AVX2. Blocks of 8 lanes leave the first cache, and fits take 1.04 times as long.
pub const LANES: usize = 4;

/// The numbers of one vector.
#[derive(Clone, Copy, Debug)]
pub struct Lanes<S: Simd> {
    simd: S,
    values: S::f64s,
}

impl<S: Simd> Lanes<S> {
    #[inline(always)]
    pub fn splat(simd: S, value: f64) -> Self {
        Self { simd, values: simd.splat_f64s(value) }
    }

    /// Number of vectors that hold [`LANES`] numbers.
    pub const VECTORS: usize = {
        assert!(S::F64_LANES <= LANES, "no vector is longer");
        LANES / S::F64_LANES
    };

    /// The `vector`-th of the vectors that hold `values`.
    #[inline(always)]
    pub fn at(simd: S, values: &[f64; LANES], vector: usize) -> Self {
        Self { simd, values: S::as_simd_f64s(values).0[vector] }
    }

    /// Write the numbers into the `vector`-th of the vectors that hold `values`.
    #[inline(always)]
    pub fn write(self, values: &mut [f64; LANES], vector: usize) {
        S::as_mut_simd_f64s(values).0[vector] = self.values;
    }

    /// One `number` of each of at most as many things as a vector has lanes; the last one fills the remaining lanes.
    #[inline(always)]
    pub fn gather<A>(simd: S, things: &[A], number: impl Fn(&A) -> f64) -> Self {
        let mut values = [0.0; LANES];
        for (i, value) in values.iter_mut().enumerate() {
            *value = number(&things[i.min(things.len() - 1)]);
        }
        Self::splat(simd, 0.0).like_all(&values)
    }
}

impl<S: Simd> Number for Lanes<S> {
    const COUNT: usize = S::F64_LANES;

    #[inline(always)]
    fn like(self, value: f64) -> Self {
        Self::splat(self.simd, value)
    }

    #[inline(always)]
    fn like_all(self, values: &[f64]) -> Self {
        Self { values: S::as_simd_f64s(values).0[0], ..self }
    }

    #[inline(always)]
    fn lane(self, i: usize) -> f64 {
        pulp::bytemuck::cast_slice(std::slice::from_ref(&self.values))[i]
    }

    #[inline(always)]
    fn sum(self) -> f64 {
        self.simd.reduce_sum_f64s(self.values)
    }

    #[inline(always)]
    fn add_product(self, one: Self, other: Self) -> Self {
        Self { values: self.simd.mul_add_e_f64s(one.values, other.values, self.values), ..self }
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        Self { values: self.simd.sqrt_f64s(self.values), ..self }
    }

    #[inline(always)]
    fn recip(self) -> Self {
        Self { values: self.simd.div_f64s(self.simd.splat_f64s(1.0), self.values), ..self }
    }

    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Self { values: self.simd.max_f64s(self.values, other.values), ..self }
    }

    #[inline(always)]
    fn select_negative(self, one: Self, other: Self) -> Self {
        let is_negative = self.simd.less_than_f64s(self.values, self.simd.splat_f64s(0.0));
        Self { values: self.simd.select_f64s(is_negative, one.values, other.values), ..self }
    }
}

/// Implement an operator lane by lane.
macro_rules! operator {
    ($operator:ident, $method:ident, $simd:ident) => {
        impl<S: Simd> $operator for Lanes<S> {
            type Output = Self;

            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self { values: self.simd.$simd(self.values, other.values), ..self }
            }
        }
    };
}

operator!(Add, add, add_f64s);
operator!(Sub, sub, sub_f64s);
operator!(Mul, mul, mul_f64s);
