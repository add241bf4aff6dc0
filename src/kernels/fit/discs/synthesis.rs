//! From harmonics to values: sums of them over discs side by side, with their derivatives.

#![allow(clippy::inline_always, reason = "what is not inlined is compiled for the oldest of processors")]
#![allow(clippy::needless_range_loop, reason = "loops, not closures, are inlined")]

use pulp::{Arch, Simd, WithSimd};

use super::abreast::Abreast;
use super::disc::Disc;
use super::harmonics::Harmonics;
use super::place::{Legendre, RECURRENCE};
use super::zonal::DEGREES;
use crate::kernels::fit::azimuthal::Rgb2;
use crate::kernels::fit::lanes::{Lanes, Number};

/// Derivatives of a sum at a place.
#[derive(Clone, Copy, Debug, Default)]
pub struct Sum {
    /// By theta, by phi over the sine of theta, and by A, by channel.
    pub first: [[f64; 3]; 3],
    /// Second derivatives on the sphere and by A, of the channels with given shares.
    pub second: [[f64; 3]; 3],
}

impl Sum {
    /// Add a multiple of another.
    pub fn add(&mut self, other: &Self, factor: f64) {
        for i in 0..3 {
            (0..3).for_each(|k| self.first[i][k] += factor * other.first[i][k]);
            (0..3).for_each(|k| self.second[i][k] += factor * other.second[i][k]);
        }
    }
}

impl Harmonics {
    /// Products with discs of flux 1, by channel.
    pub fn values(&self, discs: &[Disc]) -> Vec<[f64; 3]> {
        Arch::new().dispatch(Values { harmonics: self, discs })
    }

    /// Their derivatives, the second ones of the channels with these `shares`.
    pub fn sums(&self, discs: &[Disc], shares: &[[f64; 3]]) -> Vec<Sum> {
        Arch::new().dispatch(Sums { harmonics: self, discs, shares })
    }

    /// Those of each order, all degrees from the order on.
    fn orders(&self) -> impl Iterator<Item = &[Rgb2]> {
        let mut rest = &self.values[..];
        (0..DEGREES).map(move |m| rest.split_off(..DEGREES - m).unwrap_or(&[]))
    }
}

/// See [`Harmonics::values`].
struct Values<'a> {
    harmonics: &'a Harmonics,
    discs: &'a [Disc],
}

impl WithSimd for Values<'_> {
    type Output = Vec<[f64; 3]>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
        let Self { harmonics, discs } = self;
        let zero = Lanes::splat(simd, 0.0);
        let mut out = Vec::with_capacity(discs.len());
        for discs in discs.chunks(S::F64_LANES) {
            let mut block = Abreast::new(simd, discs, |disc| (&disc.place, disc.share));
            let mut legendre = Legendre::new(block.cosine, block.sine);
            let mut values = [zero; 3];
            for (m, harmonics) in harmonics.orders().enumerate() {
                let mut sums = [[zero; 3]; 2];
                let column = legendre.column(m);
                for (l, harmonic) in (m..DEGREES).zip(harmonics) {
                    let weight = column[l] * block.factors[l][0];
                    for side in 0..2 {
                        for c in 0..3 {
                            sums[side][c] =
                                sums[side][c].add_product(weight, zero.like(harmonic[4 * side + c]));
                        }
                    }
                }
                for c in 0..3 {
                    for side in 0..2 {
                        values[c] = values[c].add_product(block.turn[side], sums[side][c]);
                    }
                }
                block.advance();
            }
            for lane in 0..discs.len() {
                out.push([values[0].lane(lane), values[1].lane(lane), values[2].lane(lane)]);
            }
        }
        out
    }
}

/// See [`Harmonics::sums`].
///
/// With `P' = (l cos P_l - b_l P_(l-1)) / sin` by theta, where `b_l = (2l + 1) a_l`, and `P'' = -cot P' + (m^2 / sin^2 -
/// l (l + 1)) P`; along phi the first derivative is `m P / sin`, and the second is what Laplace's equation leaves.
struct Sums<'a> {
    harmonics: &'a Harmonics,
    discs: &'a [Disc],
    shares: &'a [[f64; 3]],
}

impl WithSimd for Sums<'_> {
    type Output = Vec<Sum>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
        let Self { harmonics, discs, shares } = self;
        let zero = Lanes::splat(simd, 0.0);
        let mut out = Vec::with_capacity(discs.len());
        for (discs, shares) in discs.chunks(S::F64_LANES).zip(shares.chunks(S::F64_LANES)) {
            let mut block = Abreast::new(simd, discs, |disc| (&disc.place, disc.share));
            let shares = [0, 1, 2].map(|c| Lanes::gathered(simd, shares, |share| share[c]));
            let mut legendre = Legendre::new(block.cosine, block.sine);
            let (mut first, mut second) = ([[zero; 3]; 3], [[zero; 3]; 3]);
            for (m, harmonics) in harmonics.orders().enumerate() {
                let sums = order_sums(&block, m, legendre.column(m), harmonics);
                add_order(&block, m, &sums, &shares, &mut first, &mut second);
                block.advance();
            }
            for lane in 0..discs.len() {
                let of = |sums: [[Lanes<S>; 3]; 3]| sums.map(|row| row.map(|sum| sum.lane(lane)));
                out.push(Sum { first: of(first), second: of(second) });
            }
        }
        out
    }
}

/// Sums over the degrees of the order m, by cosine and sine, with the factors d of the discs and their derivatives by A: of
/// `d P`, `d P' sin`, `d_A P`, `-l (l + 1) d P`, `d_A P' sin`, `d_AA P`, each by channel.
#[inline(always)]
fn order_sums<S: Simd>(
    block: &Abreast<S>,
    m: usize,
    column: &[Lanes<S>; DEGREES],
    harmonics: &[Rgb2],
) -> [[[Lanes<S>; 3]; 6]; 2] {
    let of = |value: f64| block.cosine.like(value);
    let mut weights = [[of(0.0); 6]; DEGREES];
    let mut below = of(0.0);
    for l in m..DEGREES {
        let (p, degree) = (column[l], l as f64);
        let slope = (below * of(-RECURRENCE[m][l][2])).add_product(block.cosine * of(degree), p);
        below = p;
        let [d, by_a, by_aa] = block.factors[l];
        let flat = d * p;
        weights[l] =
            [flat, d * slope, by_a * p, of(-degree * (degree + 1.0)) * flat, by_a * slope, by_aa * p];
    }
    let mut sums = [[[of(0.0); 3]; 6]; 2];
    // Registers hold the sums of three weights.
    for side in 0..2 {
        for half in [0, 3] {
            let mut part = [[of(0.0); 3]; 3];
            for (weights, harmonic) in weights[m..].iter().zip(harmonics) {
                for c in 0..3 {
                    let harmonic = of(harmonic[4 * side + c]);
                    for k in 0..3 {
                        part[k][c] = part[k][c].add_product(weights[half + k], harmonic);
                    }
                }
            }
            sums[side][half..half + 3].copy_from_slice(&part);
        }
    }
    sums
}

/// Add what an order contributes to the derivatives.
#[inline(always)]
fn add_order<S: Simd>(
    block: &Abreast<S>,
    m: usize,
    sums: &[[[Lanes<S>; 3]; 6]; 2],
    shares: &[Lanes<S>; 3],
    first: &mut [[Lanes<S>; 3]; 3],
    second: &mut [[Lanes<S>; 3]; 3],
) {
    let Abreast { sine, cosine, turn: [cos, sin], .. } = *block;
    let over = sine.recip();
    let (cot, order) = (cosine * over, over * over.like(m as f64));
    let mut along = [cos.like(0.0); 6];
    let mut across = along;
    for c in 0..3 {
        let share = shares[c];
        for k in 0..6 {
            let (even, odd) = (sums[0][k][c], sums[1][k][c]);
            let (here, beside) = (cos * even + sin * odd, cos * odd - sin * even);
            if k < 3 {
                let (row, slope) = [(1, order * beside), (0, over * here), (2, here)][k];
                first[row][c] = first[row][c] + slope;
            }
            along[k] = along[k].add_product(share, here);
            across[k] = across[k].add_product(share, beside);
        }
    }
    let (slope, bend) = (cot * over * along[1], order * order * along[0]);
    second[0][0] = second[0][0] + bend - slope + along[3];
    second[1][1] = second[1][1] + slope - bend;
    second[2][2] = second[2][2] + along[5];
    let mixed = [
        (0, 1, order * (over * across[1] - cot * across[0])),
        (0, 2, over * along[4]),
        (1, 2, order * across[2]),
    ];
    for (i, k, value) in mixed {
        second[i][k] = second[i][k] + value;
        second[k][i] = second[i][k];
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernels::fit::discs::place::Place;
    use crate::kernels::sphere::{direction, exponential_map};
    use glam::DVec3;

    fn disc(direction: DVec3, share: f64) -> Disc {
        Disc::new(direction, 2.0 * share.sqrt().asin())
    }

    #[test]
    fn derivatives_are_the_slopes_that_are_measured() {
        /// A changes more quickly.
        const STEPS: [f64; 3] = [1e-4, 1e-4, 1e-5];
        let mut harmonics = Harmonics::zero();
        for (theta, phi, share) in [(1.1, 2.0, 1e-3), (0.4, 0.3, 0.05), (2.2, 4.0, 0.2)] {
            harmonics.add_discs([(direction(theta, phi), share, [3.0, 2.0, theta])].into_iter());
        }
        let shares = [0.5, 0.3, -0.2];
        for l in [direction(0.7, 1.0), direction(1.2, 2.2), direction(3.0, 4.0)] {
            let share = 0.02;
            let place = Place::new(l);
            // Beside others, in a second vector.
            let discs: Vec<Disc> = (0..6).map(|i| disc(if i == 5 { l } else { -l }, share)).collect();
            let sum = harmonics.sums(&discs, &[[9.0; 3], [0.0; 3], [0.0; 3], [1.0; 3], [2.0; 3], shares])[5];
            let at = |step: [f64; 3]| {
                let l = exponential_map(l, place.frame[0] * step[0] + place.frame[1] * step[1]);
                harmonics.values(&[disc(l, share + step[2])])[0]
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
