//! Products of harmonics with discs, and their derivatives.

#![allow(clippy::inline_always, reason = "only inlined functions use the vectors of the processor")]
#![allow(clippy::needless_range_loop, reason = "loops, not closures, are inlined")]

use pulp::{Arch, Simd, WithSimd};

use super::addition::{Cap, CapBatch};
use super::legendre::RECURRENCE;
use super::{DEGREES, Harmonics, Rgb2};
use crate::kernels::lanes::{Lanes, Number};

/// The product of a distribution of light with a disc of flux 1, and its derivatives.
#[derive(Clone, Copy, Debug, Default)]
pub struct DiscSum<T = f64> {
    /// By channel.
    pub value: [T; 3],
    /// Derivatives by theta, by phi (divided by sin theta) and by A, for each channel.
    pub first: [[T; 3]; 3],
    /// Second derivatives on the sphere and by A, of a weighted sum of the channels.
    pub second: [[T; 3]; 3],
}

impl DiscSum {
    /// Add a multiple of another.
    pub fn add(&mut self, other: &Self, factor: f64) {
        for i in 0..3 {
            self.value[i] += factor * other.value[i];
            for k in 0..3 {
                self.first[i][k] += factor * other.first[i][k];
                self.second[i][k] += factor * other.second[i][k];
            }
        }
    }
}

impl<T: Number> DiscSum<T> {
    /// Zeros, with as many lanes as `like`.
    #[inline(always)]
    pub fn zero(like: T) -> Self {
        let zero = like.like(0.0);
        Self { value: [zero; 3], first: [[zero; 3]; 3], second: [[zero; 3]; 3] }
    }

    /// Convert every number.
    #[inline(always)]
    pub fn map(self, number: impl Fn(T) -> f64) -> DiscSum {
        let mut out = DiscSum::default();
        for i in 0..3 {
            out.value[i] = number(self.value[i]);
            for k in 0..3 {
                out.first[i][k] = number(self.first[i][k]);
                out.second[i][k] = number(self.second[i][k]);
            }
        }
        out
    }
}

impl Harmonics {
    /// Products with discs of flux 1, by channel.
    pub fn values(&self, caps: &[Cap]) -> Vec<[f64; 3]> {
        self.sums::<0>(caps, &vec![[0.0; 3]; caps.len()]).into_iter().map(|sum| sum.value).collect()
    }

    /// Products with discs of flux 1; if N > 0 their derivatives too, second ones of the channels with these `weights`.
    pub fn sums<const N: usize>(&self, caps: &[Cap], weights: &[[f64; 3]]) -> Vec<DiscSum> {
        Arch::new().dispatch(Synthesis::<N> { harmonics: self, caps, weights })
    }
}

/// See [`Harmonics::sums`].
///
/// The derivatives by theta are `P' = (l cos P_l - b_l P_(l-1)) / sin`, where `b_l = (2l + 1) a_l`, and
/// `P'' = -cot P' + (m^2 / sin^2 - l (l + 1)) P`. Along phi the first derivative is `m P / sin`, and the second follows
/// from Laplace's equation.
struct Synthesis<'a, const N: usize> {
    harmonics: &'a Harmonics,
    caps: &'a [Cap],
    weights: &'a [[f64; 3]],
}

impl<const N: usize> WithSimd for Synthesis<'_, N> {
    type Output = Vec<DiscSum>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
        let Self { harmonics, caps, weights } = self;
        let mut out = Vec::with_capacity(caps.len());
        for (caps, weights) in caps.chunks(S::F64_LANES).zip(weights.chunks(S::F64_LANES)) {
            let mut batch = CapBatch::new(simd, caps);
            let weights = [0, 1, 2].map(|c| Lanes::gather(simd, weights, |weight| weight[c]));
            let mut sum = DiscSum::zero(batch.cosine);
            for (m, harmonics) in harmonics.orders().enumerate() {
                let sums = order_sums::<N, S>(&mut batch, m, harmonics);
                add_order::<N, S>(&batch, m, &sums, &weights, &mut sum);
                batch.advance();
            }
            for lane in 0..caps.len() {
                out.push(sum.map(|number| number.lane(lane)));
            }
        }
        out
    }
}

/// Functions of theta and A whose sums over the degrees make up the derivatives of order N.
const fn functions(n: usize) -> usize {
    if n > 0 { 6 } else { 1 }
}

/// Sums over the degrees of the order m by cosine and sine, function and channel.
///
/// For the factors d of the discs and their derivatives by A, the functions are `d P`, `d P' sin`, `d_A P`,
/// `-l (l + 1) d P`, `d_A P' sin` and `d_AA P`.
#[inline(always)]
fn order_sums<const N: usize, S: Simd>(
    batch: &mut CapBatch<S>,
    m: usize,
    harmonics: &[Rgb2],
) -> [[[Lanes<S>; 3]; 6]; 2] {
    let (cosine, factors, column) = (batch.cosine, &batch.factors, batch.legendre.column(m));
    let of = |value: f64| cosine.like(value);
    let mut weights = [[of(0.0); 6]; DEGREES];
    let mut below = of(0.0);
    for l in m..DEGREES {
        let (p, [d, by_a, by_aa]) = (column[l], factors[l]);
        weights[l][0] = d * p;
        if N > 0 {
            let degree = l as f64;
            let derivative = (below * of(-RECURRENCE[m][l][2])).add_product(cosine * of(degree), p);
            let round = of(-degree * (degree + 1.0)) * weights[l][0];
            weights[l] = [weights[l][0], d * derivative, by_a * p, round, by_a * derivative, by_aa * p];
        }
        below = p;
    }
    let mut sums = [[[of(0.0); 3]; 6]; 2];
    // Sum 3 functions at a time, because registers hold no more.
    for start in (0..2 * functions(N)).step_by(3) {
        let count = (2 * functions(N) - start).min(3);
        let slots = [0, 1, 2].map(|i| ((start + i) / functions(N), (start + i) % functions(N)));
        let mut part = [[of(0.0); 3]; 3];
        for (weights, harmonic) in weights[m..].iter().zip(harmonics) {
            for i in 0..count {
                let (side, k) = slots[i];
                for c in 0..3 {
                    part[i][c] = part[i][c].add_product(weights[k], of(harmonic[(4 * side + c) % 8]));
                }
            }
        }
        for i in 0..count {
            let (side, k) = slots[i];
            sums[side][k] = part[i];
        }
    }
    sums
}

/// Add the contribution of an order to the derivatives.
#[inline(always)]
fn add_order<const N: usize, S: Simd>(
    batch: &CapBatch<S>,
    m: usize,
    sums: &[[[Lanes<S>; 3]; 6]; 2],
    weights: &[Lanes<S>; 3],
    sum: &mut DiscSum<Lanes<S>>,
) {
    let CapBatch { sine, cosine, turn: [cos, sin], .. } = *batch;
    for c in 0..3 {
        sum.value[c] = sum.value[c].add_product(cos, sums[0][0][c]).add_product(sin, sums[1][0][c]);
    }
    if N == 0 {
        return;
    }
    let over = sine.recip();
    let (cot, order) = (cosine * over, over * over.like(m as f64));
    let mut along = [cos.like(0.0); 6];
    let mut across = along;
    for c in 0..3 {
        for k in 0..6 {
            let (even, odd) = (sums[0][k][c], sums[1][k][c]);
            let (here, beside) = (cos * even + sin * odd, cos * odd - sin * even);
            if k < 3 {
                let (row, derivative) = [(1, order * beside), (0, over * here), (2, here)][k];
                sum.first[row][c] = sum.first[row][c] + derivative;
            }
            along[k] = along[k].add_product(weights[c], here);
            across[k] = across[k].add_product(weights[c], beside);
        }
    }
    let (by_theta, by_phi) = (cot * over * along[1], order * order * along[0]);
    let second = [
        (0, 0, by_phi - by_theta + along[3]),
        (1, 1, by_theta - by_phi),
        (2, 2, along[5]),
        (0, 1, order * (over * across[1] - cot * across[0])),
        (0, 2, over * along[4]),
        (1, 2, order * across[2]),
    ];
    for (i, k, value) in second {
        sum.second[i][k] = sum.second[i][k] + value;
        sum.second[k][i] = sum.second[i][k];
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernels::sphere::{direction, exponential_map};

    #[test]
    fn derivatives_are_central_differences() {
        /// Steps along the tangents and in A, which has larger higher derivatives.
        const STEPS: [f64; 3] = [1e-4, 1e-4, 1e-5];
        let mut harmonics = Harmonics::zero();
        for (theta, phi, share) in [(1.1, 2.0, 1e-3), (0.4, 0.3, 0.05), (2.2, 4.0, 0.2)] {
            harmonics.add_discs([(direction(theta, phi), share, [3.0, 2.0, theta])].into_iter());
        }
        let weights = [0.5, 0.3, -0.2];
        for l in [direction(0.7, 1.0), direction(1.2, 2.2), direction(3.0, 4.0)] {
            let here = Cap::new(l, 0.02);
            // Put the disc last among others, in a second vector.
            let discs: Vec<Cap> = (0..6).map(|i| Cap::new(if i == 5 { l } else { -l }, 0.02)).collect();
            let all_weights = [[9.0; 3], [0.0; 3], [0.0; 3], [1.0; 3], [2.0; 3], weights];
            let sum = harmonics.sums::<2>(&discs, &all_weights)[5];
            // Values by channel, and their weighted sum, after multiples of the steps i and k.
            let at = |i: usize, a: f64, k: usize, b: f64| {
                let mut step = [0.0; 3];
                step[i] += a * STEPS[i];
                step[k] += b * STEPS[k];
                let l = exponential_map(l, here.frame[0] * step[0] + here.frame[1] * step[1]);
                let [red, green, blue] = harmonics.values(&[Cap::new(l, 0.02 + step[2])])[0];
                [red, green, blue, red * weights[0] + green * weights[1] + blue * weights[2]]
            };
            for i in 0..3 {
                let (ahead, behind) = (at(i, 1.0, i, 0.0), at(i, -1.0, i, 0.0));
                for c in 0..3 {
                    let first = (ahead[c] - behind[c]) / (2.0 * STEPS[i]);
                    let error = (first - sum.first[i][c]).abs();
                    assert!(error < 1e-4 * (1.0 + first.abs()), "{l} {i} {c} {first} {sum:?}");
                }
                for k in 0..3 {
                    let corner = |a: f64, b: f64| at(i, a, k, b)[3];
                    let differences =
                        corner(1.0, 1.0) - corner(1.0, -1.0) - corner(-1.0, 1.0) + corner(-1.0, -1.0);
                    let second = differences / (4.0 * STEPS[i] * STEPS[k]);
                    let error = (second - sum.second[i][k]).abs();
                    assert!(error < 1e-3 * (1.0 + second.abs()), "{l} {i} {k} {second} {sum:?}");
                }
            }
        }
    }
}
