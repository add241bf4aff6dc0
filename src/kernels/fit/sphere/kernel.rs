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
//! [`Pair::new`] and [`spectrum`] know which it is. As a function of degree 1 in a and in b,
//! `|a| |b| k(a.b / |a| |b|)` has at unit vectors
//!
//! ```text
//!   gradient by a               (k - c k') a + k' b
//!   second derivative by a      (k - c k') I + k'' b b^T                on the tangent plane of a
//!   mixed derivative by a, b    (k - c k') a b^T + k' I + k'' (b - c a) (a - c b)^T
//! ```
//!
//! and the mixed derivative is the moment `<v_a, v_b^T>` of `objective.rs`.

use std::f64::consts::{FRAC_PI_3, PI};

use glam::{DMat3, DVec3};
use wide::f64x4;

/// Four directions side by side.
#[derive(Clone, Copy, Debug)]
pub struct Lanes {
    pub axes: [f64x4; 3],
}

impl Lanes {
    /// Of up to four; filled up with zeros.
    pub fn new(directions: &[DVec3]) -> Self {
        let mut axes = [[0.0; 4]; 3];
        for (i, direction) in directions.iter().enumerate() {
            (0..3).for_each(|axis| axes[axis][i] = direction[axis]);
        }
        Self { axes: axes.map(f64x4::from) }
    }
}

/// The kernel at four angles.
#[derive(Clone, Copy, Debug)]
pub struct Angles {
    pub cosine: f64x4,
    sine: f64x4,
    /// k'
    pub slope: f64x4,
}

/// The kernel between l and four others. The angle comes from both legs, which keeps the digits of small ones.
#[inline]
pub fn angle(l: DVec3, others: &Lanes) -> Angles {
    let (other, l) = (others.axes, l.to_array().map(f64x4::splat));
    let dot = |a: [f64x4; 3], b: [f64x4; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let cosine = dot(l, other);
    let cross = [(1, 2), (2, 0), (0, 1)].map(|(i, k)| l[i] * other[k] - l[k] * other[i]);
    let sine = dot(cross, cross).sqrt();
    let slope = (f64x4::splat(PI) - sine.atan2(cosine)) * f64x4::splat(2.0 / 3.0);
    Angles { cosine, sine, slope }
}

impl Angles {
    /// k
    pub fn value(&self) -> f64x4 {
        self.rest() + self.slope * self.cosine
    }

    /// k - c k'
    pub fn rest(&self) -> f64x4 {
        self.sine * f64x4::splat(2.0 / 3.0)
    }

    /// k''; bounded where the directions are the same or opposite: all that it multiplies vanishes there.
    pub fn bend(&self) -> f64x4 {
        f64x4::splat(2.0 / 3.0) / self.sine.max(f64x4::splat(f64::EPSILON))
    }
}

/// The kernel at one angle.
#[derive(Clone, Copy, Debug)]
pub struct Pair {
    cosine: f64,
    rest: f64,
    slope: f64,
    bend: f64,
}

/// The kernel between `l` and each of `others`.
pub fn pairs(l: DVec3, others: &[DVec3]) -> impl Iterator<Item = Pair> {
    others.chunks(4).flat_map(move |others| {
        let angles = angle(l, &Lanes::new(others));
        let [cosine, rest, slope, bend] =
            [angles.cosine, angles.rest(), angles.slope, angles.bend()].map(f64x4::to_array);
        let pair = move |i: usize| Pair { cosine: cosine[i], rest: rest[i], slope: slope[i], bend: bend[i] };
        (0..others.len()).map(pair)
    })
}

impl Pair {
    /// Twice by a, on its tangent plane: of b only what lies in it, for k'' may be large.
    pub fn second_derivative(&self, a: DVec3, b: DVec3) -> DMat3 {
        let across = b - a * self.cosine;
        DMat3::from_diagonal(DVec3::splat(self.rest)) + outer(across * self.bend, across)
    }

    /// By a and b: the moment `<v_a, v_b^T>`.
    pub fn mixed_derivative(&self, a: DVec3, b: DVec3) -> DMat3 {
        let across = outer((b - a * self.cosine) * self.bend, a - b * self.cosine);
        outer(a * self.rest, b) + across + DMat3::from_diagonal(DVec3::splat(self.slope))
    }
}

/// `a b^T`
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
