//! From harmonics to values: sums of them at a place, with their derivatives.

#![allow(clippy::inline_always, reason = "what is not inlined is compiled for the oldest of processors")]

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
/// With `P' = (l cos P_l - b_l P_(l-1)) / sin` by theta, where `b_l = (2l + 1) a_l`, `P'' = -cot P' + (m^2 / sin^2 -
/// l (l + 1)) P`, and `R = m P / sin`; along phi the second derivative is what Laplace's equation leaves.
struct Around<'a> {
    harmonics: &'a Harmonics,
    place: &'a Place,
    factors: &'a Factors,
    shares: [f64; 3],
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
        let [mut tt, mut tp, mut laplace, mut ta, mut pa, mut aa] = [0.0; 6];
        for m in 0..DEGREES {
            let column = legendre.column(m);
            let (values, others) = rest.split_at(DEGREES - m);
            rest = others;
            let order = m as f64;
            let mut sums = [[0.0; 8]; 4];
            let mut bends = [[0.0; 2]; 6];
            for (l, value) in (m..DEGREES).zip(values) {
                let p = column[l];
                let below = if l > m { column[l - 1] } else { 0.0 };
                let degree = l as f64;
                let b = (2.0 * degree + 1.0) * RECURRENCE[m][l][0];
                let slope = (degree * cosine * p - b * below) * over;
                let eigenvalue = degree * (degree + 1.0);
                let bend = -cot * slope + (order * order * over * over - eigenvalue) * p;
                let round = order * p * over;
                let round_slope = (order * slope - round * cosine) * over;
                let [d, by_a, by_aa] = factors[l];
                let weights = [d * p, d * slope, d * round, by_a * p];
                for (sum, weight) in sums.iter_mut().zip(weights) {
                    (0..8).for_each(|i| sum[i] += weight * value[i]);
                }
                let both = [0, 4]
                    .map(|i| shares[0] * value[i] + shares[1] * value[i + 1] + shares[2] * value[i + 2]);
                let weights =
                    [d * bend, d * round_slope, -eigenvalue * d * p, by_a * slope, by_a * round, by_aa * p];
                for (sum, weight) in bends.iter_mut().zip(weights) {
                    (0..2).for_each(|i| sum[i] += weight * both[i]);
                }
            }
            let (sin, cos) = (order * azimuth).sin_cos();
            for c in 0..3 {
                let along = |sum: &Rgb2| cos * sum[c] + sin * sum[4 + c];
                out.value[c] += along(&sums[0]);
                out.first[0][c] += along(&sums[1]);
                out.first[1][c] += cos * sums[2][4 + c] - sin * sums[2][c];
                out.first[2][c] += along(&sums[3]);
            }
            let along = |sum: [f64; 2]| cos * sum[0] + sin * sum[1];
            let across = |sum: [f64; 2]| cos * sum[1] - sin * sum[0];
            tt += along(bends[0]);
            tp += across(bends[1]);
            laplace += along(bends[2]);
            ta += along(bends[3]);
            pa += across(bends[4]);
            aa += along(bends[5]);
        }
        out.second = [[tt, tp, ta], [tp, laplace - tt, pa], [ta, pa, aa]];
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
