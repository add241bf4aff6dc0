//! Numbers that carry their first and second derivatives by N variables (forward differentiation).
//!
//! Loops instead of closures, which are not always inlined: so their callers choose how wide vectors are.

#![allow(clippy::inline_always, reason = "what is not inlined is compiled for the oldest of processors")]
#![allow(clippy::needless_range_loop, reason = "of rows and columns at once")]

use std::ops::{Add, Mul, Sub};

/// A value, and its derivatives.
#[derive(Clone, Copy, Debug)]
pub struct Jet<const N: usize> {
    pub value: f64,
    pub first: [f64; N],
    pub second: [[f64; N]; N],
}

impl<const N: usize> Jet<N> {
    /// The same everywhere.
    #[inline(always)]
    pub fn constant(value: f64) -> Self {
        Self { value, first: [0.0; N], second: [[0.0; N]; N] }
    }

    /// The variable `i` itself.
    #[inline(always)]
    pub fn variable(value: f64, i: usize) -> Self {
        let mut out = Self::constant(value);
        out.first[i] = 1.0;
        out
    }

    /// A function of it, given by its value and its two derivatives there.
    #[inline(always)]
    pub fn map(self, [value, slope, bend]: [f64; 3]) -> Self {
        let mut out = Self::constant(value);
        for i in 0..N {
            out.first[i] = slope * self.first[i];
            for k in 0..N {
                out.second[i][k] = slope * self.second[i][k] + bend * self.first[i] * self.first[k];
            }
        }
        out
    }

    /// A function of M such numbers, given by its value and its derivatives there.
    #[inline(always)]
    pub fn compose<const M: usize>(outer: &Jet<M>, inner: &[Self; M]) -> Self {
        let mut out = Self::constant(outer.value);
        for m in 0..M {
            // The outer second derivatives times the inner first ones, once for all.
            let mut bends = [0.0; N];
            for n in 0..M {
                for k in 0..N {
                    bends[k] += outer.second[m][n] * inner[n].first[k];
                }
            }
            for i in 0..N {
                out.first[i] += outer.first[m] * inner[m].first[i];
                for k in 0..N {
                    out.second[i][k] += outer.first[m] * inner[m].second[i][k] + inner[m].first[i] * bends[k];
                }
            }
        }
        out
    }

    #[inline(always)]
    pub fn sqrt(self) -> Self {
        let root = self.value.sqrt();
        self.map([root, 0.5 / root, -0.25 / (root * self.value)])
    }

    #[inline(always)]
    pub fn recip(self) -> Self {
        let one = 1.0 / self.value;
        self.map([one, -one * one, 2.0 * one * one * one])
    }
}

impl<const N: usize> Add for Jet<N> {
    type Output = Self;

    #[inline(always)]
    fn add(mut self, other: Self) -> Self {
        self.value += other.value;
        for i in 0..N {
            self.first[i] += other.first[i];
            for k in 0..N {
                self.second[i][k] += other.second[i][k];
            }
        }
        self
    }
}

impl<const N: usize> Add<f64> for Jet<N> {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: f64) -> Self {
        Self { value: self.value + other, ..self }
    }
}

impl<const N: usize> Mul<f64> for Jet<N> {
    type Output = Self;

    #[inline(always)]
    fn mul(mut self, factor: f64) -> Self {
        self.value *= factor;
        for i in 0..N {
            self.first[i] *= factor;
            for k in 0..N {
                self.second[i][k] *= factor;
            }
        }
        self
    }
}

impl<const N: usize> Sub for Jet<N> {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self + other * -1.0
    }
}

#[allow(clippy::suspicious_arithmetic_impl, reason = "the rule for products adds")]
impl<const N: usize> Mul for Jet<N> {
    type Output = Self;

    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        let (a, b) = (self, other);
        let mut out = Self::constant(a.value * b.value);
        for i in 0..N {
            out.first[i] = a.value * b.first[i] + b.value * a.first[i];
            for k in 0..N {
                out.second[i][k] = a.value * b.second[i][k]
                    + b.value * a.second[i][k]
                    + a.first[i] * b.first[k]
                    + a.first[k] * b.first[i];
            }
        }
        out
    }
}
