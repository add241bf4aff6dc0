//! Numbers that carry their first and second derivatives by N variables (forward differentiation).
//!
//! Loops instead of closures, which are not always inlined: so their callers choose how wide vectors are.

#![allow(clippy::inline_always, reason = "only inlined functions use the vectors of the processor")]
#![allow(clippy::needless_range_loop, reason = "of rows and columns at once")]

use std::ops::{Add, Mul, Sub};

use crate::kernels::lanes::Number;

/// A value, and its derivatives; second ones are symmetric.
#[derive(Clone, Copy, Debug)]
pub struct Jet<const N: usize, T = f64> {
    pub value: T,
    pub first: [T; N],
    pub second: [[T; N]; N],
}

impl<const N: usize, T: Number> Jet<N, T> {
    /// A constant.
    #[inline(always)]
    pub fn constant(value: T) -> Self {
        let zero = value.like(0.0);
        Self { value, first: [zero; N], second: [[zero; N]; N] }
    }

    /// The variable `i`; a constant if i is N or more.
    #[inline(always)]
    pub fn variable(value: T, i: usize) -> Self {
        let mut out = Self::constant(value);
        if i < N {
            out.first[i] = value.like(1.0);
        }
        out
    }

    /// A function of it, given by its value and its two derivatives there.
    #[inline(always)]
    pub fn map(self, [value, slope, bend]: [T; 3]) -> Self {
        let mut out = Self::constant(value);
        for i in 0..N {
            out.first[i] = slope * self.first[i];
            for k in 0..=i {
                let second = slope * self.second[i][k] + bend * self.first[i] * self.first[k];
                (out.second[i][k], out.second[k][i]) = (second, second);
            }
        }
        out
    }

    /// A function of M such numbers, given by its value and its derivatives there.
    #[inline(always)]
    pub fn compose<const M: usize>(outer: &Jet<M, T>, inner: &[Self; M]) -> Self {
        let mut out = Self::constant(outer.value);
        for m in 0..M {
            // The outer second derivatives times the inner first ones, once for all.
            let mut bends = [outer.value.like(0.0); N];
            for n in 0..M {
                for k in 0..N {
                    bends[k] = bends[k] + outer.second[m][n] * inner[n].first[k];
                }
            }
            for i in 0..N {
                out.first[i] = out.first[i] + outer.first[m] * inner[m].first[i];
                for k in 0..=i {
                    let own = outer.first[m] * inner[m].second[i][k];
                    out.second[i][k] = out.second[i][k] + own + inner[m].first[i] * bends[k];
                    out.second[k][i] = out.second[i][k];
                }
            }
        }
        out
    }

    #[inline(always)]
    pub fn sqrt(self) -> Self {
        let root = self.value.sqrt();
        let half = root.recip() * root.like(0.5);
        self.map([root, half, half * half * half * root.like(-2.0)])
    }

    #[inline(always)]
    pub fn recip(self) -> Self {
        let one = self.value.recip();
        let square = one * one;
        self.map([one, square * one.like(-1.0), square * one * one.like(2.0)])
    }
}

impl<const N: usize, T: Number> Add for Jet<N, T> {
    type Output = Self;

    #[inline(always)]
    fn add(mut self, other: Self) -> Self {
        self.value = self.value + other.value;
        for i in 0..N {
            self.first[i] = self.first[i] + other.first[i];
            for k in 0..N {
                self.second[i][k] = self.second[i][k] + other.second[i][k];
            }
        }
        self
    }
}

impl<const N: usize, T: Number> Add<f64> for Jet<N, T> {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: f64) -> Self {
        Self { value: self.value + self.value.like(other), ..self }
    }
}

impl<const N: usize, T: Number> Mul<f64> for Jet<N, T> {
    type Output = Self;

    #[inline(always)]
    fn mul(mut self, factor: f64) -> Self {
        let factor = self.value.like(factor);
        self.value = self.value * factor;
        for i in 0..N {
            self.first[i] = self.first[i] * factor;
            for k in 0..N {
                self.second[i][k] = self.second[i][k] * factor;
            }
        }
        self
    }
}

impl<const N: usize, T: Number> Sub for Jet<N, T> {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self + other * -1.0
    }
}

#[allow(clippy::suspicious_arithmetic_impl, reason = "the rule for products adds")]
impl<const N: usize, T: Number> Mul for Jet<N, T> {
    type Output = Self;

    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        let (a, b) = (self, other);
        let mut out = Self::constant(a.value * b.value);
        for i in 0..N {
            out.first[i] = a.value * b.first[i] + b.value * a.first[i];
            for k in 0..=i {
                let own = a.value * b.second[i][k] + b.value * a.second[i][k];
                let mixed = a.first[i] * b.first[k] + a.first[k] * b.first[i];
                (out.second[i][k], out.second[k][i]) = (own + mixed, own + mixed);
            }
        }
        out
    }
}
