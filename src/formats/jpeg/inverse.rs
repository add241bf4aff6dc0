//! Inverse cosine transform of 8 x 8 blocks, to the bit that of libjpeg ("islow").
//!
//! C. Loeffler, A. Ligtenberg, G. Moschytz: Practical fast 1-D DCT algorithms with 11 multiplications (1989), in
//! integers with 13 bits after the point.

#![allow(clippy::inline_always, reason = "only inlined functions use the vectors of the processor")]

use std::num::Wrapping;

use super::frame::Block;

/// Integer that wraps around: damaged coefficients may have any size.
type Number = Wrapping<i32>;

/// Bits after the point of the constants.
const BITS: usize = 13;
/// Bits after the point between the two passes.
const BETWEEN: usize = 2;

/// Blocks that are transformed together.
pub(super) const GROUP: usize = 8;

/// Rows of a group of blocks, from left to right.
type Rows = [[Number; 8 * GROUP]; 8];

/// Memory of the transform.
pub(super) struct Workspace {
    rows: Rows,
    other: Rows,
}

impl Workspace {
    #[inline(always)]
    pub fn new() -> Self {
        let rows = [[Wrapping(0); 8 * GROUP]; 8];
        Self { rows, other: rows }
    }

    /// Write the samples of up to [`GROUP`] `blocks` of a row into rows of `out` that are `stride` apart.
    #[inline(always)]
    pub fn inverse(&mut self, blocks: &[Block], steps: &[i32; 64], stride: usize, out: &mut [u8]) {
        let Self { rows, other } = self;
        for (place, block) in blocks.iter().enumerate() {
            set_block(block, steps, 8 * place, rows);
        }
        transform_columns(rows, BITS - BETWEEN, other);
        transpose(other, rows);
        transform_columns(rows, BITS + BETWEEN + 3, other);
        transpose(other, rows);
        for (row, out) in rows.iter().zip(out.chunks_mut(stride)) {
            for (number, out) in row.iter().zip(&mut out[..8 * blocks.len()]) {
                *out = (number.0.clamp(-128, 127) + 128) as u8;
            }
        }
    }
}

/// Multiply the coefficients of a block by their steps, into some rows at a column.
#[inline(always)]
fn set_block(block: &Block, steps: &[i32; 64], column: usize, rows: &mut Rows) {
    for y in 0..8 {
        for x in 0..8 {
            rows[y][column + x] = Wrapping(i32::from(block[8 * y + x])) * Wrapping(steps[8 * y + x]);
        }
    }
}

/// Turn each block about its diagonal.
#[inline(always)]
fn transpose(rows: &Rows, columns: &mut Rows) {
    for place in (0..8 * GROUP).step_by(8) {
        for y in 0..8 {
            for x in 0..8 {
                columns[x][place + y] = rows[y][place + x];
            }
        }
    }
}

/// Transform each column of 8 numbers, and round to 2^`bits`. The loop becomes one of vectors.
#[inline(always)]
fn transform_columns(rows: &Rows, bits: usize, out: &mut Rows) {
    let half = Wrapping(1 << (bits - 1));
    for x in 0..8 * GROUP {
        let even = even_part(rows[0][x], rows[2][x], rows[4][x], rows[6][x]);
        let odd = odd_part(rows[7][x], rows[5][x], rows[3][x], rows[1][x]);
        for k in 0..4 {
            out[k][x] = (even[k] + odd[3 - k] + half) >> bits;
            out[7 - k][x] = (even[k] - odd[3 - k] + half) >> bits;
        }
    }
}

/// Product with a constant, which is rounded to [`BITS`].
#[inline(always)]
fn times(number: Number, constant: f64) -> Number {
    number * Wrapping((constant * f64::from(1 << BITS)).round() as i32)
}

#[inline(always)]
fn even_part(x0: Number, x2: Number, x4: Number, x6: Number) -> [Number; 4] {
    let z = times(x2 + x6, 0.541_196_1);
    let (a, b) = (z - times(x6, 1.847_759_065), z + times(x2, 0.765_366_865));
    let (sum, difference) = ((x0 + x4) << BITS, (x0 - x4) << BITS);
    [sum + b, difference + a, difference - a, sum - b]
}

#[inline(always)]
fn odd_part(x7: Number, x5: Number, x3: Number, x1: Number) -> [Number; 4] {
    let (z3, z4) = (x7 + x3, x5 + x1);
    let z5 = times(z3 + z4, 1.175_875_602);
    let (z1, z2) = (times(x7 + x1, 0.899_976_223), times(x5 + x3, 2.562_915_447));
    let (z3, z4) = (z5 - times(z3, 1.961_570_56), z5 - times(z4, 0.390_180_644));
    [
        times(x7, 0.298_631_336) - z1 + z3,
        times(x5, 2.053_119_869) - z2 + z4,
        times(x3, 3.072_711_026) - z2 + z3,
        times(x1, 1.501_321_11) - z1 + z4,
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
            let coefficients = std::array::from_fn(|_| {
                state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                if (state >> 8).is_multiple_of(sparse) { (state >> 20) as i16 % 200 - 100 } else { 0 }
            });
            let mut samples = [0; 64];
            Workspace::new().inverse(&[coefficients], &[1; 64], 8, &mut samples);
            for (y, row) in samples.chunks(8).enumerate() {
                for (x, &sample) in row.iter().enumerate() {
                    let wanted = exact(&coefficients, x, y);
                    assert!((f64::from(sample) - wanted).abs() < 0.6, "{x} {y}: {sample}, want {wanted}");
                }
            }
        }
    }
}
