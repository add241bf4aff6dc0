//! The inner product of two lights over all normals, as a function of the angle between them.
//!
//! For unit vectors a and b at the angle g, with `c = a.b = cos g`, the clamped cosines of two lights have
//!
//! ```text
//!   <max(0, n.a), max(0, n.b)> = k(c) = 2/3 (sin g + (pi - g) cos g)
//!   k'(c) = 2/3 (pi - g)        k''(c) = 2/3 / sin g
//! ```
//!
//! the arc-cosine kernel of order 1 (Cho and Saul 2009). All that follows is true of any k: only
//! [`Angles`] and [`spectrum`] know which it is. As a function of degree 1 in a and in b,
//! `|a| |b| k(a.b / |a| |b|)` has at unit vectors
//!
//! ```text
//!   gradient by a               (k - c k') a + k' b
//!   second derivative by a      (k - c k') I + k'' b b^T                on the tangent plane of a
//!   derivative by a             k' s.b
//!   mixed derivative by a, b    k' s.u + k'' (s.b) (a.u)                along the tangents s of a and u of b
//! ```

#![allow(clippy::inline_always, reason = "what is not inlined is compiled for the oldest of processors")]

use std::f64::consts::{FRAC_PI_3, PI};

use glam::{DMat3, DVec3};

/// Directions side by side: two vectors of most processors, which do not wait for each other.
pub const LANES: usize = 8;

/// As many directions, or fewer and zeros.
#[derive(Clone, Copy, Debug)]
pub struct Lanes {
    pub axes: [[f64; LANES]; 3],
}

impl Lanes {
    /// Of up to [`LANES`].
    #[inline(always)]
    pub fn new(directions: impl Iterator<Item = DVec3>) -> Self {
        let mut axes = [[0.0; LANES]; 3];
        for (i, direction) in directions.take(LANES).enumerate() {
            (0..3).for_each(|axis| axes[axis][i] = direction[axis]);
        }
        Self { axes }
    }

    /// The product of each with `v`.
    #[inline(always)]
    pub fn dots(&self, v: DVec3) -> [f64; LANES] {
        let ([x, y, z], mut dots) = (&self.axes, [0.0; LANES]);
        (0..LANES).for_each(|i| dots[i] = v.x * x[i] + v.y * y[i] + v.z * z[i]);
        dots
    }
}

/// The angles between a light and others.
#[derive(Clone, Copy, Debug)]
pub struct Angles {
    pub cosine: [f64; LANES],
    /// `sin^2 (h / 2)`, h: the angle to the other or to its opposite, whichever is nearer.
    square: [f64; LANES],
}

impl Angles {
    /// Between `l` and each of `others`. The squared chord `|a - b|^2 = 4 sin^2 (h / 2)`, or `|a + b|^2`, keeps the
    /// digits of small angles.
    #[inline(always)]
    pub fn new(l: DVec3, Lanes { axes: [x, y, z] }: &Lanes) -> Self {
        let (mut cosine, mut square) = ([0.0; LANES], [0.0; LANES]);
        for i in 0..LANES {
            cosine[i] = l.x * x[i] + l.y * y[i] + l.z * z[i];
            let side = 1.0_f64.copysign(cosine[i]);
            let chord = [l.x - side * x[i], l.y - side * y[i], l.z - side * z[i]];
            square[i] = 0.25 * (chord[0] * chord[0] + chord[1] * chord[1] + chord[2] * chord[2]);
        }
        Self { cosine, square }
    }

    /// k - c k'
    #[inline(always)]
    pub fn rests(&self) -> [f64; LANES] {
        self.square.map(|square| 4.0 / 3.0 * (square * (1.0 - square)).sqrt())
    }

    /// k'
    #[inline(always)]
    pub fn slopes(&self) -> [f64; LANES] {
        let mut slopes = [0.0; LANES];
        let over_sine = arcsines_over_sines(&self.square);
        for i in 0..LANES {
            let nearer = 2.0 * self.square[i].sqrt() * over_sine[i];
            slopes[i] = 2.0 / 3.0 * if self.cosine[i] < 0.0 { nearer } else { PI - nearer };
        }
        slopes
    }

    /// k''; bounded where the directions are the same or opposite: all that it multiplies vanishes there.
    #[inline(always)]
    pub fn bends(&self) -> [f64; LANES] {
        self.rests().map(|rest| 4.0 / 9.0 / rest.max(f64::EPSILON))
    }

    /// k
    #[inline(always)]
    pub fn values(&self) -> [f64; LANES] {
        let (mut values, slopes) = (self.rests(), self.slopes());
        (0..LANES).for_each(|i| values[i] += slopes[i] * self.cosine[i]);
        values
    }
}

/// `asin(s) / s` of s^2 from 0 to 1/2, to rounding: the polynomial through it at 18 Chebyshev nodes.
///
/// Summed in pairs, and pairs of pairs (Estrin 1960): from the last coefficient on, each step would wait for the last.
#[inline(always)]
fn arcsines_over_sines(squares: &[f64; LANES]) -> [f64; LANES] {
    #[allow(clippy::unreadable_literal, reason = "no one reads them digit by digit")]
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
    let second = combined(squares, squares, &[0.0; LANES]);
    let fourth = combined(&second, &second, &[0.0; LANES]);
    let eighth = combined(&fourth, &fourth, &[0.0; LANES]);
    let mut eights = [[0.0; LANES]; 2];
    for (k, eight) in eights.iter_mut().enumerate() {
        let mut fours = [[0.0; LANES]; 2];
        for (j, four) in fours.iter_mut().enumerate() {
            let first = 8 * k + 4 * j;
            let low = combined(&[COEFFICIENTS[first + 1]; LANES], squares, &[COEFFICIENTS[first]; LANES]);
            let high =
                combined(&[COEFFICIENTS[first + 3]; LANES], squares, &[COEFFICIENTS[first + 2]; LANES]);
            *four = combined(&high, &second, &low);
        }
        *eight = combined(&fours[1], &fourth, &fours[0]);
    }
    let last = combined(&[COEFFICIENTS[17]; LANES], squares, &[COEFFICIENTS[16]; LANES]);
    combined(&combined(&last, &eighth, &eights[1]), &eighth, &eights[0])
}

/// `high x + low`
#[inline(always)]
fn combined(high: &[f64; LANES], x: &[f64; LANES], low: &[f64; LANES]) -> [f64; LANES] {
    let mut out = [0.0; LANES];
    (0..LANES).for_each(|i| out[i] = high[i] * x[i] + low[i]);
    out
}

/// Derivatives of the kernel between a light and each of others.
#[derive(Clone, Copy, Debug)]
pub struct Mixed {
    /// Along the tangents of the light.
    pub own: [[f64; LANES]; 2],
    /// Along those of the others.
    pub other: [[f64; LANES]; 2],
    /// Along one of the light and one of the others.
    pub both: [[[f64; LANES]; 2]; 2],
}

/// For a light with two tangents, `frame`, and `others` with theirs.
#[inline(always)]
pub fn mixed_derivatives(frame: [DVec3; 3], others: &[Lanes; 3]) -> Mixed {
    let angles = Angles::new(frame[0], &others[0]);
    let (slopes, bends) = (angles.slopes(), angles.bends());
    let zero = [[0.0; LANES]; 2];
    let mut mixed = Mixed { own: zero, other: zero, both: [zero; 2] };
    for a in 0..2 {
        let along = others[0].dots(frame[a + 1]);
        for b in 0..2 {
            let (back, across) = (others[b + 1].dots(frame[0]), others[b + 1].dots(frame[a + 1]));
            for i in 0..LANES {
                mixed.other[b][i] = slopes[i] * back[i];
                mixed.both[a][b][i] = slopes[i] * across[i] + bends[i] * along[i] * back[i];
            }
        }
        (0..LANES).for_each(|i| mixed.own[a][i] = slopes[i] * along[i]);
    }
    mixed
}

/// The weighted sum of the second derivatives by `l` of the kernels between it and `others`, on its tangent plane: of
/// the others only what lies in it, for k'' may be large.
#[inline(always)]
pub fn second_derivative(l: DVec3, weights: &[f64; LANES], others: &Lanes) -> DMat3 {
    let angles = Angles::new(l, others);
    let (rests, bends) = (angles.rests(), angles.bends());
    // xx, yy, zz, xy, yz, zx
    let mut sums = [[0.0; LANES]; 6];
    for i in 0..LANES {
        let [x, y, z] = [0, 1, 2].map(|axis| others.axes[axis][i] - angles.cosine[i] * l[axis]);
        let (round, bend) = (weights[i] * rests[i], weights[i] * bends[i]);
        let products = [round + bend * x * x, round + bend * y * y, round + bend * z * z];
        (0..3).for_each(|k| sums[k][i] = products[k]);
        let products = [bend * x * y, bend * y * z, bend * z * x];
        (0..3).for_each(|k| sums[3 + k][i] = products[k]);
    }
    let [xx, yy, zz, xy, yz, zx] = sums.map(sum);
    DMat3::from_cols_array(&[xx, xy, zx, xy, yy, yz, zx, yz, zz])
}

/// Of all lanes.
#[inline(always)]
pub fn sum(lanes: [f64; LANES]) -> f64 {
    let pair = |i: usize| lanes[i] + lanes[i + LANES / 2];
    (pair(0) + pair(2)) + (pair(1) + pair(3))
}

/// `a b^T`
#[inline(always)]
pub fn outer(a: DVec3, b: DVec3) -> DMat3 {
    DMat3::from_cols(a * b.x, a * b.y, a * b.z)
}

/// What the kernel multiplies spherical harmonics of the even `degrees` 0, 2, .. by when it is convolved with
/// them: the squares of those of a clamped cosine (Ramamoorthi and Hanrahan 2001, equation 8). It has no odd
/// degree but the first, whose factor is [`LINEAR`].
pub fn spectrum(degrees: usize) -> Vec<f64> {
    let mut binomial = 1.0; // l! / (2^l (l/2)!^2)
    let factor = |l: f64, binomial: f64| 2.0 * PI * binomial / ((l + 2.0) * (l - 1.0));
    let degrees = (0..degrees).map(|i| 2.0 * i as f64);
    degrees
        .map(|l| {
            let factor = factor(l, binomial);
            binomial *= (l + 1.0) / (l + 2.0);
            factor * factor
        })
        .collect()
}

/// What a light at l and a map of the vector irradiance F have in common by their odd harmonics, over l.F.
pub const LINEAR: f64 = FRAC_PI_3;

/// The kernel of a light with itself.
pub const SQUARE: f64 = 2.0 * FRAC_PI_3;
