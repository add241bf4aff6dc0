//! Inverse cosine transform of 8 x 8 blocks, to the bit that of libjpeg ("islow").
//!
//! C. Loeffler, A. Ligtenberg, G. Moschytz: Practical fast 1-D DCT algorithms with 11 multiplications (1989), in
//! integers with 13 bits after the point.

#![allow(clippy::inline_always, reason = "only inlined functions use the vectors of the processor")]

use std::array::from_fn;
use std::ops::{Add, Mul, Sub};

/// Bits after the point of the constants.
const BITS: u32 = 13;
/// Bits after the point between the two passes.
const BETWEEN: u32 = 2;

/// Eight integers, which wrap around: damaged coefficients may have any size.
#[derive(Clone, Copy)]
struct Lanes([i32; 8]);

impl Add for Lanes {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self(from_fn(|lane| self.0[lane].wrapping_add(other.0[lane])))
    }
}

impl Sub for Lanes {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self(from_fn(|lane| self.0[lane].wrapping_sub(other.0[lane])))
    }
}

impl Mul<f64> for Lanes {
    type Output = Self;

    /// Product with a constant, which is rounded to [`BITS`].
    #[inline(always)]
    fn mul(self, constant: f64) -> Self {
        let factor = (constant * f64::from(1 << BITS)).round() as i32;
        Self(self.0.map(|lane| lane.wrapping_mul(factor)))
    }
}

impl Lanes {
    /// Quotient by 2^`bits`, rounded.
    #[inline(always)]
    fn rounded(self, bits: u32) -> Self {
        Self(self.0.map(|lane| lane.wrapping_add(1 << (bits - 1)) >> bits))
    }
}

/// Samples of a block of `coefficients`, rows of 8, with their steps of quantisation.
#[inline(always)]
pub(super) fn inverse(coefficients: &[i16; 64], steps: &[i32; 64]) -> [[u8; 8]; 8] {
    if coefficients[1..].iter().all(|&coefficient| coefficient == 0) {
        let mean = i32::from(coefficients[0]).wrapping_mul(steps[0]);
        return [[sample(mean.wrapping_add(4) >> 3); 8]; 8];
    }
    let rows = from_fn(|row| {
        Lanes(from_fn(|x| i32::from(coefficients[8 * row + x]).wrapping_mul(steps[8 * row + x])))
    });
    let columns = transposed(transform(rows).map(|lanes| lanes.rounded(BITS - BETWEEN)));
    let samples = transposed(transform(columns).map(|lanes| lanes.rounded(BITS + BETWEEN + 3)));
    samples.map(|lanes| lanes.0.map(sample))
}

/// Sample of a value around 0.
#[inline(always)]
fn sample(value: i32) -> u8 {
    value.clamp(-128, 127).wrapping_add(128) as u8
}

#[inline(always)]
fn transposed(rows: [Lanes; 8]) -> [Lanes; 8] {
    from_fn(|x| Lanes(from_fn(|y| rows[y].0[x])))
}

/// Transform in each lane, in units of 2^-[`BITS`] of those of its input.
#[inline(always)]
fn transform(input: [Lanes; 8]) -> [Lanes; 8] {
    let even = even_part(input[0], input[2], input[4], input[6]);
    let odd = odd_part(input[7], input[5], input[3], input[1]);
    from_fn(|k| if k < 4 { even[k] + odd[3 - k] } else { even[7 - k] - odd[k - 4] })
}

#[inline(always)]
fn even_part(x0: Lanes, x2: Lanes, x4: Lanes, x6: Lanes) -> [Lanes; 4] {
    let z = (x2 + x6) * 0.541_196_1;
    let (a, b) = (z - x6 * 1.847_759_065, z + x2 * 0.765_366_865);
    let (sum, difference) = ((x0 + x4) * 1.0, (x0 - x4) * 1.0);
    [sum + b, difference + a, difference - a, sum - b]
}

#[inline(always)]
fn odd_part(x7: Lanes, x5: Lanes, x3: Lanes, x1: Lanes) -> [Lanes; 4] {
    let (z3, z4) = (x7 + x3, x5 + x1);
    let z5 = (z3 + z4) * 1.175_875_602;
    let (z1, z2) = ((x7 + x1) * 0.899_976_223, (x5 + x3) * 2.562_915_447);
    let (z3, z4) = (z5 - z3 * 1.961_570_56, z5 - z4 * 0.390_180_644);
    [
        x7 * 0.298_631_336 - z1 + z3,
        x5 * 2.053_119_869 - z2 + z4,
        x3 * 3.072_711_026 - z2 + z3,
        x1 * 1.501_321_11 - z1 + z4,
    ]
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_1_SQRT_2, PI};

    use super::*;

    /// Definition of the transform (T.81, A.3.3).
    fn exact(coefficients: &[i16; 64], x: usize, y: usize) -> f64 {
        let cosine = |place: usize, order: usize| {
            let scale = if order == 0 { FRAC_1_SQRT_2 } else { 1.0 };
            scale * ((2 * place + 1) as f64 * order as f64 * PI / 16.0).cos()
        };
        let terms = (0..64).map(|k| f64::from(coefficients[k]) * cosine(x, k % 8) * cosine(y, k / 8));
        (terms.sum::<f64>() / 4.0 + 128.0).clamp(0.0, 255.0)
    }

    #[test]
    fn blocks_are_within_one_code_of_the_definition() {
        let mut state = 1_u32;
        for sparse in [1, 3, 20] {
            let coefficients = from_fn(|_| {
                state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                if (state >> 8).is_multiple_of(sparse) { (state >> 20) as i16 % 200 - 100 } else { 0 }
            });
            let samples = inverse(&coefficients, &[1; 64]);
            for (y, row) in samples.iter().enumerate() {
                for (x, &sample) in row.iter().enumerate() {
                    let wanted = exact(&coefficients, x, y);
                    assert!((f64::from(sample) - wanted).abs() < 0.6, "{x} {y}: {sample}, want {wanted}");
                }
            }
        }
    }
}
