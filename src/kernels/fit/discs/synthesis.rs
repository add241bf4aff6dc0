//! From harmonics to values: sums of them at a place, with their derivatives.

#![allow(clippy::inline_always, reason = "what is not inlined is compiled for the oldest of processors")]
#![allow(clippy::needless_range_loop, reason = "loops, not closures, are inlined")]

use pulp::{Arch, Simd, WithSimd};

use super::harmonics::{Harmonics, Rgb2};
use super::place::{Legendre, Place, RECURRENCE};
use super::zonal::{DEGREES, Factors};

/// A sum of harmonics at a place.
#[derive(Clone, Copy, Debug, Default)]
pub struct Sum {
    /// By channel.
    pub value: [f64; 3],
    /// By theta, by phi over the sine of theta, and by A, by channel.
    pub first: [[f64; 3]; 3],
    /// Second derivatives on the sphere and by A, of the channels with given shares.
    pub second: [[f64; 3]; 3],
}

impl Sum {
    /// Add a multiple of another.
    pub fn add(&mut self, other: &Self, factor: f64) {
        (0..3).for_each(|i| self.value[i] += factor * other.value[i]);
        for i in 0..3 {
            (0..3).for_each(|k| self.first[i][k] += factor * other.first[i][k]);
            (0..3).for_each(|k| self.second[i][k] += factor * other.second[i][k]);
        }
    }
}

impl Harmonics {
    /// Values at a place, each degree times its factor.
    pub fn value(&self, place: &Place, factors: &Factors) -> [f64; 3] {
        Arch::new().dispatch(Value { harmonics: self, place, factors })
    }

    /// The same with derivatives by the place and by the A of the factors; the second ones of the channels with these
    /// `shares`.
    pub fn sum(&self, place: &Place, factors: &Factors, shares: [f64; 3]) -> Sum {
        Arch::new().dispatch(Around { harmonics: self, place, factors, shares })
    }
}

/// See [`Harmonics::value`].
struct Value<'a> {
    harmonics: &'a Harmonics,
    place: &'a Place,
    factors: &'a Factors,
}

impl WithSimd for Value<'_> {
    type Output = [f64; 3];

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> [f64; 3] {
        let Self { harmonics, place, factors } = self;
        let mut legendre = Legendre::new(place.cosine, place.sine);
        let mut out = [0.0; 3];
        let mut rest = &harmonics.values[..];
        for m in 0..DEGREES {
            let column = &legendre.column(m)[m..];
            let (values, others) = rest.split_at(DEGREES - m);
            rest = others;
            let mut sum = [0.0; 8];
            for ((value, p), factor) in values.iter().zip(column).zip(&factors[m..]) {
                let weight = p * factor[0];
                (0..8).for_each(|i| sum[i] += weight * value[i]);
            }
            let (sin, cos) = (m as f64 * place.azimuth).sin_cos();
            (0..3).for_each(|c| out[c] += cos * sum[c] + sin * sum[4 + c]);
        }
        out
    }
}

/// See [`Harmonics::sum`].
///
/// With `P' = (l cos P_l - b_l P_(l-1)) / sin` by theta, where `b_l = (2l + 1) a_l`, and `P'' = -cot P' + (m^2 / sin^2 -
/// l (l + 1)) P`; along phi the first derivative is `m P / sin`, and the second is what Laplace's equation leaves.
struct Around<'a> {
    harmonics: &'a Harmonics,
    place: &'a Place,
    factors: &'a Factors,
    shares: [f64; 3],
}

/// Sums over the degrees of the order m, with the factors d of a disc and their derivatives by A: of `d P`, `d P' sin`,
/// `d_A P`, `-l (l + 1) d P`, `d_A P' sin`, `d_AA P`. Registers hold as many.
#[inline(always)]
fn order_sums(
    values: &[Rgb2],
    m: usize,
    column: &[f64; DEGREES],
    cosine: f64,
    factors: &Factors,
) -> [Rgb2; 6] {
    let mut sums = [[0.0; 8]; 6];
    let mut below = 0.0;
    for (l, value) in (m..DEGREES).zip(values) {
        let (p, degree) = (column[l], l as f64);
        let slope = degree * cosine * p - (2.0 * degree + 1.0) * RECURRENCE[m][l][0] * below;
        below = p;
        let [d, by_a, by_aa] = factors[l];
        let flat = d * p;
        let weights = [flat, d * slope, by_a * p, -degree * (degree + 1.0) * flat, by_a * slope, by_aa * p];
        for k in 0..6 {
            for i in 0..8 {
                sums[k][i] += weights[k] * value[i];
            }
        }
    }
    sums
}

impl WithSimd for Around<'_> {
    type Output = Sum;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Sum {
        let Self { harmonics, place, factors, shares } = self;
        let Place { cosine, sine, azimuth, .. } = *place;
        let (cot, over) = (cosine / sine, 1.0 / sine);
        let mut legendre = Legendre::new(cosine, sine);
        let mut out = Sum::default();
        let mut rest = &harmonics.values[..];
        for m in 0..DEGREES {
            let (values, others) = rest.split_at(DEGREES - m);
            rest = others;
            let sums = order_sums(values, m, legendre.column(m), cosine, factors);
            let (sin, cos) = (m as f64 * azimuth).sin_cos();
            let turn = m as f64 * over;
            for c in 0..3 {
                let (mut along, mut across) = ([0.0; 6], [0.0; 6]);
                for k in 0..6 {
                    along[k] = cos * sums[k][c] + sin * sums[k][4 + c];
                    across[k] = cos * sums[k][4 + c] - sin * sums[k][c];
                }
                let slope = over * along[1];
                out.value[c] += along[0];
                out.first[0][c] += slope;
                out.first[1][c] += turn * across[0];
                out.first[2][c] += along[2];
                let share = shares[c];
                out.second[0][0] += share * (turn * turn * along[0] - cot * slope + along[3]);
                out.second[0][1] += share * turn * (over * across[1] - cot * across[0]);
                out.second[1][1] += share * (cot * slope - turn * turn * along[0]);
                out.second[0][2] += share * over * along[4];
                out.second[1][2] += share * turn * across[2];
                out.second[2][2] += share * along[5];
            }
        }
        for (i, k) in [(1, 0), (2, 0), (2, 1)] {
            out.second[i][k] = out.second[k][i];
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernels::fit::discs::zonal::factors;
    use crate::kernels::sphere::{direction, exponential_map};

    #[test]
    fn derivatives_are_the_slopes_that_are_measured() {
        /// A changes more quickly.
        const STEPS: [f64; 3] = [1e-4, 1e-4, 1e-5];
        let mut harmonics = Harmonics::zero();
        for (theta, phi, share) in [(1.1, 2.0, 1e-3), (0.4, 0.3, 0.05), (2.2, 4.0, 0.2)] {
            harmonics.add_disc(direction(theta, phi), &factors(share), [3.0, 2.0, theta]);
        }
        let shares = [0.5, 0.3, -0.2];
        for l in [direction(0.7, 1.0), direction(1.2, 2.2), direction(3.0, 4.0)] {
            let share = 0.02;
            let place = Place::new(l);
            let sum = harmonics.sum(&place, &factors(share), shares);
            let at = |step: [f64; 3]| {
                let l = exponential_map(l, place.frame[0] * step[0] + place.frame[1] * step[1]);
                harmonics.value(&Place::new(l), &factors(share + step[2]))
            };
            let weighted = |step: [f64; 3]| -> f64 { at(step).iter().zip(shares).map(|(v, s)| v * s).sum() };
            let here = weighted([0.0; 3]);
            for i in 0..3 {
                let along = |a: f64, k: usize, b: f64| {
                    let mut step = [0.0; 3];
                    step[i] += a * STEPS[i];
                    step[k] += b * STEPS[k];
                    step
                };
                let (ahead, behind) = (at(along(1.0, i, 0.0)), at(along(-1.0, i, 0.0)));
                for c in 0..3 {
                    let slope = (ahead[c] - behind[c]) / (2.0 * STEPS[i]);
                    assert!(
                        (slope - sum.first[i][c]).abs() < 1e-4 * (1.0 + slope.abs()),
                        "{l} {i} {c} {slope} {sum:?}"
                    );
                }
                for (k, other_step) in STEPS.into_iter().enumerate() {
                    let corner = |a: f64, b: f64| weighted(along(a, k, b));
                    let bend = if i == k {
                        (weighted(along(1.0, i, 0.0)) + weighted(along(-1.0, i, 0.0)) - 2.0 * here)
                            / (STEPS[i] * other_step)
                    } else {
                        (corner(1.0, 1.0) - corner(1.0, -1.0) - corner(-1.0, 1.0) + corner(-1.0, -1.0))
                            / (4.0 * STEPS[i] * other_step)
                    };
                    let error = (bend - sum.second[i][k]).abs();
                    assert!(error < 1e-3 * (1.0 + bend.abs()), "{l} {i} {k} {bend} {sum:?}");
                }
            }
        }
    }
}
