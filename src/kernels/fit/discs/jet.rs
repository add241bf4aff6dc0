//! Numbers that carry their first and second derivatives by N variables (forward differentiation).

use std::array::from_fn;
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
    pub fn constant(value: f64) -> Self {
        Self { value, first: [0.0; N], second: [[0.0; N]; N] }
    }

    /// The variable `i` itself.
    pub fn variable(value: f64, i: usize) -> Self {
        Self { first: from_fn(|k| f64::from(u8::from(k == i))), ..Self::constant(value) }
    }

    /// A function of it, given by its value and its two derivatives there.
    #[inline]
    pub fn map(self, [value, slope, bend]: [f64; 3]) -> Self {
        let first = self.first;
        let second = |i: usize, k: usize| slope * self.second[i][k] + bend * first[i] * first[k];
        Self { value, first: first.map(|d| slope * d), second: from_fn(|i| from_fn(|k| second(i, k))) }
    }

    /// A function of M such numbers, given by its value and its derivatives there.
    #[inline]
    pub fn compose<const M: usize>(outer: &Jet<M>, inner: &[Self; M]) -> Self {
        // The outer second derivatives times the inner first ones, once for all.
        let bends: [[f64; N]; M] =
            from_fn(|m| from_fn(|k| (0..M).map(|n| outer.second[m][n] * inner[n].first[k]).sum()));
        let first = |i: usize| (0..M).map(|m| outer.first[m] * inner[m].first[i]).sum();
        let second = |i: usize, k: usize| {
            (0..M).map(|m| outer.first[m] * inner[m].second[i][k] + inner[m].first[i] * bends[m][k]).sum()
        };
        Self { value: outer.value, first: from_fn(first), second: from_fn(|i| from_fn(|k| second(i, k))) }
    }

    pub fn sqrt(self) -> Self {
        let root = self.value.sqrt();
        self.map([root, 0.5 / root, -0.25 / (root * self.value)])
    }

    pub fn recip(self) -> Self {
        let one = 1.0 / self.value;
        self.map([one, -one * one, 2.0 * one * one * one])
    }
}

impl<const N: usize> Add for Jet<N> {
    type Output = Self;

    #[inline]
    fn add(self, other: Self) -> Self {
        Self {
            value: self.value + other.value,
            first: from_fn(|i| self.first[i] + other.first[i]),
            second: from_fn(|i| from_fn(|k| self.second[i][k] + other.second[i][k])),
        }
    }
}

impl<const N: usize> Add<f64> for Jet<N> {
    type Output = Self;

    #[inline]
    fn add(self, other: f64) -> Self {
        Self { value: self.value + other, ..self }
    }
}

impl<const N: usize> Mul<f64> for Jet<N> {
    type Output = Self;

    #[inline]
    fn mul(self, factor: f64) -> Self {
        self.map([factor * self.value, factor, 0.0])
    }
}

impl<const N: usize> Sub for Jet<N> {
    type Output = Self;

    #[inline]
    fn sub(self, other: Self) -> Self {
        self + other * -1.0
    }
}

#[allow(clippy::suspicious_arithmetic_impl, reason = "the rule for products adds")]
impl<const N: usize> Mul for Jet<N> {
    type Output = Self;

    #[inline]
    fn mul(self, other: Self) -> Self {
        let (a, b) = (self, other);
        let second = |i: usize, k: usize| {
            a.value * b.second[i][k]
                + b.value * a.second[i][k]
                + a.first[i] * b.first[k]
                + a.first[k] * b.first[i]
        };
        Self {
            value: a.value * b.value,
            first: from_fn(|i| a.value * b.first[i] + b.value * a.first[i]),
            second: from_fn(|i| from_fn(|k| second(i, k))),
        }
    }
}
