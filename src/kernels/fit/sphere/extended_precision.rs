//! The second derivatives of `kernel.rs` beside the same slopes, measured in double-double arithmetic.
//!
//! A number is the sum of two f64, exact to 32 digits (Dekker 1971). The reference knows the kernel by its definition
//! alone, `|a| |b| k(angle)`, and sine and cosine by their series; it takes central differences, and their limit by
//! Richardson's extrapolation.

use std::f64::consts::{PI, TAU};
use std::ops::{Add, Div, Mul, Neg, Sub};

use glam::DVec3;
use proptest::prelude::*;

use super::kernel::{Block, mixed_derivatives, second_derivative};
use crate::kernels::lanes::LANES;
use pulp::Scalar;

/// The first f64 has the number's leading digits.
#[derive(Clone, Copy, Debug)]
struct Double(f64, f64);

/// `a + b` of f64, without loss.
fn sum(a: f64, b: f64) -> Double {
    let whole = a + b;
    let part = whole - a;
    Double(whole, (a - (whole - part)) + (b - part))
}

impl From<f64> for Double {
    fn from(x: f64) -> Self {
        Self(x, 0.0)
    }
}

impl Neg for Double {
    type Output = Self;

    fn neg(self) -> Self {
        Self(-self.0, -self.1)
    }
}

impl Add for Double {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        let (high, low) = (sum(self.0, other.0), sum(self.1, other.1));
        let middle = sum(high.0, high.1 + low.0);
        sum(middle.0, middle.1 + low.1)
    }
}

impl Sub for Double {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Mul for Double {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        let whole = self.0 * other.0;
        let lost = self.0.mul_add(other.0, -whole);
        sum(whole, lost + (self.0 * other.1 + self.1 * other.0))
    }
}

impl Div for Double {
    type Output = Self;

    fn div(self, other: Self) -> Self {
        let mut quotient = Self::from(self.0 / other.0);
        for _ in 0..2 {
            quotient = quotient + Self::from((self - quotient * other).0 / other.0);
        }
        quotient
    }
}

impl Double {
    /// By Newton's steps, each of which doubles the digits.
    fn sqrt(self) -> Self {
        let mut root = Self::from(self.0.sqrt());
        for _ in 0..2 {
            root = root + (self - root * root) / (root + root);
        }
        root
    }

    /// `sum of x^i / i!` over i = `first`, `first` + 2, .. with alternating signs: the sine or the cosine.
    fn series(self, first: u32) -> Self {
        let mut term = if first == 0 { Self::from(1.0) } else { self };
        let mut sum = term;
        for i in (first + 1..60).step_by(2) {
            term = -(term * self * self) / Self::from(f64::from(i * (i + 1)));
            sum = sum + term;
        }
        sum
    }
}

type Vector = [Double; 3];

fn exact(v: DVec3) -> Vector {
    v.to_array().map(Double::from)
}

fn along(v: Vector, way: DVec3, step: f64) -> Vector {
    std::array::from_fn(|i| v[i] + Double::from(way[i]) * Double::from(step))
}

fn dot(a: Vector, b: Vector) -> Double {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: Vector, b: Vector) -> Vector {
    [[1, 2], [2, 0], [0, 1]].map(|[i, j]| a[i] * b[j] - a[j] * b[i])
}

/// `2/3 (sin g + (pi - g) cos g)` times both lengths, g being the angle between `a` and `b`.
fn kernel(a: Vector, b: Vector) -> Double {
    let across = cross(a, b);
    let (sine, cosine) = (dot(across, across).sqrt(), dot(a, b));
    let lengths = (dot(a, a) * dot(b, b)).sqrt();
    // One of Newton's steps from the angle in f64.
    let rough = Double::from(sine.0.atan2(cosine.0));
    let off = (sine * rough.series(0) - cosine * rough.series(1)) / lengths;
    let half_turn = Double(PI, 1.224_646_799_147_353_2e-16);
    let value = sine + (half_turn - rough - off) * cosine;
    value * Double::from(2.0) / Double::from(3.0)
}

/// The limit of a difference quotient whose error is even in its step.
fn limit(quotient: impl Fn(f64) -> Double, step: f64) -> f64 {
    let [one, half, quarter] = [1.0, 0.5, 0.25].map(|share| quotient(share * step));
    let better =
        |finer: Double, coarser: Double, order: f64| finer + (finer - coarser) / Double::from(order - 1.0);
    better(better(quarter, half, 4.0), better(half, one, 4.0), 16.0).0
}

/// Second derivative of the kernel along `u`, twice by `a`.
fn second(a: DVec3, b: DVec3, u: DVec3, step: f64) -> f64 {
    let value = |steps: f64| kernel(along(exact(a), u, steps), exact(b));
    let quotient = |h: f64| (value(h) + value(-h) - value(0.0) - value(0.0)) / Double::from(h * h);
    limit(quotient, step)
}

/// Second derivative by `a` along `u` and by `b` along `v`.
fn mixed(a: DVec3, b: DVec3, [u, v]: [DVec3; 2], step: f64) -> f64 {
    let value = |by_a: f64, by_b: f64| kernel(along(exact(a), u, by_a), along(exact(b), v, by_b));
    let quotient =
        |h: f64| (value(h, h) - value(h, -h) - value(-h, h) + value(-h, -h)) / Double::from(4.0 * h * h);
    limit(quotient, step)
}

/// Two lights at an `angle`, and tangents at each: along the arc between them, and slanting across it.
fn lights(azimuth: f64, height: f64, turn: f64, angle: f64) -> (DVec3, DVec3, [DVec3; 2], [DVec3; 2]) {
    let radius = (1.0 - height * height).sqrt();
    let a = DVec3::new(radius * azimuth.sin(), height, radius * azimuth.cos()).normalize();
    let (east, north) = a.any_orthonormal_pair();
    let way = east * turn.cos() + north * turn.sin();
    let b = (a * angle.cos() + way * angle.sin()).normalize();
    let slanting = |at: DVec3, along: DVec3| (along + at.cross(along)).normalize();
    let ahead = way * angle.cos() - a * angle.sin();
    (a, b, [way, slanting(a, way)], [ahead, slanting(b, ahead)])
}

#[test]
fn thirty_digits_are_right() {
    // sin(1), cos(1) and sqrt(2) to 31 digits, as two f64.
    let one = Double::from(1.0);
    for (found, wanted) in [
        (one.series(1), Double(0.841_470_984_807_896_5, 1.776_845_092_935_536e-18)),
        (Double::from(2.0).sqrt(), Double(std::f64::consts::SQRT_2, -9.667_293_313_452_913e-17)),
    ] {
        assert!((found - wanted).0.abs() < 1e-31, "{found:?}, wanted {wanted:?}");
    }
    let (sine, cosine) = (one.series(1), one.series(0));
    assert!((sine * sine + cosine * cosine - one).0.abs() < 1e-31);
}

proptest! {
    /// Bound 7 of `docs/bounds.md`.
    #[test]
    fn second_derivatives_are_those_of_extended_precision(
        azimuth in 0.0..TAU, height in -0.99..0.99_f64, turn in 0.0..TAU,
        angle in prop_oneof![0.01..3.13_f64, 1e-4..1e-2_f64, 3.1315..3.1414_f64],
    ) {
        const BOUND: f64 = 32.0 * f64::EPSILON / 2.0;
        let (a, b, at_a, at_b) = lights(azimuth, height, turn, angle);
        let step = 1e-3 * angle.sin();
        let mut weights = [0.0; LANES];
        weights[0] = 1.0;
        let own = second_derivative(Scalar::new(), a, &weights, &Block::new([b].into_iter()));
        let [own_frame, other_frame] = [[a, at_a[0], at_a[1]], [b, at_b[0], at_b[1]]]
            .map(|frame| frame.map(|axis| axis.to_array()));
        let both = mixed_derivatives(&own_frame, &other_frame).both;
        for (u, both) in at_a.into_iter().zip(both) {
            let (found, wanted) = (u.dot(own * u), second(a, b, u, step));
            prop_assert!((found - wanted).abs() <= BOUND, "{found:e} {wanted:e} {:e}", found - wanted);
            for (v, both) in at_b.into_iter().zip(both) {
                let (found, wanted) = (both, mixed(a, b, [u, v], step));
                prop_assert!((found - wanted).abs() <= BOUND, "mixed {found:e} {wanted:e} {:e}", found - wanted);
            }
        }
    }
}
