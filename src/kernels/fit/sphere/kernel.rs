//! The inner product of two lights over all normals, as a function of the angle between them.
//!
//! For unit vectors a and b at the angle g, with `c = a.b = cos g`, the clamped cosines of two lights have
//!
//! ```text
//!   <max(0, n.a), max(0, n.b)> = k(c) = 2/3 (sin g + (pi - g) cos g)
//!   k'(c) = 2/3 (pi - g)        k''(c) = 2/3 / sin g
//! ```
//!
//! the arc-cosine kernel of order 1 (Cho and Saul 2009). The formulas below hold for any k; only
//! [`Angles`] and [`spectrum`] depend on this one. As a function of degree 1 in a and in b,
//! `|a| |b| k(a.b / |a| |b|)` has at unit vectors
//!
//! ```text
//!   gradient by a               (k - c k') a + k' b
//!   second derivative by a      (k - c k') I + k'' b b^T                on the tangent plane of a
//!   derivative by a             k' s.b
//!   mixed derivative by a, b    k' s.u + k'' (s.b) (a.u)                along the tangents s of a and u of b
//! ```

#![allow(clippy::inline_always, reason = "only inlined functions use the vectors of the processor")]

use std::f64::consts::{FRAC_PI_3, PI};

use glam::{DMat3, DVec3};
use pulp::Simd;

use crate::kernels::lanes::{LANES, Lanes, Number};

/// Up to [`LANES`] directions by axis, then zeros.
#[derive(Clone, Copy, Debug)]
pub struct Block {
    axes: [[f64; LANES]; 3],
}

impl Block {
    /// Group up to [`LANES`] directions.
    #[inline(always)]
    pub fn new(directions: impl Iterator<Item = DVec3>) -> Self {
        let mut axes = [[0.0; LANES]; 3];
        for (i, direction) in directions.take(LANES).enumerate() {
            (axes[0][i], axes[1][i], axes[2][i]) = (direction.x, direction.y, direction.z);
        }
        Self { axes }
    }

    /// The directions of one vector.
    #[inline(always)]
    pub fn at<S: Simd>(&self, simd: S, vector: usize) -> [Lanes<S>; 3] {
        let [x, y, z] = &self.axes;
        [Lanes::at(simd, x, vector), Lanes::at(simd, y, vector), Lanes::at(simd, z, vector)]
    }
}

/// One direction in all lanes.
#[inline(always)]
pub fn splat<S: Simd>(simd: S, direction: DVec3) -> [Lanes<S>; 3] {
    [Lanes::splat(simd, direction.x), Lanes::splat(simd, direction.y), Lanes::splat(simd, direction.z)]
}

/// The inner product of vectors.
#[inline(always)]
fn product<N: Number>(one: &[N; 3], other: &[N; 3]) -> N {
    (one[0] * other[0]).add_product(one[1], other[1]).add_product(one[2], other[2])
}

/// Angles between lights and other lights.
#[derive(Clone, Copy, Debug)]
pub struct Angles<N> {
    pub cosine: N,
    /// `sin^2 (h / 2)`, where h is the angle to the other direction or to its opposite, whichever is nearer.
    square: N,
}

impl<N: Number> Angles<N> {
    /// Angles between each of `lights` and its partner in `others`.
    ///
    /// The squared chord `|a - b|^2 = 4 sin^2 (h / 2)`, or `|a + b|^2`, keeps the digits of small angles.
    #[inline(always)]
    pub fn between(lights: &[N; 3], others: &[N; 3]) -> Self {
        let cosine = product(lights, others);
        let side = cosine.select_negative(cosine.like(-1.0), cosine.like(1.0));
        let mut chord = *lights;
        for (chord, other) in chord.iter_mut().zip(others) {
            *chord = *chord - side * *other;
        }
        Self { cosine, square: product(&chord, &chord) * cosine.like(0.25) }
    }

    /// k - c k'
    #[inline(always)]
    pub fn intercepts(&self) -> N {
        let Self { square, .. } = *self;
        (square * (square.like(1.0) - square)).sqrt() * square.like(4.0 / 3.0)
    }

    /// k'
    #[inline(always)]
    pub fn first(&self) -> N {
        let Self { cosine, square } = *self;
        let nearer = square.sqrt() * arcsines_over_sines(square) * square.like(2.0);
        cosine.select_negative(nearer, cosine.like(PI) - nearer) * cosine.like(2.0 / 3.0)
    }

    /// k'', bounded for equal and opposite directions, where all its factors vanish.
    #[inline(always)]
    pub fn second(&self) -> N {
        let intercepts = self.intercepts();
        intercepts.max(intercepts.like(f64::EPSILON)).recip() * intercepts.like(4.0 / 9.0)
    }

    /// k
    #[inline(always)]
    pub fn values(&self) -> N {
        self.intercepts().add_product(self.first(), self.cosine)
    }
}

/// `asin(s) / s` of s^2 from 0 to 1/2, to rounding: the polynomial through it at 18 Chebyshev nodes.
///
/// Sums of pairs, and of pairs of pairs (Estrin 1960), do not wait for each other as the steps of Horner's rule do.
#[inline(always)]
fn arcsines_over_sines<N: Number>(squares: N) -> N {
    #[allow(clippy::unreadable_literal, reason = "separators do not help to read them")]
    const COEFFICIENTS: [f64; 18] = [
        1.0,
        0.166666666666762,
        0.07499999997954865,
        0.04464285887642836,
        0.03038186720026906,
        0.02237424579593472,
        0.017315598153068924,
        0.01442521483157721,
        0.007444491594483014,
        0.03675926245278099,
        -0.12408617975799723,
        0.49501980536930673,
        -1.3361715648121495,
        2.733390279102066,
        -3.9743142368080293,
        3.9652390062242486,
        -2.4213735547737834,
        0.7052830179687845,
    ];
    let second = squares * squares;
    let fourth = second * second;
    let eighth = fourth * fourth;
    let (mut pairs, mut fours, mut eights) = ([squares; 9], [squares; 4], [squares; 2]);
    for i in 0..9 {
        let [low, high] = [COEFFICIENTS[2 * i], COEFFICIENTS[2 * i + 1]];
        pairs[i] = squares.like(low).add_product(squares.like(high), squares);
    }
    for i in 0..4 {
        fours[i] = pairs[2 * i].add_product(pairs[2 * i + 1], second);
    }
    for i in 0..2 {
        eights[i] = fours[2 * i].add_product(fours[2 * i + 1], fourth);
    }
    eights[0].add_product(eights[1].add_product(pairs[8], eighth), eighth)
}

/// First and mixed second derivatives of the kernel between lights and others.
#[derive(Clone, Copy, Debug)]
pub struct MixedDerivatives<N> {
    /// Along the tangents of the lights.
    pub own: [N; 2],
    /// Along the tangents of the others.
    pub other: [N; 2],
    /// Along a tangent of the lights and one of the others.
    pub both: [[N; 2]; 2],
}

/// Derivatives between lights and `others`, each a direction with two tangents.
#[inline(always)]
pub fn mixed_derivatives<N: Number>(lights: &[[N; 3]; 3], others: &[[N; 3]; 3]) -> MixedDerivatives<N> {
    let angles = Angles::between(&lights[0], &others[0]);
    let (first, second) = (angles.first(), angles.second());
    let zero = [first.like(0.0); 2];
    let mut mixed = MixedDerivatives { own: zero, other: zero, both: [zero; 2] };
    for a in 0..2 {
        let along = product(&others[0], &lights[a + 1]);
        mixed.own[a] = first * along;
        for b in 0..2 {
            let (back, across) =
                (product(&others[b + 1], &lights[0]), product(&others[b + 1], &lights[a + 1]));
            mixed.other[b] = first * back;
            mixed.both[a][b] = (first * across).add_product(second * along, back);
        }
    }
    mixed
}

/// The weighted sum of the second derivatives by `l` of the kernels between it and `others`, on its tangent plane.
///
/// Only the tangential parts of the others are multiplied by k'', which may be large.
#[inline(always)]
pub fn second_derivative<S: Simd>(simd: S, l: DVec3, weights: &[f64; LANES], others: &Block) -> DMat3 {
    let own = splat(simd, l);
    // xx, yy, zz, xy, yz, zx
    let mut sums = [Lanes::splat(simd, 0.0); 6];
    for vector in 0..Lanes::<S>::VECTORS {
        let (weights, others) = (Lanes::at(simd, weights, vector), others.at(simd, vector));
        let angles = Angles::between(&own, &others);
        let (round, second) = (weights * angles.intercepts(), weights * angles.second());
        let mut flat = others;
        for axis in 0..3 {
            flat[axis] = others[axis] - angles.cosine * own[axis];
        }
        for axis in 0..3 {
            let next = (axis + 1) % 3;
            sums[axis] = sums[axis] + round.add_product(second * flat[axis], flat[axis]);
            sums[axis + 3] = sums[axis + 3].add_product(second * flat[axis], flat[next]);
        }
    }
    let (xx, yy, zz) = (sums[0].sum(), sums[1].sum(), sums[2].sum());
    let (xy, yz, zx) = (sums[3].sum(), sums[4].sum(), sums[5].sum());
    DMat3::from_cols_array(&[xx, xy, zx, xy, yy, yz, zx, yz, zz])
}

/// `a b^T`
#[inline(always)]
pub fn outer(a: DVec3, b: DVec3) -> DMat3 {
    DMat3::from_cols(a * b.x, a * b.y, a * b.z)
}

/// Factors of spherical harmonics of the even `degrees` 0, 2, .. in a convolution with a clamped cosine (Ramamoorthi and
/// Hanrahan 2001, equation 8).
pub fn clamped_cosine(degrees: usize) -> Vec<f64> {
    let mut binomial = -1.0; // l! / (2^l (l/2)!^2) with alternating sign
    let degrees = (0..degrees).map(|i| 2.0 * i as f64);
    degrees
        .map(|l| {
            let factor = 2.0 * PI * binomial / ((l + 2.0) * (l - 1.0));
            binomial *= -(l + 1.0) / (l + 2.0);
            factor
        })
        .collect()
}

/// Factors of spherical harmonics of the even `degrees` in a convolution with the kernel.
///
/// The only odd degree is the first, with the factor [`LINEAR`].
pub fn spectrum(degrees: usize) -> Vec<f64> {
    clamped_cosine(degrees).into_iter().map(|factor| factor * factor).collect()
}

/// Product of the odd harmonics of a light at l and of a map with the vector irradiance F, over l.F.
pub const LINEAR: f64 = FRAC_PI_3;

/// The kernel of a light with itself.
pub const SQUARE: f64 = 2.0 * FRAC_PI_3;
